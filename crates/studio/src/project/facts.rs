//! A project as pages see it.

use mimesh_core::{mesh::PosesAre, spatial::LengthUnit};
use serde::Serialize;

use super::state::Project;
use crate::{meshes::MeshFacts, scalars::ScalarView};

/// Frames a second of a clip where nobody says it.
const USUAL_RATE: f64 = 24.0;

/// What is open, in words and numbers.
#[derive(Clone, Debug, Serialize)]
pub struct SessionView {
    project: Option<u64>,
    opened: Option<u64>,
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
    clips: Vec<ClipView>,
    list: Vec<PoseView>,
}

#[derive(Clone, Debug, Serialize)]
struct ClipView {
    name: String,
    seconds: f64,
    /// Frames at the rate that the poses have now.
    frames: usize,
}

#[derive(Clone, Debug, Serialize)]
struct PoseView {
    name: String,
    clip: Option<String>,
    seconds: Option<f64>,
}

#[derive(Clone, Debug, Serialize)]
struct LiveView {
    preview: bool,
    reason: Option<&'static str>,
}

impl SessionView {
    /// What `project` is; without one, that nothing is open. `has_preview` says whether the stages of the fast preview are there.
    pub fn of(project: Option<&Project>, allow_commands: bool, has_preview: bool) -> Self {
        let live = LiveView {
            preview: has_preview,
            reason: (!has_preview).then_some("the stages that give the fast preview are not part of this program"),
        };
        let version = env!("CARGO_PKG_VERSION");
        let empty = Self {
            project: None,
            opened: None,
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
        let rate = project.fps.unwrap_or(USUAL_RATE);
        let clips = project.clips.iter().map(|(name, seconds)| ClipView {
            name: name.clone(),
            seconds: *seconds,
            // The ends are frames both; what is lost by rounding counts.
            frames: (seconds * rate + 1e-6).floor() as usize + 1,
        });
        let clips = clips.collect();
        let are = match project.poses_are {
            PosesAre::Frames => "frames",
            PosesAre::Shapes => "shapes",
        };
        Self {
            project: Some(project.number),
            opened: Some(project.opened),
            name: Some(project.name.clone()),
            source: facts(0),
            target: facts(1),
            poses: Some(PosesView { are, fps: project.fps, clips, list: list.collect() }),
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
