//! Files that can be written without harm: they are no inputs, none is written twice, and their folders take them.

use std::{
    collections::{HashMap, HashSet},
    io::ErrorKind,
    path::{Path, PathBuf},
};

use mimesh_document::{At, Diagnostic, Kind, Location, Step, paths::identity};
use mimesh_markers::OTHER_OUTPUT_FOLDER;

use super::{
    capitals::{Capitals, existing_folder},
    file_names::too_long,
    findings::{Findings, Scope},
};
use crate::{
    compose::Variant,
    input::{InputFile, Prepared},
    placeholder::MAX_NAME,
    staging::not_a_file,
};

/// What the system takes for a path, in bytes, less what the name of a temporary file may have more than that of its place.
const MAX_PATH: usize = 4095 - 32;

/// The folder for results that was given beside the file.
#[derive(Debug)]
pub(super) struct Destination<'a> {
    /// The folder as it was given.
    pub given: &'a Path,
    /// The folder of this run's results: one of its own in the given folder, if there are several runs.
    pub folder: PathBuf,
}

impl<'a> Destination<'a> {
    /// The folder `given` for a run, or one of its own in it, if there are `several`.
    pub fn new(given: &'a Path, variant: &Variant, several: bool) -> Self {
        let folder = if several { given.join(&variant.name) } else { given.into() };
        Self { given, folder }
    }
}

/// The files that are to be written, by what the system takes them for.
#[derive(Default)]
pub(super) struct WritableFiles<'a> {
    /// The inputs with their roles.
    inputs: HashMap<PathBuf, &'static str>,
    /// The outputs so far.
    outputs: HashSet<PathBuf>,
    /// Inputs that have other names (hard links), by what the system numbers them.
    linked: HashMap<FileNumber, (PathBuf, &'static str)>,
    /// The inputs and outputs so far, for folders that ignore capitals.
    capitals: Capitals,
    /// Folders, and why no files can be made in them.
    folders: HashMap<PathBuf, Option<String>>,
    /// The folder for results that was given beside the file.
    given: Option<&'a Path>,
}

impl<'a> WritableFiles<'a> {
    /// No outputs yet, beside `inputs`.
    pub fn new(inputs: &[InputFile], out: Option<&Destination<'a>>) -> Self {
        let linked = |input: &InputFile| Some((linked_number(&input.path)?, (input.path.clone(), input.role)));
        let linked = inputs.iter().filter_map(linked).collect();
        let inputs: HashMap<_, _> = inputs.iter().map(|input| (identity(&input.path), input.role)).collect();
        let mut capitals = Capitals::default();
        inputs.keys().for_each(|input| _ = capitals.add(input));
        Self { inputs, linked, capitals, given: out.map(|out| out.given), ..Self::default() }
    }

    /// Adds `file`, which is named at `at`; `false`, and a diagnostic, if it cannot be written without harm.
    pub fn add(&mut self, scope: Scope<'_>, found: &mut Findings, file: &Path, at: &[Step]) -> bool {
        let diagnostic = self.check(scope, file, at);
        let fine = diagnostic.is_none();
        found.diagnostics.extend(diagnostic);
        fine
    }

    fn check(&mut self, scope: Scope<'_>, file: &Path, at: &[Step]) -> Option<Diagnostic> {
        let shown = file.display();
        let of_file = |message: String| scope.document.diagnostic(at, At::Value, message);
        let name = file.file_name().unwrap_or_default().to_string_lossy();
        let folder = existing_folder(file);
        // Some file systems take less.
        let is_refused = |name: &std::ffi::OsStr| match folder.join(name).symlink_metadata() {
            Err(error) => error.kind() == ErrorKind::InvalidFilename,
            Ok(_) => false,
        };
        if name.len() > MAX_NAME || file.file_name().is_some_and(is_refused) {
            return Some(of_file(too_long(&name)).hint("give the file a shorter name"));
        }
        let folders = file.parent().into_iter().flat_map(Path::components);
        if let Some(folder) = folders.map(|part| part.as_os_str()).find(|part| part.len() > MAX_NAME) {
            let start: String = folder.to_string_lossy().chars().take(40).collect();
            let bytes = folder.len();
            let message =
                format!("the name `{start}…` of a folder has {bytes} bytes, and file systems take {MAX_NAME}");
            return Some(of_file(message).hint("give the folder a shorter name"));
        }
        if file.as_os_str().len() > MAX_PATH {
            let message = format!("the path has {} bytes, and the system takes {MAX_PATH}", file.as_os_str().len());
            return Some(of_file(message).hint("write into a folder that lies less deep"));
        }
        let identity = identity(file);
        let twin = self.capitals.add(&identity);
        if let Some(role) = self.inputs.get(twin.as_ref().unwrap_or(&identity)) {
            let diagnostic = of_file(format!("{shown} would overwrite an input ({role})"));
            return Some(self.elsewhere(diagnostic, at));
        }
        if let Some((input, role)) = linked_number(file).and_then(|number| self.linked.get(&number)) {
            let message = format!("{shown} is another name (hard link) of an input, {} ({role})", input.display());
            return Some(self.elsewhere(of_file(message), at));
        }
        if let Some(kind) = not_a_file(file) {
            return Some(self.blocked(scope, format!("cannot write {shown}: there is {kind} of that name"), at));
        }
        if !folder.is_dir() {
            let message = format!("cannot write {shown}: {} is not a folder", folder.display());
            return Some(self.blocked(scope, message, at));
        }
        if twin.is_some() || !self.outputs.insert(identity) {
            let hint = match self.given {
                Some(_) => "all results go into one folder; give each output its own name",
                None => "give each output its own name; poses are told apart by `{pose}`",
            };
            return Some(of_file(format!("{shown} would be written twice")).hint(hint));
        }
        let problem = self.refusal(folder).or_else(|| not_ours(file, folder))?;
        Some(self.blocked(scope, format!("cannot write {shown}: {problem}"), at))
    }

    /// A diagnostic at the folder for results if one was given, whatever the file says.
    fn blocked(&self, scope: Scope<'_>, message: String, at: &[Step]) -> Diagnostic {
        let location = match self.given {
            Some(folder) => Location::OutputFolder(folder.into()),
            None => scope.document.location(at, At::Value),
        };
        self.elsewhere(Diagnostic::new(Kind::CannotWrite, message).at(location), at)
    }

    /// Adds the way out to write elsewhere.
    fn elsewhere(&self, diagnostic: Diagnostic, at: &[Step]) -> Diagnostic {
        match at.first() {
            _ if self.given.is_some() => {
                diagnostic.remedy(OTHER_OUTPUT_FOLDER, "", "choose another folder for the results")
            }
            Some(Step::Key(key)) if key == "output" => {
                diagnostic.hint("write into another folder, e.g. `out/{pose}.obj`")
            }
            _ => diagnostic.hint("choose another folder or name"),
        }
    }

    /// Why no new file can be made in `folder`, if so: found by making one without a name, which leaves no trace.
    fn refusal(&mut self, folder: &Path) -> Option<String> {
        let found = self.folders.entry(folder.into()).or_insert_with(|| {
            // Who cannot look into the folder cannot see whether somebody else writes there.
            let looked = folder.read_dir().map(drop);
            let error = looked.and_then(|()| tempfile::tempfile_in(folder).map(drop)).err()?;
            Some(match error.kind() {
                ErrorKind::PermissionDenied if folder.read_dir().is_err() => {
                    format!("no permission to look into {}", folder.display())
                }
                ErrorKind::PermissionDenied => format!("no permission to make files in {}", folder.display()),
                ErrorKind::ReadOnlyFilesystem => format!("the disk of {} is read-only", folder.display()),
                _ => format!("no files can be made in {}", folder.display()),
            })
        });
        found.clone()
    }
}

/// The device and the number that the system gives a file.
type FileNumber = (u64, u64);

/// The number of the file at `path`, if it has several names (hard links).
#[cfg(unix)]
fn linked_number(path: &Path) -> Option<FileNumber> {
    use std::os::unix::fs::MetadataExt;
    let found = path.metadata().ok()?;
    (found.is_file() && found.nlink() > 1).then(|| (found.dev(), found.ino()))
}

/// Elsewhere a file that is replaced under one name stays under its others, and nothing tells them.
#[cfg(not(unix))]
fn linked_number(_: &Path) -> Option<FileNumber> {
    None
}

/// Why `file`, which is there, cannot be replaced although its folder takes new files, if so: in a folder like `/tmp` everybody replaces
/// files of their own only.
#[cfg(unix)]
fn not_ours(file: &Path, folder: &Path) -> Option<String> {
    use std::os::unix::fs::MetadataExt;
    const STICKY: u32 = 0o1000;
    const SUPERUSER: u32 = 0;
    let (found, around) = (file.symlink_metadata().ok()?, folder.metadata().ok()?);
    if around.mode() & STICKY == 0 {
        return None;
    }
    let ours = tempfile::tempfile_in(folder).ok()?.metadata().ok()?.uid();
    let may = ours == SUPERUSER || ours == found.uid() || ours == around.uid();
    (!may).then(|| {
        format!(
            "it belongs to another user (number {}), and in {} only its owner replaces a file",
            found.uid(),
            folder.display()
        )
    })
}

/// Elsewhere folders have no such rule.
#[cfg(not(unix))]
fn not_ours(_: &Path, _: &Path) -> Option<String> {
    None
}

/// Gives runs that write into one folder reports of their own names; `others` are the reports of runs of the file that are not wanted.
pub(super) fn name_reports(runs: &mut [Prepared], others: &[PathBuf]) {
    let mut counts: HashMap<PathBuf, usize> = HashMap::new();
    for report in runs.iter().map(|run| &run.outputs.report).chain(others) {
        *counts.entry(identity(report)).or_default() += 1;
    }
    for run in runs.iter_mut() {
        if counts.get(&identity(&run.outputs.report)).is_some_and(|count| *count > 1) {
            run.outputs.report.set_file_name(format!("run-{}.json", run.variant.name));
        }
    }
}

/// The first file that one run writes and another reads or writes; it stands for them all.
pub(super) fn conflict(runs: &[Prepared]) -> Option<Diagnostic> {
    let mut written: HashMap<PathBuf, &Prepared> = HashMap::new();
    for run in runs {
        for file in run.outputs.files() {
            let other = written.insert(identity(file), run);
            if let Some(other) = other.filter(|other| other.variant != run.variant) {
                let names = format!("`{}` and `{}`", other.variant.name, run.variant.name);
                let message = format!("{} would be written by two runs, {names}", file.display());
                let diagnostic = Diagnostic::new(Kind::BadPipeline, message).at(Location::File(run.file.clone()));
                return Some(diagnostic.hint("put `{name}` into the names of outputs"));
            }
        }
    }
    for run in runs {
        for input in &run.inputs {
            if let Some(other) = written.get(&identity(&input.path)) {
                let (file, role, name) = (input.path.display(), input.role, &run.variant.name);
                let message = format!("{file} would overwrite an input ({role}) of the run `{name}`");
                let diagnostic = Diagnostic::new(Kind::BadPipeline, message).at(Location::File(other.file.clone()));
                return Some(diagnostic.hint("write into another folder, e.g. `out/{name}/{pose}.obj`"));
            }
        }
    }
    None
}
