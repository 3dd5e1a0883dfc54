//! Checking whether the pictures that a pipeline asks for can be given.

use std::borrow::Cow;

use mimesh_document::{At, path};

use super::findings::{Findings, Scope};
use crate::{
    input::{Outputs, RestMesh, ViewScript},
    pictures::too_large_to_turn,
    spec::Pipeline,
};

/// The script of the 3D view, if the pipeline asks for one and its page can have it.
pub(super) fn view_script(
    scope: Scope<'_>,
    found: &mut Findings,
    pipeline: &Pipeline,
    outputs: &Outputs,
    [source, target]: [Option<&RestMesh>; 2],
    script: &ViewScript,
) -> Option<Cow<'static, str>> {
    if !pipeline.pictures.view_3d {
        return None;
    }
    let at = path(["pictures", "view_3d"]);
    let Some(text) = script.inline() else {
        let message = "this program cannot make 3D views: it was built without their script";
        let hint = if script.hint.is_empty() { "remove `view_3d`" } else { &script.hint };
        found.wrong(scope, &at, At::Key, message, hint);
        return None;
    };
    if outputs.pages.is_empty() {
        found.warnings.push("`pictures.view_3d` changes nothing: no .html is among the outputs".into());
        return None;
    }
    let surfaces = [source, target].map(|mesh| mesh.map_or(0, |mesh| mesh.surface.triangle_count()));
    found.warnings.extend(too_large_to_turn(surfaces));
    Some(text)
}
