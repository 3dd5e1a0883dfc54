//! What becomes of shapes once the target has them: what rests in the source rests; mirrored, masked and strengthened.

use std::sync::OnceLock;

use mimesh_core::{
    Error, Result,
    mesh::{PosesAre, Surface, SurfacePoint},
    operators::{keep_untouched, untouched},
    spatial::MirrorMap,
    stage::{TransferPair, TriangleMap},
};
use nalgebra::{Point3, Vector3};

use super::Region;
use crate::{
    axis::Axis,
    input::{Prepared, read_pose},
};

/// Changes shapes of the target as the pipeline says.
#[derive(Debug)]
pub struct ShapeEditor<'a> {
    prepared: &'a Prepared,
    pair: TransferPair<'a>,
    /// A source point for each vertex of the target's surface, once they are needed.
    points: OnceLock<Vec<SurfacePoint>>,
    /// The two sides of the target, once they are needed.
    sides: OnceLock<MirrorMap>,
}

impl<'a> ShapeEditor<'a> {
    /// For the shapes of `prepared` between the surfaces of `pair`.
    pub fn new(prepared: &'a Prepared, pair: TransferPair<'a>) -> Self {
        Self { prepared, pair, points: OnceLock::new(), sides: OnceLock::new() }
    }

    /// Changes pose `i` of the target, at `positions` (#V of its surface), where the source is at `posed` (#V of its surface).
    ///
    /// Vertices that follow vertices of the source that rest are taken back to rest, but in frames and where there is no map. `map` gives
    /// the triangle map if there is one; it is called where that is needed.
    ///
    /// # Errors
    ///
    /// Those of reading the shape that a mask names, and of a surface that cannot be mirrored.
    pub fn edit<'m>(
        &self,
        i: usize,
        posed: &[Point3<f64>],
        positions: &mut [Point3<f64>],
        map: impl Fn() -> Option<&'m TriangleMap>,
    ) -> Result<()> {
        if self.prepared.poses_are == PosesAre::Shapes
            && let Some(points) = self.points(&map)?
        {
            self.keep(&untouched(&self.prepared.source.surface, posed, points)?, positions)?;
        }
        let edit = &self.prepared.shape_edits[i];
        if edit.is_none() {
            return Ok(());
        }
        if let Some(axis) = edit.mirrored {
            let moved = displacements(self.rest(), positions);
            set(self.rest(), positions, &self.sides(axis)?.mirror(&moved)?);
        }
        match edit.region.as_deref() {
            None => {}
            Some(Region::Inside(inside)) => {
                self.keep(&inside.iter().map(|inside| !inside).collect::<Vec<_>>(), positions)?
            }
            Some(Region::MovedBy(pose)) => {
                let Prepared { source, formats, .. } = self.prepared;
                let other = source.surface.from_mesh(&read_pose(source, formats, &pose.from)?)?;
                let points = self.points(&map)?.ok_or_else(no_map)?;
                self.keep(&untouched(&source.surface, &other, points)?, positions)?;
            }
            Some(Region::Shares(shares)) => {
                let moved = displacements(self.rest(), positions);
                let shared: Vec<_> = moved.iter().zip(shares).map(|(moved, share)| moved * *share).collect();
                set(self.rest(), positions, &shared);
            }
        }
        if edit.strength != 1.0 {
            let moved = displacements(self.rest(), positions);
            set(self.rest(), positions, &moved.iter().map(|moved| moved * edit.strength).collect::<Vec<_>>());
        }
        Ok(())
    }

    /// How far from symmetric the target is, if any of `poses` is mirrored: as a sentence where that matters.
    pub fn warning(&self, poses: &[usize]) -> Option<String> {
        /// Faces of people are below 0.003.
        const LOPSIDED: f64 = 0.01;
        // Cached shapes were mirrored by an earlier run.
        let axis = poses.iter().find_map(|&i| self.prepared.shape_edits[i].mirrored)?;
        let asymmetry = self.sides(axis).ok().map(|sides| sides.asymmetry).filter(|asymmetry| *asymmetry > LOPSIDED)?;
        Some(format!(
            "shapes.mirror: the sides of the target differ by {:.1} % of its diagonal in the mean, so that mirrored shapes may not fit: \
             look at them, or choose another axis",
            100.0 * asymmetry
        ))
    }

    fn rest(&self) -> &'a Surface {
        self.prepared.target.seen_surface()
    }

    fn keep(&self, untouched: &[bool], positions: &mut [Point3<f64>]) -> Result<()> {
        if untouched.contains(&true) { keep_untouched(self.rest(), positions, untouched) } else { Ok(()) }
    }

    fn points<'m>(&self, map: &impl Fn() -> Option<&'m TriangleMap>) -> Result<Option<&[SurfacePoint]>> {
        if let Some(points) = self.points.get() {
            return Ok(Some(points));
        }
        let Some(map) = map() else { return Ok(None) };
        let points = map.source_points(self.pair)?;
        Ok(Some(self.points.get_or_init(|| points)))
    }

    fn sides(&self, axis: Axis) -> Result<&MirrorMap> {
        if let Some(sides) = self.sides.get() {
            return Ok(sides);
        }
        let sides = MirrorMap::new(self.rest(), axis.index())?;
        Ok(self.sides.get_or_init(|| sides))
    }
}

fn displacements(rest: &Surface, positions: &[Point3<f64>]) -> Vec<Vector3<f64>> {
    positions.iter().zip(&rest.positions).map(|(position, rest)| position - rest).collect()
}

/// Puts vertices where `displacements` take them; those that do not move rest to the last bit.
fn set(rest: &Surface, positions: &mut [Point3<f64>], displacements: &[Vector3<f64>]) {
    let all = positions.iter_mut().zip(&rest.positions).zip(displacements);
    all.for_each(|((position, rest), displacement)| *position = rest + displacement);
}

fn no_map() -> Error {
    Error::data("nothing tells which of the target follows a shape of the source", "name a `correspondence`")
}
