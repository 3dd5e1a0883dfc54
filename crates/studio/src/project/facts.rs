//! A project as pages see it.

use mimesh_core::{
    mesh::PosesAre,
    spatial::LengthUnit,
    stage::{Metric, MetricContext, MetricInput, TransferPair},
};
use mimesh_pipeline::Prepared;
use serde::Serialize;

use super::Project;
use crate::meshes::MeshFacts;

/// What is open, in words and numbers.
#[derive(Clone, Debug, Serialize)]
pub struct SessionView {
    project: Option<u64>,
    version: &'static str,
    allow_commands: bool,
    name: Option<String>,
    source: Option<MeshFacts>,
    target: Option<MeshFacts>,
    poses: Option<PosesView>,
    scalars: Vec<ScalarView>,
    has_truth: bool,
    live: LiveView,
}

#[derive(Clone, Debug, Serialize)]
struct PosesView {
    are: &'static str,
    fps: Option<f64>,
    list: Vec<PoseView>,
}

#[derive(Clone, Debug, Serialize)]
struct PoseView {
    name: String,
    clip: Option<String>,
    seconds: Option<f64>,
}

/// A colour map.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ScalarView {
    /// The type of the metric that gives it.
    pub name: String,
    /// What it shows, for people.
    pub title: String,
    /// The unit of its numbers.
    pub unit: String,
    /// Whether it needs the known result.
    pub needs_truth: bool,
}

#[derive(Clone, Debug, Serialize)]
struct LiveView {
    preview: bool,
    reason: Option<&'static str>,
}

impl SessionView {
    /// What `project` is; without one, that nothing is open.
    pub fn of(project: Option<&Project>, allow_commands: bool) -> Self {
        let has_preview = crate::live::preview::is_linked();
        let live = LiveView {
            preview: has_preview,
            reason: (!has_preview).then_some("the stages that give the fast preview are not part of this program"),
        };
        let version = env!("CARGO_PKG_VERSION");
        let empty = Self {
            project: None,
            version,
            allow_commands,
            name: None,
            source: None,
            target: None,
            poses: None,
            scalars: vec![],
            has_truth: false,
            live,
        };
        let Some(project) = project else { return empty };
        let facts = |k: usize| {
            let units = project.units[k];
            Some(project.meshes.facts(k, units.up, units.unit.map(unit_name)))
        };
        let ready = project.ready();
        let list = project.poses.iter().map(|pose| PoseView {
            name: pose.name.clone(),
            clip: pose.time.as_ref().map(|time| time.clip.clone()),
            seconds: pose.time.as_ref().map(|time| time.seconds),
        });
        let are = match project.poses_are {
            PosesAre::Frames => "frames",
            PosesAre::Shapes => "shapes",
        };
        Self {
            project: Some(project.number),
            name: Some(project.name.clone()),
            source: facts(0),
            target: facts(1),
            poses: Some(PosesView { are, fps: project.fps, list: list.collect() }),
            scalars: ready.as_ref().map(|ready| ready.scalars.clone()).unwrap_or_default(),
            has_truth: ready.is_some_and(|ready| !ready.prepared.truth.is_none()),
            ..empty
        }
    }
}

/// A unit as pipelines spell it.
fn unit_name(unit: LengthUnit) -> String {
    serde_json::to_value(unit).ok().and_then(|name| Some(name.as_str()?.to_owned())).unwrap_or_default()
}

impl ScalarView {
    /// The colour maps that the metrics of `prepared` give: those with a number for each vertex of the target at rest.
    pub fn all(prepared: &Prepared) -> Vec<Self> {
        let target = &prepared.target;
        let pair = TransferPair {
            source: &prepared.source.surface,
            target: &target.surface,
            markers: prepared.markers(),
            proximity: prepared.proximity.as_ref().map(|proximity| &proximity.graph),
        };
        let context =
            MetricContext { rest: &target.sequence.rest, surface: &target.surface, pair: Some(pair), map: None };
        prepared
            .metrics
            .iter()
            .filter_map(|metric| Self::of(metric.as_ref(), context, !prepared.truth.is_none()))
            .collect()
    }

    fn of(metric: &dyn Metric, context: MetricContext<'_>, has_truth: bool) -> Option<Self> {
        let needs_truth = metric.needs_ground_truth();
        if needs_truth && !has_truth || metric.is_of_rest() || metric.needs_map() {
            return None;
        }
        let rest = context.at_rest();
        let input = MetricInput {
            ground_truth: needs_truth.then_some(rest),
            source: context.pair.map(|pair| &pair.source.positions[..]),
            ..MetricInput::alone(rest)
        };
        let measured = metric.bind(context).ok()?.measure(input).ok()?;
        if measured.field.is_empty() {
            return None;
        }
        let (title, unit) = measured.field_unit.rsplit_once(", ").unwrap_or((measured.field_unit, ""));
        Some(Self { name: metric.typetag_name().into(), title: title.into(), unit: unit.into(), needs_truth })
    }
}
