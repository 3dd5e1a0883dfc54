//! Files that can be written without harm: they are no inputs, none is written twice, and their folders take them.

use std::{
    collections::{HashMap, HashSet},
    io::ErrorKind,
    path::{Path, PathBuf},
};

use mimesh_document::{At, Diagnostic, Kind, Location, Step, paths::identity};
use mimesh_markers::OTHER_OUTPUT_FOLDER;

use super::{
    file_names::too_long,
    findings::{Findings, Scope},
};
use crate::{
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

/// The files that are to be written, by what the system takes them for.
#[derive(Default)]
pub(super) struct WritableFiles<'a> {
    /// The inputs with their roles.
    inputs: HashMap<PathBuf, &'static str>,
    /// The outputs so far.
    outputs: HashSet<PathBuf>,
    /// Folders, and why no files can be made in them.
    folders: HashMap<PathBuf, Option<String>>,
    /// The folder for results that was given beside the file.
    given: Option<&'a Path>,
}

impl<'a> WritableFiles<'a> {
    /// No outputs yet, beside `inputs`.
    pub fn new(inputs: &[InputFile], out: Option<&Destination<'a>>) -> Self {
        let inputs = inputs.iter().map(|input| (identity(&input.path), input.role)).collect();
        Self { inputs, given: out.map(|out| out.given), ..Self::default() }
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
        if let Some(role) = self.inputs.get(&identity) {
            let diagnostic = of_file(format!("{shown} would overwrite an input ({role})"));
            return Some(self.elsewhere(diagnostic, at));
        }
        if let Some(kind) = not_a_file(file) {
            return Some(self.blocked(scope, format!("cannot write {shown}: there is {kind} of that name"), at));
        }
        if !folder.is_dir() {
            let message = format!("cannot write {shown}: {} is not a folder", folder.display());
            return Some(self.blocked(scope, message, at));
        }
        if !self.outputs.insert(identity) {
            let hint = match self.given {
                Some(_) => "all results go into one folder; give each output its own name",
                None => "give each output its own name; poses are told apart by `{pose}`",
            };
            return Some(of_file(format!("{shown} would be written twice")).hint(hint));
        }
        let problem = self.refusal(folder)?;
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

/// The nearest folder around `file` that exists.
fn existing_folder(file: &Path) -> &Path {
    // A link that leads nowhere is there too.
    let exists = |folder: &&Path| folder.as_os_str().is_empty() || folder.symlink_metadata().is_ok();
    match file.ancestors().skip(1).find(exists) {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// Gives runs that write into one folder reports of their own names.
pub(super) fn name_reports(runs: &mut [Prepared]) {
    let mut counts: HashMap<PathBuf, usize> = HashMap::new();
    for run in runs.iter() {
        *counts.entry(identity(&run.outputs.report)).or_default() += 1;
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
