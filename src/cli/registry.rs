//! Look-ups of stages and types in the registry, by the names that the user gives.

use mimesh_core::{Plugin, plugin};
use mimesh_document::{
    Diagnostic, Kind, Step, Variants, diagnostic::Result, serde_errors::unknown_type, suggest::did_you_mean,
};
use mimesh_pipeline::schema::{SchemaNode, types};

/// Checks that a kind of stage is called `stage`.
///
/// # Errors
///
/// A diagnostic if there is none; its hint proposes the nearest name.
pub fn check_stage(stage: &str) -> Result<()> {
    let mut stages: Vec<_> = plugin::all().iter().map(|plugin| plugin.stage).collect();
    stages.dedup();
    if stages.contains(&stage) {
        return Ok(());
    }
    let hint = kind_in_slot(stage)
        .map(|kind| format!("`{stage}` in a pipeline takes one of the kind `{kind}`"))
        .or_else(|| did_you_mean(stage, &stages))
        .unwrap_or_else(|| format!("stages: {}", stages.join(", ")));
    Err(Diagnostic::new(Kind::Usage, format!("unknown stage `{stage}`")).hint(hint).into())
}

/// The kind of the stages in the slot `slot` of a pipeline, as `landmarks` for `markers`; `None` if there is no such slot.
fn kind_in_slot(slot: &str) -> Option<&'static str> {
    let node = SchemaNode::pipeline().entry(&Step::Key(slot.into()), None)?;
    node.stage().or_else(|| node.entry(&Step::Index(0), None)?.stage())
}

/// Finds the implementation `name` of `stage`.
///
/// # Errors
///
/// A diagnostic if there is none; its hint proposes the nearest name.
pub fn find(stage: &str, name: &str) -> Result<&'static Plugin> {
    check_stage(stage)?;
    let found = plugin::all().into_iter().find(|plugin| plugin.stage == stage && plugin.name() == name);
    found.ok_or_else(|| {
        let types = types(stage).into_iter().map(str::to_owned).collect();
        let unknown = unknown_type(&Variants { kind: stage.into(), types }, name);
        Diagnostic::new(Kind::Usage, unknown.message).hint(unknown.hint).into()
    })
}
