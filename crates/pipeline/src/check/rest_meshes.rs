//! Reading and checking the two meshes at rest.

use std::path::Path;

use mimesh_core::{
    Error,
    mesh::Welding,
    stage::{Generator, PoseChoice, RestShape, Selection},
};
use mimesh_document::{At, Diagnostic, Kind, Location, Step, path};
use mimesh_markers::IntoDiagnostic;

use super::{
    findings::{Findings, Scope},
    noise::noise_warning,
};
use crate::{input::RestMesh, rest::Rest, spec::Target};

/// The target with all its seams welded, as far as it can be had.
pub(super) fn target(scope: Scope<'_>, found: &mut Findings, target: &Target) -> Option<RestMesh> {
    let shape = target.rest.as_ref().and_then(|rest| rest.pose.clone().map(RestShape::Pose));
    let selection = Selection {
        rest: shape.unwrap_or_default(),
        poses: PoseChoice::Nothing,
        keep_document: true,
        ..Selection::default()
    };
    let mesh = rest_mesh(
        scope,
        found,
        "target",
        target.rest.as_ref(),
        selection,
        target.generator.as_deref(),
        target.weld_tolerance,
    )?;
    Some(match target.mirrored {
        Some(axis) => mesh.mirrored(axis),
        None => mesh,
    })
}

/// Where the document names the file of the mesh of the slot `name` at rest.
pub(super) fn at_file(scope: Scope<'_>, name: &str) -> Vec<Step> {
    let rest = path([name, "rest"]);
    let is_mapping = scope.document.get(&rest).is_some_and(serde_json::Value::is_object);
    if is_mapping { path([name, "rest", "file"]) } else { rest }
}

/// The mesh of the slot `name`, read from a file or made, as far as it can be had.
///
/// `selection` is completed by what `rest` names.
pub(super) fn rest_mesh(
    scope: Scope<'_>,
    found: &mut Findings,
    name: &'static str,
    rest: Option<&Rest>,
    selection: Selection,
    generator: Option<&dyn Generator>,
    weld_tolerance: Option<f64>,
) -> Option<RestMesh> {
    let welding = Welding { tolerance: weld_tolerance.unwrap_or_default(), ..Welding::default() };
    match (rest, generator) {
        (Some(_), Some(_)) => {
            let hint = "a mesh is either read or made; remove one of the two";
            found.wrong(scope, &path([name, "generator"]), At::Key, "`generator` beside `rest`", hint);
            None
        }
        (None, None) => {
            let slot = scope.document.value.get(name).and_then(|slot| slot.as_object());
            // A wrong `rest` has a diagnostic of its own, and so has a missing slot.
            let has =
                |slot: &serde_json::Map<_, serde_json::Value>, key| slot.get(key).is_some_and(|value| !value.is_null());
            if slot.is_some_and(|slot| !has(slot, "rest") && !has(slot, "generator")) {
                let hint = format!("name the mesh, e.g. `{name}: {{ rest: mesh.obj }}`");
                let message = format!("the {name} has neither `rest` nor `generator`");
                found.wrong(scope, &path([name]), At::Value, message, hint);
            }
            None
        }
        (None, Some(generator)) => made(scope, found, name, generator, welding),
        (Some(rest), None) => {
            let selection = completed(scope, found, name, rest, selection)?;
            read(scope, found, name, rest, selection, welding)
        }
    }
}

/// The selection with the parts and the clip that `rest` names; `None` after a diagnostic.
fn completed(
    scope: Scope<'_>,
    found: &mut Findings,
    name: &str,
    rest: &Rest,
    selection: Selection,
) -> Option<Selection> {
    let at = |key: &str| path([name, "rest", key]);
    if rest.pose.is_some() && rest.clip.is_some() {
        found.wrong(
            scope,
            &at("clip"),
            At::Key,
            "`clip` beside `pose`",
            "a mesh has one shape at rest; remove one of the two",
        );
        return None;
    }
    if let Some(key) = unknown_to_format(scope, name, rest) {
        let kind = rest.file.extension().unwrap_or_default().to_string_lossy().to_lowercase();
        let message = format!("`{key}` for a .{kind} file, which has no parts or clips with names");
        let hint = format!("remove `{key}`, or name a file of a format that has them, as .glb");
        found.wrong(scope, &at(key), At::Key, message, hint);
        return None;
    }
    if rest.time.is_some() && rest.clip.is_none() {
        found.wrong(scope, &at("time"), At::Key, "`time` without `clip`", "name the clip, e.g. `clip: Run`");
        return None;
    }
    if let Some(meshes) = &rest.meshes
        && meshes.items.is_empty()
    {
        found.wrong(scope, &at("meshes"), At::Value, "no mesh is named", "name one, or leave `meshes` out for all");
        return None;
    }
    let shape = rest.clip_shape().unwrap_or(selection.rest);
    Some(Selection { meshes: rest.meshes(), rest: shape, ..selection })
}

/// The first key of `rest` that the format of its file knows nothing of.
fn unknown_to_format(scope: Scope<'_>, name: &str, rest: &Rest) -> Option<&'static str> {
    if scope.formats.reader(&rest.file).map_or(true, |format| format.holds_poses()) {
        return None;
    }
    // The poses of the source may be files of their own.
    let keys = [
        ("meshes", rest.meshes.is_some()),
        ("pose", rest.pose.is_some() && name != "source"),
        ("clip", rest.clip.is_some()),
        ("time", rest.time.is_some()),
    ];
    keys.into_iter().find(|(_, is_given)| *is_given).map(|(key, _)| key)
}

fn made(
    scope: Scope<'_>,
    found: &mut Findings,
    name: &str,
    generator: &dyn Generator,
    welding: Welding,
) -> Option<RestMesh> {
    let at = path([name, "generator"]);
    match generator.make().and_then(|made| RestMesh::new(None, Selection::default(), made, welding)) {
        Ok(mesh) => Some(mesh),
        Err(error) if scope.is_reported(&error, &at) => None,
        Err(error) => {
            let diagnostic = error.into_diagnostic().doing(format!("generator ({})", generator.typetag_name()));
            found.diagnostics.push(diagnostic.at(scope.document.location(&at, At::Value)));
            None
        }
    }
}

fn read(
    scope: Scope<'_>,
    found: &mut Findings,
    name: &str,
    rest: &Rest,
    selection: Selection,
    welding: Welding,
) -> Option<RestMesh> {
    let at = &*at_file(scope, name);
    let file = &*scope.path(at, &rest.file);
    let role = if name == "source" { "source rest" } else { "target rest" };
    let before = found.diagnostics.len();
    found.check_empty(scope, at);
    if found.diagnostics.len() > before || !found.input(scope, role, file, at) {
        return None;
    }
    if let Err(unknown) = scope.formats.reader(file) {
        found.wrong(scope, at, At::Value, unknown.message, unknown.hint);
        return None;
    }
    match in_shape(scope, file, selection, welding) {
        Ok(mesh) => {
            found.warn_of_file(file, &mesh.sequence.warnings);
            found.warnings.extend(noise_warning(name, &mesh));
            Some(mesh)
        }
        Err(error) => {
            found.diagnostics.push(in_file(file, error));
            None
        }
    }
}

/// The mesh in the shape that `selection` has for its rest; points in files of markers lie on the shape that the file stores.
fn in_shape(scope: Scope<'_>, file: &Path, selection: Selection, welding: Welding) -> Result<RestMesh, Error> {
    let read = |selection: &Selection| {
        let sequence = scope.formats.read(file, selection)?;
        RestMesh::new(Some(file.into()), selection.clone(), sequence, welding.clone())
    };
    let mut mesh = read(&selection)?;
    if selection.rest == RestShape::Stored {
        return Ok(mesh);
    }
    let stored = Selection { rest: RestShape::Stored, poses: PoseChoice::Nothing, keep_document: false, ..selection };
    let RestMesh { sequence, surface, .. } = read(&stored)?;
    mesh.of_file = Some((sequence.rest, surface));
    Ok(mesh)
}

/// Warns of meshes that are turned against each other, and of single components that point inwards.
///
/// Stages see them outwards. Two meshes that both point inwards as a whole are told nothing, since they lie to each other as they
/// should.
pub(super) fn check_inside_out(found: &mut Findings, source: Option<&RestMesh>, target: Option<&RestMesh>) {
    for (name, mesh) in [("source", source), ("target", target)] {
        let Some(mesh) = mesh.filter(|mesh| !mesh.inward_components.is_empty() && !mesh.is_inside_out()) else {
            continue;
        };
        let components = mesh.surface.components();
        let which: Vec<usize> = mesh.inward_components.iter().map(|c| *c as usize).collect();
        found.warnings.push(format!(
            "{} of the {} components of the {name}{} are inside out; stages see them turned, and results keep the faces of the file: {}",
            which.len(),
            components.count(),
            file_of(mesh),
            mesh.surface.describe_components(&components, &which)
        ));
    }
    let (Some(source), Some(target)) = (source, target) else { return };
    if source.is_inside_out() != target.is_inside_out() {
        let way = |mesh: &RestMesh| if mesh.is_inside_out() { "inwards" } else { "outwards" };
        found.warnings.push(format!(
            "the target{} is inside out against the source{}: its faces point {}, those of the source {}; stages see both outwards, \
             and results keep the faces of the file",
            file_of(target),
            file_of(source),
            way(target),
            way(source)
        ));
    }
}

/// Warns of a target that may be a mirror image, where no markers of the user's tell: mirroring turns faces inside out.
pub(super) fn check_mirrored(found: &mut Findings, source: Option<&RestMesh>, target: Option<&RestMesh>) {
    let (Some(source), Some(target)) = (source, target) else { return };
    if source.is_inside_out() != target.is_inside_out() && target.mirror_axis().is_none() {
        let warning = "faces that point inwards are those of a mirror image, too: if the target is one, left and right are exchanged, so \
                       say `target: { mirrored: x }` with the axis from left to right";
        found.warnings.push(warning.into());
    }
}

/// The file of a mesh in brackets, if it has one.
fn file_of(mesh: &RestMesh) -> String {
    mesh.path.as_ref().map(|path| format!(" ({})", path.display())).unwrap_or_default()
}

/// The diagnostic of an error about the contents of `file`.
///
/// An error that does not name the file is placed there; one about another file says that `file` needs it.
pub fn in_file(file: &Path, error: Error) -> Diagnostic {
    let mut diagnostic = error.into_diagnostic();
    if let Some(Location::File(other)) = &diagnostic.location
        && other != file
    {
        diagnostic.message += &format!(", and {} needs it", file.display());
    }
    let location = diagnostic.location.clone().unwrap_or_else(|| Location::File(file.into()));
    let kind = if diagnostic.kind == Kind::BadPipeline { Kind::BadData } else { diagnostic.kind };
    Diagnostic { kind, ..diagnostic.at(location) }
}
