//! What the checks of whole runs and of parts of a pipeline have in common.

use std::path::{Path, PathBuf};

use mimesh_core::plugin;
use mimesh_document::{At, Diagnostic, Kind, Step};
use serde_json::Value;

use super::findings::{Findings, Scope};
use crate::{
    file_on_disk::Reach,
    input::{HelpCommands, InputFile, ViewScript},
};

/// What a caller adds to a pipeline's file.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// `slot.key=value`, in the order given.
    pub settings: Vec<String>,
    /// The names of the runs that are wanted, of those that the file declares; all of them if it is empty.
    pub runs: Vec<String>,
    /// The folder for results, instead of those of the outputs.
    pub out: Option<PathBuf>,
    /// The name of the report, instead of `run.json`.
    pub report: Option<String>,
    /// Folders whose files meshes may open, beside their own and that of the pipeline.
    pub roots: Vec<PathBuf>,
    /// Whether stages may run programs of the user's; no file can say so.
    pub allow_commands: bool,
    /// The commands of the host that the page of the run names.
    pub help: HelpCommands,
    /// The script of the 3D view that a pipeline may ask for.
    pub view_script: ViewScript,
}

impl Options {
    /// Where files may lie that the meshes of the pipeline `file` refer to.
    pub(super) fn reach(&self, file: &Path) -> Reach {
        let folder = file.parent().unwrap_or(Path::new("")).to_path_buf();
        Reach::new(std::iter::once(folder).chain(self.roots.iter().cloned()))
    }
}

/// The fault of a check that refuses a mesh and does not say why.
pub(super) fn refused_without_reason() -> Diagnostic {
    Diagnostic::new(Kind::Internal, "a mesh was refused without a reason")
}

/// The files that declare what to run.
pub(super) fn pipeline_files(file: &Path, included: &[PathBuf]) -> Vec<InputFile> {
    let included = included.iter().map(|path| InputFile { role: "included pipeline", path: path.clone() });
    std::iter::once(InputFile { role: "pipeline", path: file.into() }).chain(included).collect()
}

/// Reports two plug-ins of one stage and name, which no YAML can distinguish.
pub(super) fn check_registry(found: &mut Findings) {
    for pair in plugin::all().windows(2) {
        let (stage, name) = (pair[0].stage, pair[0].name());
        if stage == pair[1].stage && name == pair[1].name() {
            let message = format!("two plug-ins are linked that are both the {stage} `{name}`");
            let hint = "rename the type of one of them, or leave its crate out";
            found.diagnostics.push(Diagnostic::new(Kind::Internal, message).hint(hint));
        }
    }
}

/// Reports two entries of `formats` for one type.
pub(super) fn check_formats(scope: Scope<'_>, found: &mut Findings) {
    let list = scope.document.value.get("formats").and_then(Value::as_array);
    let types: Vec<_> = list.into_iter().flatten().map(|format| format.get("type")).collect();
    for (i, name) in types.iter().enumerate() {
        if name.is_some() && types[..i].contains(name) {
            let at = [Step::Key("formats".into()), Step::Index(i), Step::Key("type".into())];
            found.wrong(scope, &at, At::Value, "a second entry for this format", "put all its settings into one entry");
        }
    }
}
