//! Copies displacements, those of the whole body apart from those of its parts.
//!
//! With M the rigid motion that brings the source at rest nearest to its pose, a point u of it goes to ũ = M(u) + r(u). The
//! target takes both: x̃ = A (M(A⁻¹ x) + strength · r(u)), where A is the similarity that brings the source at rest to the place
//! of the target, and u the source point that x lies at. So a body that turns as a whole is not sheared by it.

use mimesh_core::{
    Error, Figures, Result,
    mesh::{Surface, SurfacePoint, check_finite},
    operators::voronoi_mass,
    plugin::check_ranges,
    register,
    spatial::{Orientation, Similarity},
    stage::{BindInput, BoundTransfer, Transfer, Transferred},
};
use nalgebra::{Point3, Vector3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

register!(Transfer: MyStage);

/// Copies displacements, those of the whole body apart from those of its parts.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct MyStage {
    /// How much of the parts' displacements to take: 0 for none, 1 for all.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub strength: f64,
}

impl Default for MyStage {
    fn default() -> Self {
        Self { strength: 1.0 }
    }
}

#[typetag::serde(name = "my_stage")]
impl Transfer for MyStage {
    // What depends on the rest meshes alone is done here, once.
    fn bind(&self, input: BindInput<'_>) -> Result<Box<dyn BoundTransfer>> {
        check_ranges(self)?;
        let pair = input.pair;
        let points = input.require_map()?.source_points(pair)?;
        let places: Vec<_> = points.iter().map(|p| p.position(pair.source, &pair.source.positions)).collect();
        // Vertices without an area, as loose ones, lie where they like.
        let areas = voronoi_mass(&pair.target.positions, &pair.target.triangles);
        let to_target = Similarity::fit(&places, &pair.target.positions, &areas, Orientation::default());
        let to_source = to_target.inverse();
        Ok(Box::new(Bound {
            strength: self.strength,
            source: pair.source.clone(),
            rest: pair.target.positions.iter().map(|x| to_source.apply(x)).collect(),
            points,
            to_target,
        }))
    }
}

#[derive(Debug)]
struct Bound {
    strength: f64,
    source: Surface,
    /// The target's vertices at the place of the source, A⁻¹ x.
    rest: Vec<Point3<f64>>,
    /// The source point that each of them lies at, u.
    points: Vec<SurfacePoint>,
    /// A.
    to_target: Similarity,
}

impl BoundTransfer for Bound {
    // Called for every pose, from many threads.
    fn transfer(&self, posed: &[Point3<f64>]) -> Result<Transferred> {
        Error::check_shape("posed source vertices (#V)", self.source.vertex_count(), posed.len())?;
        check_finite(posed)?;
        let motion = nearest_rigid_motion(&self.source.positions, posed);
        let moved = |(y, point): (&Point3<f64>, &SurfacePoint)| {
            let at_rest = point.position(&self.source, &self.source.positions);
            let own = point.position(&self.source, posed) - motion.apply(&at_rest);
            self.to_target.apply(&(motion.apply(y) + own * self.strength))
        };
        let positions = self.rest.iter().zip(&self.points).map(moved).collect();
        Ok(Transferred { positions, figures: Figures::default() })
    }

    fn figures(&self) -> Figures {
        let mut figures = Figures::default();
        figures.set("size_ratio", self.to_target.scale);
        figures
    }
}

/// The rotation and translation of `from` that bring it nearest to `to`, in the mean of squares.
fn nearest_rigid_motion(from: &[Point3<f64>], to: &[Point3<f64>]) -> Similarity {
    let fitted = Similarity::fit(from, to, &vec![1.0; from.len()], Orientation::Fitted);
    let mean = |points: &[Point3<f64>]| points.iter().map(|p| p.coords).sum::<Vector3<f64>>() / points.len() as f64;
    Similarity { scale: 1.0, translation: mean(to) - fitted.rotation * mean(from), ..fitted }
}

#[cfg(test)]
mod tests {
    use mimesh_core::{
        stage::{TransferPair, TriangleMap},
        testkit::meshes,
    };

    use super::*;

    #[test]
    fn without_strength_the_target_stays_rigid() {
        let surface = meshes::icosphere(1);
        let partners = (0..surface.triangle_count() as u32).map(Some).collect();
        let map = TriangleMap { source_triangle_count: surface.triangle_count(), triangles: partners, ..TriangleMap::default() };
        let pair = TransferPair { source: &surface, target: &surface, markers: &[], proximity: None };
        let bound = MyStage { strength: 0.0 }.bind(BindInput::new(pair, &map)).unwrap();
        let stretched: Vec<_> = surface.positions.iter().map(|p| Point3::new(2.0 * p.x, p.y, p.z)).collect();
        let posed = bound.transfer(&stretched).unwrap().positions;
        // Rounding of coordinates of size 1.
        assert!(posed.iter().all(|p| (p.coords.norm() - 1.0).abs() < 1e-12));
    }
}
