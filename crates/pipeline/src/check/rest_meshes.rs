//! Reading and checking the two meshes at rest.

use std::path::Path;

use mimesh_core::{Error, stage::Generator};
use mimesh_document::{At, Diagnostic, Kind, Location, path};
use mimesh_markers::IntoDiagnostic;

use super::findings::{Findings, Scope};
use crate::{input::RestMesh, spec::Target};

/// The target, as far as it can be had.
pub(super) fn target(scope: Scope<'_>, found: &mut Findings, target: &Target) -> Option<RestMesh> {
    rest_mesh(scope, found, "target", target.rest.as_deref(), target.generator.as_deref())
}

/// The mesh of the slot `name`, read or made, as far as it can be had.
pub(super) fn rest_mesh(
    scope: Scope<'_>,
    found: &mut Findings,
    name: &'static str,
    rest: Option<&Path>,
    generator: Option<&dyn Generator>,
) -> Option<RestMesh> {
    match (rest, generator) {
        (Some(_), Some(_)) => {
            let hint = "a mesh is either read or made; remove one of the two";
            found.wrong(scope, &path([name, "generator"]), At::Key, "`generator` beside `rest`", hint);
            None
        }
        (None, None) => {
            let slot = scope.document.value.get(name).and_then(|slot| slot.as_object());
            // A wrong `rest` has a diagnostic of its own, and so has a missing slot.
            if slot.is_some_and(|slot| !slot.contains_key("rest") && !slot.contains_key("generator")) {
                let hint = format!("name the mesh, e.g. `{name}: {{ rest: mesh.obj }}`");
                let message = format!("the {name} has neither `rest` nor `generator`");
                found.wrong(scope, &path([name]), At::Value, message, hint);
            }
            None
        }
        (None, Some(generator)) => made(scope, found, name, generator),
        (Some(rest), None) => read(scope, found, name, &scope.path(&path([name, "rest"]), rest)),
    }
}

fn made(scope: Scope<'_>, found: &mut Findings, name: &str, generator: &dyn Generator) -> Option<RestMesh> {
    let at = path([name, "generator"]);
    match generator.make().and_then(|made| RestMesh::new(None, made)) {
        Ok(mesh) => Some(mesh),
        Err(error) if scope.is_reported(&error, &at) => None,
        Err(error) => {
            let diagnostic = error.into_diagnostic().doing(format!("generator ({})", generator.typetag_name()));
            found.diagnostics.push(diagnostic.at(scope.document.location(&at, At::Value)));
            None
        }
    }
}

fn read(scope: Scope<'_>, found: &mut Findings, name: &str, file: &Path) -> Option<RestMesh> {
    let at = path([name, "rest"]);
    let role = if name == "source" { "source rest" } else { "target rest" };
    let before = found.diagnostics.len();
    found.check_empty(scope, &at);
    if found.diagnostics.len() > before || !found.input(scope, role, file, &at) {
        return None;
    }
    let format = match scope.formats.reader(file) {
        Ok(format) => format,
        Err(unknown) => {
            found.wrong(scope, &at, At::Value, unknown.message, unknown.hint);
            return None;
        }
    };
    match format.read(file).and_then(|sequence| RestMesh::new(Some(file.into()), sequence)) {
        Ok(mesh) => {
            let warnings = mesh.sequence.warnings.iter();
            found.warnings.extend(warnings.map(|warning| format!("{}: {warning}", file.display())));
            Some(mesh)
        }
        Err(error) => {
            found.diagnostics.push(in_file(file, error));
            None
        }
    }
}

/// Warns if one of the two has its faces turned the other way round: correspondences look at where faces point.
pub(super) fn check_inside_out(found: &mut Findings, source: Option<&RestMesh>, target: Option<&RestMesh>) {
    let (Some(source), Some(target)) = (source, target) else { return };
    if let (Some(of_source), Some(of_target)) = (source.volume(), target.volume())
        && of_source * of_target < 0.0
    {
        let (name, mesh) = if of_source < 0.0 { ("source", source) } else { ("target", target) };
        let file = mesh.path.as_ref().map(|path| format!(" ({})", path.display())).unwrap_or_default();
        found.warnings.push(format!(
            "the {name}{file} is inside out: its faces point inwards, those of the other mesh outwards; reverse its faces if few \
             triangles correspond"
        ));
    }
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
