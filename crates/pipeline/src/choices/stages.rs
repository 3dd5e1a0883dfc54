//! Choosing stages by the meshes.

use mimesh_core::{
    Result,
    plugin::instance,
    stage::{Correspondence, Landmarks, Marker, Metric, Proximity, Transfer, TransferPair},
};

use super::{choice::Choice, overlap::overlap, slots::Open};
use crate::{
    input::ProximityInput,
    parse::slots,
    spec::Pipeline,
    text::{count, number},
};

/// Chooses the transfer and the correspondence of `pipeline` where it leaves them open; `metrics` are those that it names.
///
/// The markers of `pair` are not looked at. A stage that is not linked into the program is not chosen.
pub fn choose_stages(
    pipeline: &mut Pipeline,
    open: Open,
    pair: TransferPair<'_>,
    metrics: &[Box<dyn Metric>],
) -> Vec<Choice> {
    let mut choices = Vec::new();
    let components = pair.target.components().count();
    if open.transfer {
        let (name, why) = match components {
            1 => ("gradient", "the target is one connected surface".into()),
            many => {
                let components = count(many, "component", "components");
                ("multi_component", format!("the target has {components}; `rigid: [all]` keeps the shape of each"))
            }
        };
        pipeline.transfer = instance::<dyn Transfer>(name);
        choices.extend(pipeline.transfer.as_ref().map(|_| Choice::new("transfer", name, why)));
    }
    let is_needed = pipeline.transfer.as_ref().is_some_and(|transfer| transfer.needs_correspondence())
        || metrics.iter().any(|metric| metric.needs_map());
    if open.correspondence && is_needed {
        let (name, why) = correspondence(pair);
        pipeline.correspondence = instance::<dyn Correspondence>(name);
        choices.extend(pipeline.correspondence.as_ref().map(|_| Choice::new("correspondence", name, why)));
    }
    choices
}

/// The type of correspondence that suits `pair`, and why.
fn correspondence(pair: TransferPair<'_>) -> (&'static str, String) {
    let has_one_topology = |identity: Box<dyn Correspondence>| identity.check(pair).is_ok();
    if pair.source.vertex_of.len() == pair.target.vertex_of.len()
        && instance::<dyn Correspondence>("identity").is_some_and(has_one_topology)
    {
        let triangles = count(pair.target.triangle_count(), "triangle", "triangles");
        return ("identity", format!("source and target have the same {triangles}"));
    }
    // A mesh whose closest points cannot be found is refused by the stage.
    if let Ok(Some(distance)) = overlap(pair.source, pair.target) {
        let percent = number(100.0 * distance);
        return ("nearest", format!("the meshes lie on each other: {percent} % of the diagonal apart on the average"));
    }
    ("nonrigid_fit", "the meshes differ in triangles and in shape".into())
}

/// Chooses between the `named` markers, those of equal names on both meshes, and a stage that proposes others.
///
/// The names do where nothing needs more. No markers and none needed are no choice.
pub fn choose_markers(pipeline: &mut Pipeline, named: &[Marker]) -> Option<Choice> {
    /// The stage that finds markers by shape.
    const BY_SHAPE: &str = "extremities";
    let of_correspondence = pipeline.correspondence.as_ref().map_or(0, |stage| stage.markers_needed());
    let of_transfer = pipeline.transfer.as_ref().map_or(0, |stage| stage.markers_needed());
    let needed = of_correspondence.max(of_transfer);
    if named.len() >= needed {
        let points = count(named.len(), "point has", "points have");
        return (!named.is_empty())
            .then(|| Choice::new("markers", "names", format!("{points} one name on both meshes")));
    }
    let stage = instance::<dyn Landmarks>(BY_SHAPE)?;
    pipeline.markers = Some(stage.into());
    let why = match named.len() {
        0 => "there is no file of markers, and no point has a name on both meshes".into(),
        few => format!("only {} a name on both meshes", count(few, "point has", "points have")),
    };
    Some(Choice::new("markers", BY_SHAPE, format!("{why}; they are found by shape")))
}

/// Chooses a graph of the target's components where other stages need one; gives the graph as well.
///
/// `markers` are `None` where a stage is going to propose them.
///
/// # Errors
///
/// Those of the proximity.
pub fn choose_proximity(
    pipeline: &mut Pipeline,
    pair: TransferPair<'_>,
    markers: Option<&[Marker]>,
    compute: impl FnOnce(&dyn Proximity) -> Result<ProximityInput>,
) -> Result<Option<(Choice, ProximityInput)>> {
    /// The stage that links components.
    const LINKS: &str = "spanning_tree";
    let components = pair.target.components().count();
    let Some(stage) = instance::<dyn Proximity>(LINKS).filter(|_| components > 1) else { return Ok(None) };
    let pair = TransferPair { markers: markers.unwrap_or_default(), proximity: None, ..pair };
    let takes = |pair: TransferPair<'_>| {
        let transfer = pipeline.transfer.as_ref().is_none_or(|stage| stage.check(pair).is_ok());
        transfer && pipeline.correspondence.as_ref().is_none_or(|stage| stage.check(pair).is_ok())
    };
    // Which components proposed markers reach is not known before the run.
    let is_unknown = markers.is_none();
    if !is_unknown && takes(pair) {
        return Ok(None);
    }
    let found = compute(stage.as_ref())?;
    if !is_unknown && !takes(TransferPair { proximity: Some(&found.graph), ..pair }) {
        return Ok(None);
    }
    pipeline.proximity = Some(stage);
    let why = format!("it links the {components} components of the target");
    Ok(Some((Choice::new("proximity", LINKS, why), found)))
}

/// The choices in the order of a pipeline's slots.
pub fn in_order(mut choices: Vec<Choice>) -> Vec<Choice> {
    let slots = slots();
    let slot_of = |choice: &Choice| choice.stage.split('.').next().unwrap_or_default().to_owned();
    choices.sort_by_key(|choice| slots.iter().position(|slot| *slot == slot_of(choice)));
    choices
}
