//! The fast preview: handles with unbounded weights, which take a moment to bind again after a point has moved.

use std::sync::{Arc, Mutex, PoisonError};

use mimesh_core::{
    plugin::{configured, instance},
    stage::{BindInput, BoundTransfer, KeptTransfer, Transfer, TransferPair, Work},
};
use mimesh_markers::IntoDiagnostic;
use nalgebra::Point3;
use serde_json::json;

use super::pair::LiveMarkers;
use crate::{
    error::{ApiError, Code, Result},
    project::Project,
};

/// The stage of the preview; the program may be without it.
const TRANSFER: &str = "biharmonic";

/// How many poses the preview learns the parts of the source from.
const LEARNED: usize = 8;

/// Fewer pairs fix no place in space.
const MIN_MARKERS: usize = 3;

/// The preview of a server, bound to the markers that were asked for last.
#[derive(Debug, Default)]
pub struct Preview {
    bound: Mutex<Option<Bound>>,
    kept: Mutex<Option<Kept>>,
}

/// What does not depend on markers, for a project and a proximity graph.
#[derive(Debug)]
struct Kept {
    project: u64,
    /// Whether the graph of the target's components was known.
    is_linked: bool,
    transfer: Option<Box<dyn KeptTransfer>>,
}

#[derive(Debug)]
struct Bound {
    project: u64,
    live: LiveMarkers,
    transfer: Arc<dyn BoundTransfer>,
}

/// Whether the stages of the fast preview are part of the program.
pub fn is_linked() -> bool {
    instance::<dyn Transfer>(TRANSFER).is_some()
}

impl Preview {
    /// The target's file when the source's is at `posed`.
    ///
    /// # Errors
    ///
    /// [`Code::NotFound`] where something is missing for it, and what the stage refuses.
    pub fn at(&self, project: &Project, live: &LiveMarkers, posed: &[Point3<f64>]) -> Result<Vec<Point3<f64>>> {
        let transfer = self.bound(project, live)?;
        let refused = |error: mimesh_core::Error| ApiError::from(error.into_diagnostic());
        let source = project.meshes.sides[0].surface.from_mesh(posed).map_err(refused)?;
        let moved = transfer.transfer(&source).map_err(refused)?.positions;
        let target = &project.meshes.sides[1];
        Ok(project.meshes.to_file(1, &target.mirrored_positions(moved)))
    }

    fn bound(&self, project: &Project, live: &LiveMarkers) -> Result<Arc<dyn BoundTransfer>> {
        let mut bound = self.bound.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(bound) = &*bound
            && bound.project == project.number
            && bound.live.markers == live.markers
        {
            return Ok(bound.transfer.clone());
        }
        let transfer = self.bind(project, live)?;
        *bound = Some(Bound { project: project.number, live: live.clone(), transfer: transfer.clone() });
        Ok(transfer)
    }

    fn bind(&self, project: &Project, live: &LiveMarkers) -> Result<Arc<dyn BoundTransfer>> {
        if live.markers.len() < MIN_MARKERS {
            let message = format!("the preview needs {MIN_MARKERS} complete pairs, there are {}", live.markers.len());
            return Err(ApiError::new(Code::NotFound, message).hint("click more points, or let them be proposed"));
        }
        let settings = json!({ "type": TRANSFER, "weights": { "type": "biharmonic" } });
        let transfer = configured::<dyn Transfer>(settings)
            .ok_or_else(|| ApiError::new(Code::NotFound, "the stages of the preview are not part of this program"))?;
        let refused = |error: mimesh_core::Error| ApiError::from(error.into_diagnostic());
        let [source, target] = [&project.meshes.sides[0], &project.meshes.sides[1]];
        let ready = project.ready();
        let proximity = ready.as_ref().and_then(|ready| ready.prepared.proximity.as_ref());
        let proximity = proximity.map(|proximity| &proximity.graph);
        let pair =
            TransferPair { source: &source.surface, target: target.seen_surface(), markers: &live.markers, proximity };
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        let is_linked = proximity.is_some();
        if !kept.as_ref().is_some_and(|kept| kept.project == project.number && kept.is_linked == is_linked) {
            let poses = learned(project);
            let input = BindInput { pair, map: None, poses: &poses, work: Work::UNWATCHED };
            let transfer = transfer.keep(input).map_err(refused)?;
            *kept = Some(Kept { project: project.number, is_linked, transfer });
        }
        let bound = match kept.as_mut().and_then(|kept| kept.transfer.as_mut()) {
            Some(kept) => kept.bind(pair),
            None => {
                let poses = learned(project);
                transfer.bind(BindInput { pair, map: None, poses: &poses, work: Work::UNWATCHED })
            }
        };
        Ok(bound.map_err(refused)?.into())
    }
}

/// Poses of the source that the preview learns its parts from.
fn learned(project: &Project) -> Vec<Vec<Point3<f64>>> {
    let chosen = mimesh_pipeline::input::evenly_spaced(project.poses.len(), LEARNED);
    let surface = &project.meshes.sides[0].surface;
    chosen.into_iter().filter_map(|i| surface.from_mesh(&project.pose(i).ok()?).ok()).collect()
}
