//! Checking the files that a run is to write.

use std::path::{Path, PathBuf};

use mimesh_core::{
    mesh::PosesAre,
    stage::{MeshWriter, RestShape},
};
use mimesh_document::{At, Step, path, paths};
use serde_json::Value;

use super::{
    common::Options,
    file_names::check_file_names,
    findings::{Findings, Scope},
    writable::{Destination, WritableFiles},
};
use crate::{
    choices::is_open,
    compose::Run,
    formats::Writes,
    input::{Output, Outputs, PoseInput, RestMesh, poses_are},
    placeholder::{POSE, placeholders, with_pose},
    spec::Pipeline,
};

/// The name of a report where the caller gives none.
pub(super) const REPORT: &str = "run.json";

/// The files that a run writes, as far as they can be known; `out` takes all results if it is given, and the file `report` beside the
/// first of them the report.
pub(super) fn outputs(
    scope: Scope<'_>,
    found: &mut Findings,
    pipeline: &Pipeline,
    target: Option<&RestMesh>,
    poses: &[PoseInput],
    out: Option<&Destination<'_>>,
    report: &str,
) -> Outputs {
    let slot = path(["output"]);
    let are = poses_are(pipeline.source.poses_are, poses);
    let mut files = WritableFiles::new(&found.inputs, out);
    found.check_empty(scope, &slot);
    if pipeline.output.listed && pipeline.output.items.is_empty() {
        let message = "the sequence of outputs is empty";
        found.wrong(scope, &slot, At::Value, message, "e.g. `output: out/{pose}.obj`");
    }
    let mut outputs = Outputs::default();
    let before = found.diagnostics.len();
    // An item that is no string has a diagnostic of its own, and an empty one stands in its place.
    for (i, item) in pipeline.output.items.iter().enumerate().filter(|(_, item)| !item.is_empty()) {
        let at = if pipeline.output.listed { [&slot[..], &[Step::Index(i)]].concat() } else { slot.clone() };
        let pattern = destination(scope, out, &at, Path::new(item));
        if outputs.report.as_os_str().is_empty() {
            outputs.report = pattern.parent().unwrap_or(Path::new("")).join(report);
        }
        // Folders that are given beside the file may be called anything.
        if let Some((message, hint)) = wrong_placeholder(item) {
            found.wrong(scope, &at, At::Value, message, hint);
        } else if let Some(visual) = VisualOutput::of(&pattern) {
            if has_no_placeholder(scope, found, item, &at) && files.add(scope, found, &pattern, &at) {
                match visual {
                    VisualOutput::Page => outputs.pages.push(pattern),
                    VisualOutput::Sheet => outputs.sheets.push(pattern),
                }
            }
        } else if let Some(output) = output(scope, found, &pattern, poses, &at) {
            let names_fit = match &output {
                Output::Poses(files) => check_file_names(scope, found, poses, &pattern, files, &at),
                Output::Sequence(file) => {
                    check_size(scope, found, file, target, (poses, are), &at);
                    warn_of_clip(found, file, target);
                    true
                }
            };
            // The first file that cannot be written stands for all of a pattern.
            let _ = names_fit && output.files().iter().all(|file| files.add(scope, found, file, &at));
            outputs.meshes.push(output);
        }
    }
    let fine = found.diagnostics.len() == before;
    if let Some(file) = pipeline.keep_correspondence.as_deref() {
        let at = path(["keep_correspondence"]);
        if let Some(name) = placeholders(&file.to_string_lossy()).first() {
            let message = format!("the correspondence is one file, so its name cannot have `{{{name}}}`");
            found.wrong(scope, &at, At::Value, message, format!("remove `{{{name}}}`"));
        }
        let file = destination(scope, out, &at, file);
        let given = scope.document.value.get("correspondence").is_some_and(|value| !is_open(Some(value)));
        if pipeline.transfer.is_some() && pipeline.correspondence.is_none() && !given {
            let hint = "add e.g. `correspondence: { type: nonrigid_fit }`, or remove `keep_correspondence`";
            found.wrong(scope, &at, At::Key, "`keep_correspondence` without `correspondence`", hint);
        }
        if file.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("json")) {
            files.add(scope, found, &file, &at);
        } else {
            let hint = "e.g. `keep_correspondence: pairs.json`";
            found.wrong(scope, &at, At::Value, "a correspondence is written as .json", hint);
        }
        outputs.correspondence = Some(file);
    }
    // The report lies beside the first result; what is wrong with that is wrong with the report too.
    if fine && !outputs.report.as_os_str().is_empty() {
        files.add(scope, found, &outputs.report, &slot);
    }
    outputs
}

/// Finds a file of all poses that would be larger than its format allows; shapes are left to the run, since few vertices may move.
fn check_size(
    scope: Scope<'_>,
    found: &mut Findings,
    file: &Path,
    target: Option<&RestMesh>,
    (poses, are): (&[PoseInput], PosesAre),
    at: &[Step],
) {
    let (Ok((format, _)), Some(target), true) = (scope.formats.writer(file), target, are == PosesAre::Frames) else {
        return;
    };
    if let Some(MeshWriter::Sequence(format)) = format.writer()
        && let Err(error) = format.check_size(&target.sequence.rest, poses.len())
    {
        found.wrong(scope, at, At::Value, error.to_string(), error.hint().unwrap_or_default());
    }
}

/// Warns that the shapes of a target that rests in a clip belong to the skeleton as it is then.
fn warn_of_clip(found: &mut Findings, file: &Path, target: Option<&RestMesh>) {
    let Some(RestShape::Clip { name, seconds }) = target.map(|target| &target.selection.rest) else { return };
    found.warnings.push(format!(
        "{}: the target rests in the clip `{name}` at {seconds} s: its new shapes are right where the skeleton stands as it does then; \
         clips that show them hold it there",
        file.display()
    ));
}

/// Where `run`, one of `several` of a file or the only one, writes its report; `None` if it names no output.
pub(super) fn report_place(run: &Run, options: &Options, several: bool) -> Option<PathBuf> {
    let slot = path(["output"]);
    let value = run.document.value.get("output")?;
    let is_named = |value: &Value| value.as_str().is_some_and(|item| !item.is_empty());
    let (item, at) = match value.as_array() {
        Some(items) => {
            let i = items.iter().position(is_named)?;
            (&items[i], [&slot[..], &[Step::Index(i)]].concat())
        }
        None => (value, slot),
    };
    let first = Path::new(item.as_str()?);
    let out = options.out.as_deref().map(|given| Destination::new(given, &run.variant, several));
    let first = match (out, first.file_name()) {
        (Some(out), Some(name)) => paths::tidy(&out.folder.join(name)),
        _ => paths::from_base(run.document.folder(&at), first),
    };
    Some(first.parent().unwrap_or(Path::new("")).join(options.report.as_deref().unwrap_or(REPORT)))
}

/// The file that `path`, written at `at`, stands for.
fn destination(scope: Scope<'_>, out: Option<&Destination<'_>>, at: &[Step], path: &Path) -> PathBuf {
    match (out, path.file_name()) {
        (Some(out), Some(name)) => paths::tidy(&out.folder.join(name)),
        _ => scope.path(at, path),
    }
}

/// An output that shows all poses to people.
#[derive(Clone, Copy, Debug)]
enum VisualOutput {
    Page,
    Sheet,
}

impl VisualOutput {
    fn of(path: &Path) -> Option<Self> {
        match path.extension()?.to_string_lossy().to_lowercase().as_str() {
            "html" | "htm" => Some(Self::Page),
            "png" => Some(Self::Sheet),
            _ => None,
        }
    }
}

/// What is wrong with the placeholders of `pattern`, as the pipeline spells it, and the way out.
fn wrong_placeholder(pattern: &str) -> Option<(String, String)> {
    if let Some(other) = placeholders(pattern).into_iter().find(|name| *name != "pose") {
        return Some((format!("unknown placeholder `{{{other}}}`"), "`{pose}` stands for the pose's name".into()));
    }
    let (folder, name) = pattern.rsplit_once('/')?;
    folder.contains(POSE).then(|| {
        let name = if name.contains(POSE) { name.into() } else { format!("{{pose}}-{name}") };
        ("`{pose}` in the name of a folder: poses share their folder".into(), format!("e.g. `out/{name}`"))
    })
}

/// Whether `pattern` can name a page or a sheet; a diagnostic if not.
fn has_no_placeholder(scope: Scope<'_>, found: &mut Findings, pattern: &str, at: &[Step]) -> bool {
    let Some(name) = placeholders(pattern).first().copied() else { return true };
    let message = format!("{pattern} shows all poses, so its name cannot have `{{{name}}}`");
    found.wrong(scope, at, At::Value, message, format!("remove `{{{name}}}`"));
    false
}

/// The results that `pattern` stands for.
fn output(scope: Scope<'_>, found: &mut Findings, pattern: &Path, poses: &[PoseInput], at: &[Step]) -> Option<Output> {
    let name = pattern.file_name().unwrap_or_default().to_string_lossy();
    let writes = match scope.formats.writer(pattern) {
        Ok((_, writes)) => writes,
        Err(unknown) => {
            found.wrong(scope, at, At::Value, unknown.message, unknown.hint);
            return None;
        }
    };
    let extension = pattern.extension().unwrap_or_default().to_string_lossy();
    match (writes, name.contains(POSE)) {
        (Writes::Pose, true) => {
            let file = |pose: &PoseInput| pattern.with_file_name(with_pose(&name, &pose.name));
            Some(Output::Poses(poses.iter().map(file).collect()))
        }
        (Writes::Sequence, false) => Some(Output::Sequence(pattern.into())),
        (Writes::Pose, false) => {
            let stem = paths::stem(pattern);
            let message = format!("a .{extension} file holds one pose, so its name needs `{{pose}}`");
            found.wrong(scope, at, At::Value, message, format!("e.g. `{stem}-{{pose}}.{extension}`"));
            None
        }
        (Writes::Sequence, true) => {
            let message = format!("a .{extension} file holds all poses, so its name cannot have `{{pose}}`");
            found.wrong(scope, at, At::Value, message, "remove `{pose}`");
            None
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn poses_are_told_apart_by_the_name_of_their_file() {
        for fine in ["{pose}.obj", "out/{pose}.obj", "out/all.glb", "a{b.obj"] {
            assert_eq!(wrong_placeholder(fine), None, "{fine}");
        }
        let (message, hint) = wrong_placeholder("of/{pose}/mesh.obj").unwrap();
        assert_eq!(message, "`{pose}` in the name of a folder: poses share their folder");
        assert_eq!(hint, "e.g. `out/{pose}-mesh.obj`");
        for unknown in ["{who}/{pose}.obj", "out/{who}.obj"] {
            assert_eq!(wrong_placeholder(unknown).unwrap().0, "unknown placeholder `{who}`", "{unknown}");
        }
    }
}
