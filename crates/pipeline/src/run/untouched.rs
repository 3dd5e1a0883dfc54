//! Vertices that rest in a shape of the source rest in that of the target.

use std::sync::OnceLock;

use mimesh_core::{
    Result,
    mesh::{PosesAre, SurfacePoint},
    operators::{keep_untouched, untouched},
};
use nalgebra::Point3;

use super::stages::Stages;
use crate::input::Prepared;

/// Keeps at rest what rests in the shapes of the source.
pub(super) struct Untouched<'a> {
    prepared: &'a Prepared,
    stages: &'a Stages<'a>,
    /// A source point for each vertex of the target's surface, once they are needed.
    points: OnceLock<Vec<SurfacePoint>>,
}

impl<'a> Untouched<'a> {
    pub fn new(prepared: &'a Prepared, stages: &'a Stages<'a>) -> Self {
        Self { prepared, stages, points: OnceLock::new() }
    }

    /// Takes vertices of the target at `positions` (#V of its surface) back to rest that follow vertices of the source that rest in
    /// `posed` (#V of its surface); frames, and results of pipelines without a map, stay as they are.
    pub fn keep(&self, posed: &[Point3<f64>], positions: &mut [Point3<f64>]) -> Result<()> {
        if self.prepared.poses_are == PosesAre::Frames {
            return Ok(());
        }
        let Some(points) = self.points()? else { return Ok(()) };
        let untouched = untouched(&self.prepared.source.surface, posed, points)?;
        if untouched.iter().any(|untouched| *untouched) {
            keep_untouched(self.prepared.target.seen_surface(), positions, &untouched)?;
        }
        Ok(())
    }

    fn points(&self) -> Result<Option<&[SurfacePoint]>> {
        if let Some(points) = self.points.get() {
            return Ok(Some(points));
        }
        let Some(map) = self.stages.cached_map() else { return Ok(None) };
        let points = map.source_points(self.stages.pair())?;
        Ok(Some(self.points.get_or_init(|| points)))
    }
}
