//! Units and axes that a pipeline says: of the meshes, of files of poses, of results.

use std::collections::BTreeSet;

use mimesh_core::spatial::{MeshUnits, UnitAxes};
use mimesh_document::{At, Document, path};
use serde_json::Value;

use super::{
    findings::{Findings, Scope},
    rest_meshes::at_file,
};
use crate::{
    formats::Formats,
    input::{OutputChange, Outputs, RestMesh},
    pose_files::Poses,
    rest::Rest,
    spec::{Pipeline, Source, Target},
};

/// The unit and axes of the source, as far as the pipeline or the format of its file says them.
pub(super) fn of_source(scope: Scope<'_>, source: &Source) -> MeshUnits {
    let said = MeshUnits { unit: source.unit, up: source.up };
    said.or(of_file(scope, "source", source.rest.as_ref()))
}

/// The unit and axes of the target, as far as the pipeline or the format of its file says them.
pub(super) fn of_target(scope: Scope<'_>, target: &Target) -> MeshUnits {
    let said = MeshUnits { unit: target.unit, up: target.up };
    said.or(of_file(scope, "target", target.rest.as_ref()))
}

fn of_file(scope: Scope<'_>, name: &str, rest: Option<&Rest>) -> MeshUnits {
    let file = rest.map(|rest| scope.path(&at_file(scope, name), &rest.file));
    let format = file.and_then(|file| scope.formats.reader(&file).ok());
    format.map(|format| format.reads_in()).unwrap_or_default()
}

/// Tells the formats whose files say their unit and axes those of the target; what the pipeline sets of a format stays.
pub(super) fn declare(formats: &mut Formats, document: &Document, units: MeshUnits) {
    let set = document.value.get("formats").and_then(Value::as_array).map(Vec::as_slice).unwrap_or_default();
    let is_set = |name: &str, key: &str| set.iter().any(|format| format["type"] == name && format.get(key).is_some());
    formats.set_units(|name| MeshUnits {
        unit: units.unit.filter(|_| !is_set(name, "unit")),
        up: units.up.filter(|_| !is_set(name, "up")),
    });
}

/// The change that takes files of poses into the unit and axes of the source.
pub(super) fn poses_change(scope: Scope<'_>, found: &mut Findings, source: &Source) -> UnitAxes {
    let said = MeshUnits { unit: source.poses_unit, up: source.poses_up };
    if !has_pose_files(source.poses.as_ref()) {
        let keys = [("poses_unit", said.unit.is_some()), ("poses_up", said.up.is_some())];
        for (key, _) in keys.into_iter().filter(|(_, is_said)| *is_said) {
            let message = format!("`{key}` for poses that come with the rest");
            let hint = "remove it: they are in the unit and axes of the rest";
            found.wrong(scope, &path(["source", key]), At::Key, message, hint);
        }
        return UnitAxes::IDENTITY;
    }
    let known = of_source(scope, source);
    if said.unit.is_some() && known.unit.is_none() {
        let hint = "say the unit of the rest too, e.g. `source: { unit: m }`";
        let message = "`poses_unit`, and the unit of the rest is not known";
        found.wrong(scope, &path(["source", "poses_unit"]), At::Key, message, hint);
    }
    if said.up.is_some() && known.up.is_none() {
        let hint = "say which axis points up in the rest too, e.g. `source: { up: y }`";
        let message = "`poses_up`, and the upward axis of the rest is not known";
        found.wrong(scope, &path(["source", "poses_up"]), At::Key, message, hint);
    }
    UnitAxes::between(said, known)
}

/// Whether the poses are in files beside that of the rest.
pub(super) fn has_pose_files(poses: Option<&Poses>) -> bool {
    match poses {
        None => false,
        Some(Poses::Files(_) | Poses::Mapped(_)) => true,
        Some(Poses::Clips(clips)) => clips.file.is_some(),
    }
}

/// The change of results in files of bare numbers, if there is one; it is told once.
pub(super) fn output_change(
    scope: Scope<'_>,
    found: &mut Findings,
    pipeline: &Pipeline,
    target: Option<&RestMesh>,
    outputs: &Outputs,
) -> Option<OutputChange> {
    let said = MeshUnits { unit: pipeline.output_unit, up: pipeline.output_up };
    let known = of_target(scope, &pipeline.target);
    if said.unit.is_some() && known.unit.is_none() {
        let hint = "say the unit of the target too, e.g. `target: { unit: cm }`";
        let message = "`output_unit`, and the unit of the target is not known";
        found.wrong(scope, &path(["output_unit"]), At::Key, message, hint);
    }
    if said.up.is_some() && known.up.is_none() {
        let hint = "say which axis points up in the target too, e.g. `target: { up: z }`";
        let message = "`output_up`, and the upward axis of the target is not known";
        found.wrong(scope, &path(["output_up"]), At::Key, message, hint);
    }
    let change = UnitAxes::between(known, said);
    if change == UnitAxes::IDENTITY {
        return None;
    }
    let files = outputs.meshes.iter().filter_map(|output| output.files().first());
    let bare = files.filter(|file| {
        scope.formats.writer(file).is_ok_and(|(format, _)| format.with_units(MeshUnits::default()).is_none())
    });
    let bare: BTreeSet<String> =
        bare.map(|file| format!(".{}", file.extension().unwrap_or_default().to_string_lossy())).collect();
    let bare: Vec<String> = bare.into_iter().collect();
    found.warnings.push(match &bare[..] {
        [] => "`output_unit` and `output_up` change no result: all files say their unit and axes".into(),
        bare => format!("results in {} files are those of the target {change}, as the pipeline says", bare.join(", ")),
    });
    target.map(|target| OutputChange::new(change, &target.sequence.rest))
}
