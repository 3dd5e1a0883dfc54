use std::{
    collections::{HashMap, HashSet},
    io::ErrorKind,
    path::{Path, PathBuf},
};

use super::{Check, PoseInput, Prepared};
use crate::{
    diagnostic::Kind,
    diagnostic::{Diagnostic, Location},
    pipeline::{At, Pipeline, Step, Writes, document::path, resolve},
};

/// What a run writes.
#[derive(Clone, Debug, Default)]
pub struct Outputs {
    /// The results, in the order of the pipeline.
    pub meshes: Vec<Output>,
    /// Where the correspondence is kept, if it is.
    pub correspondence: Option<PathBuf>,
    /// Pages to look at the results.
    pub pages: Vec<PathBuf>,
    /// Sheets of pictures.
    pub sheets: Vec<PathBuf>,
    /// The report of the run, beside the first result.
    pub report: PathBuf,
}

impl Outputs {
    /// Every file that a run writes.
    pub fn places(&self) -> Vec<&Path> {
        let meshes = self.meshes.iter().flat_map(|output| match output {
            Output::Poses(paths) => paths.as_slice(),
            Output::Sequence(path) => std::slice::from_ref(path),
        });
        let looks = self.pages.iter().chain(&self.sheets);
        meshes.chain(looks).chain(&self.correspondence).chain([&self.report]).map(PathBuf::as_path).collect()
    }
}

/// Results of one pattern.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Output {
    /// A file a pose, in the order of poses.
    Poses(Vec<PathBuf>),
    /// One file for rest and poses.
    Sequence(PathBuf),
}

impl Check<'_> {
    pub(super) fn outputs(&mut self, pipeline: &Pipeline, poses: &[PoseInput], out: Option<&Out<'_>>) -> Outputs {
        let place = |at: &[Step], path: &Path| match (out, path.file_name()) {
            (Some(out), Some(name)) => resolve::tidy(&out.folder.join(name)),
            _ => self.path(at, path),
        };
        // An item that is no text has been told, and an empty one stands in its place.
        let items = pipeline.output.items.iter().enumerate().filter(|(_, item)| !item.is_empty());
        let patterns: Vec<(usize, PathBuf)> =
            items.map(|(i, item)| (i, place(&output_at(pipeline, i), Path::new(item)))).collect();
        let correspondence =
            pipeline.keep_correspondence.as_deref().map(|file| place(&path(["keep_correspondence"]), file));
        let mut outputs = Outputs { correspondence, ..Outputs::default() };
        let read = self.inputs.iter().map(|input| (resolve::identity(&input.path), input.role));
        let mut places = Places { read: read.collect(), out: out.map(|out| out.typed), ..Places::default() };
        self.empty_texts(&path(["output"]));
        if pipeline.output.listed && pipeline.output.items.is_empty() {
            self.wrong(&path(["output"]), At::Value, "the list of outputs is empty", "e.g. `output: out/{pose}.obj`");
        }
        let before = self.diagnostics.len();
        for (i, pattern) in &patterns {
            let at = output_at(pipeline, *i);
            if let Some(kind) = Look::of(pattern) {
                if self.look(pattern, &at) && self.writable(pattern, &at, &mut places) {
                    match kind {
                        Look::Page => outputs.pages.push(pattern.clone()),
                        Look::Sheet => outputs.sheets.push(pattern.clone()),
                    }
                }
            } else if let Some(output) = self.output(pattern, poses, &at) {
                // One file tells what is wrong with all of a pattern.
                let _ = output.files().iter().all(|file| self.writable(file, &at, &mut places));
                outputs.meshes.push(output);
            }
        }
        if let Some(file) = &outputs.correspondence {
            let at = path(["keep_correspondence"]);
            if file.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("json")) {
                self.writable(file, &at, &mut places);
            } else {
                let hint = "e.g. `keep_correspondence: pairs.json`";
                self.wrong(&at, At::Value, "a correspondence is kept as .json", hint);
            }
        }
        if let Some(folder) = patterns.first().and_then(|(_, first)| first.parent()) {
            outputs.report = folder.join("run.json");
            // It lies beside the first result; what is wrong with that is wrong with it too.
            if self.diagnostics.len() == before {
                self.writable(&outputs.report, &path(["output"]), &mut places);
            }
        }
        outputs
    }

    /// Whether `pattern` can name a page or a sheet.
    fn look(&mut self, pattern: &Path, at: &[Step]) -> bool {
        let text = pattern.to_string_lossy();
        let placeholder = resolve::placeholders(&text).first().map(|name| format!("{{{name}}}"));
        if let Some(placeholder) = &placeholder {
            let message = format!("{} shows all poses, so its name cannot have `{placeholder}`", pattern.display());
            self.wrong(at, At::Value, message, format!("remove `{placeholder}`"));
        }
        placeholder.is_none()
    }

    fn output(&mut self, pattern: &Path, poses: &[PoseInput], at: &[Step]) -> Option<Output> {
        let text = pattern.to_string_lossy();
        let name = pattern.file_name().unwrap_or_default().to_string_lossy();
        if let Some(other) = resolve::placeholders(&name).into_iter().find(|name| *name != "pose") {
            self.wrong(
                at,
                At::Value,
                format!("unknown placeholder `{{{other}}}`"),
                "`{pose}` stands for the pose's name",
            );
            return None;
        }
        let writes = match self.formats.writer(pattern) {
            Ok((_, writes)) => writes,
            Err(unknown) => {
                self.wrong(at, At::Value, unknown.message, unknown.hint);
                return None;
            }
        };
        match (writes, text.contains("{pose}")) {
            (Writes::Pose, true) => {
                let file = |pose: &PoseInput| PathBuf::from(resolve::with_pose(&text, &pose.name));
                Some(Output::Poses(poses.iter().map(file).collect()))
            }
            (Writes::Sequence, false) => Some(Output::Sequence(pattern.into())),
            (Writes::Pose, false) => {
                let extension = pattern.extension().unwrap_or_default().to_string_lossy();
                let stem = resolve::stem(pattern);
                let message = format!("a .{extension} file holds one pose, so its name needs `{{pose}}`");
                self.wrong(at, At::Value, message, format!("e.g. `{stem}-{{pose}}.{extension}`"));
                None
            }
            (Writes::Sequence, true) => {
                let extension = pattern.extension().unwrap_or_default().to_string_lossy();
                let message = format!("a .{extension} file holds all poses, so its name cannot have `{{pose}}`");
                self.wrong(at, At::Value, message, "remove `{pose}`");
                None
            }
        }
    }

    /// Checks that `file` can be written without harm: it is no input, no folder, nothing else is written there, and
    /// new files may be made in its folder.
    fn writable(&mut self, file: &Path, at: &[Step], places: &mut Places) -> bool {
        let identity = resolve::identity(file);
        let shown = file.display();
        let out = places.out;
        let hint = match (out, at.first()) {
            (Some(_), _) => "choose another folder for `--out`",
            (None, Some(Step::Key(key))) if key == "output" => "write into another folder, e.g. `out/{pose}.obj`",
            (None, _) => "choose another folder or name",
        };
        let wrong = |message: String, hint: &str| Some(self.document.diagnostic(at, At::Value, message).hint(hint));
        // Where results go is the option's doing, whatever the file says.
        let blocked = |message: String| {
            let place = match out {
                Some(out) => Location::Option(format!("--out {}", out.display())),
                None => self.document.location(at, At::Value),
            };
            Some(Diagnostic::new(Kind::CannotWrite, message).at(place).hint(hint))
        };
        let folder = file.ancestors().skip(1).find(|a| a.as_os_str().is_empty() || a.exists()).unwrap_or(Path::new(""));
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        let diagnostic = if let Some(role) = places.read.get(&identity) {
            wrong(format!("{shown} would overwrite an input ({role})"), hint)
        } else if file.is_dir() {
            blocked(format!("cannot write {shown}: there is a folder of that name"))
        } else if !folder.is_dir() {
            blocked(format!("cannot write {shown}: {} is not a folder", folder.display()))
        } else if !places.written.insert(identity) {
            let hint = match out {
                Some(_) => "`--out` puts all results into one folder; give each output its own name",
                None => "give each output its own name; poses are told apart by `{pose}`",
            };
            wrong(format!("{shown} would be written twice"), hint)
        } else if let Some(problem) = places.refuses(folder) {
            blocked(format!("cannot write {shown}: {problem}"))
        } else {
            None
        };
        let fine = diagnostic.is_none();
        self.diagnostics.extend(diagnostic);
        fine
    }
}

/// What is made to be looked at.
enum Look {
    Page,
    Sheet,
}

impl Look {
    fn of(path: &Path) -> Option<Self> {
        match path.extension()?.to_string_lossy().to_lowercase().as_str() {
            "html" | "htm" => Some(Self::Page),
            "png" => Some(Self::Sheet),
            _ => None,
        }
    }
}

/// The folder for results that the command line gives.
#[derive(Debug)]
pub(super) struct Out<'a> {
    /// As it was given.
    pub typed: &'a Path,
    /// Where the results of this run go: a folder of its own in that, if there are several runs.
    pub folder: PathBuf,
}

/// Where item `i` of the outputs is.
fn output_at(pipeline: &Pipeline, i: usize) -> Vec<Step> {
    let mut at = path(["output"]);
    if pipeline.output.listed {
        at.push(Step::Index(i));
    }
    at
}

/// Gives runs that write into one folder reports of their own names, and finds files that one run writes and another reads or
/// writes.
pub(super) fn apart(all: &mut [Prepared]) -> Vec<Diagnostic> {
    let mut reports: HashMap<PathBuf, usize> = HashMap::new();
    for one in all.iter() {
        *reports.entry(resolve::identity(&one.outputs.report)).or_default() += 1;
    }
    for one in all.iter_mut() {
        if reports.get(&resolve::identity(&one.outputs.report)).is_some_and(|count| *count > 1) {
            one.outputs.report.set_file_name(format!("run-{}.json", one.variant.name));
        }
    }
    let mut diagnostics = Vec::new();
    let mut written: HashMap<PathBuf, &Prepared> = HashMap::new();
    for one in all.iter() {
        for file in one.outputs.places() {
            let other = written.insert(resolve::identity(file), one);
            if let Some(other) = other.filter(|other| other.variant != one.variant) {
                let runs = format!("`{}` and `{}`", other.variant.name, one.variant.name);
                let message = format!("{} would be written by two runs, {runs}", file.display());
                let diagnostic = Diagnostic::new(Kind::BadPipeline, message).at(Location::File(one.file.clone()));
                diagnostics.push(diagnostic.hint("put `{name}` into the names of outputs"));
            }
        }
    }
    for one in all.iter() {
        for input in &one.inputs {
            if let Some(other) = written.get(&resolve::identity(&input.path)) {
                let message = format!("{} would overwrite an input ({})", input.path.display(), input.role);
                let message = format!("{message} of the run `{}`", one.variant.name);
                let diagnostic = Diagnostic::new(Kind::BadPipeline, message).at(Location::File(other.file.clone()));
                diagnostics.push(diagnostic.hint("write into another folder, e.g. `out/{name}/{pose}.obj`"));
            }
        }
    }
    // One tells what is wrong with them all.
    diagnostics.truncate(1);
    diagnostics
}

/// Files by what the system takes them for.
#[derive(Default)]
struct Places<'a> {
    /// Inputs, and what they are.
    read: HashMap<PathBuf, &'static str>,
    /// Outputs so far.
    written: HashSet<PathBuf>,
    /// Folders, and why no files can be made in them.
    folders: HashMap<PathBuf, Option<String>>,
    /// The folder of `--out`.
    out: Option<&'a Path>,
}

impl Places<'_> {
    /// Why no new file can be made in `folder`, if so: found by making one without a name, which leaves no trace.
    fn refuses(&mut self, folder: &Path) -> Option<String> {
        let found = self.folders.entry(folder.into()).or_insert_with(|| {
            let error = tempfile::tempfile_in(folder).err()?;
            Some(match error.kind() {
                ErrorKind::PermissionDenied => format!("no permission to make files in {}", folder.display()),
                ErrorKind::ReadOnlyFilesystem => format!("the disk of {} is read-only", folder.display()),
                _ => format!("no files can be made in {}", folder.display()),
            })
        });
        found.clone()
    }
}

impl Output {
    /// The files.
    pub fn files(&self) -> &[PathBuf] {
        match self {
            Self::Poses(files) => files,
            Self::Sequence(file) => std::slice::from_ref(file),
        }
    }
}
