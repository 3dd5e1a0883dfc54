//! Partners by place, once the source is brought to the target by the markers.
//!
//! A similarity is fitted to the markers (none, where there are fewer than three); then each target vertex lies at the closest
//! point of the source, and each target triangle moves like the source triangle closest to its middle. For meshes of one shape in
//! different places and sizes.

use mimesh_core::{
    Result,
    mesh::SurfacePoint,
    plugin::check_ranges,
    register,
    spatial::{ClosestPoint, Orientation, Similarity},
    stage::{Correspondence, TransferPair, TriangleMap},
};
use nalgebra::Point3;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

register!(Correspondence: MyStage);

/// Partners by place, once the source is brought to the target by the markers.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct MyStage {
    /// How far a partner may be, relative to the diagonal of the target; triangles without one are orphans.
    #[schemars(range(min = 0.0))]
    pub max_distance: f64,
    /// How source and target are turned to each other.
    pub orientation: Orientation,
}

impl Default for MyStage {
    fn default() -> Self {
        Self { max_distance: 0.1, orientation: Orientation::Auto }
    }
}

#[typetag::serde(name = "my_stage")]
impl Correspondence for MyStage {
    fn correspond(&self, pair: TransferPair<'_>) -> Result<TriangleMap> {
        check_ranges(self)?;
        pair.check_markers()?;
        let (source, target) = (pair.source, pair.target);
        let to_target = self.similarity(pair);
        let moved: Vec<Point3<f64>> = source.positions.iter().map(|p| to_target.apply(p)).collect();
        let closest = ClosestPoint::new(&moved, &source.triangles)?;
        let within = self.max_distance * target.diagonal();
        let find = |place: &Point3<f64>| closest.find(place, within, |_| true);
        let partner = |place: &Point3<f64>| find(place).map(|found| found.triangle);
        let point =
            |place: &Point3<f64>| find(place).map(|found| SurfacePoint::Triangle(found.triangle, found.barycentric));
        let map = TriangleMap {
            source_triangle_count: source.triangle_count(),
            triangles: target.barycentres(&target.positions).par_iter().map(partner).collect(),
            points: target.positions.par_iter().map(point).collect(),
            ..TriangleMap::default()
        };
        map.check(pair)?;
        Ok(map)
    }
}

impl MyStage {
    /// What brings the source to the place of the target.
    fn similarity(&self, pair: TransferPair<'_>) -> Similarity {
        let on_source = pair.markers.iter().map(|m| m.source.position(pair.source, &pair.source.positions));
        let on_target = pair.markers.iter().map(|m| m.target.position(pair.target, &pair.target.positions));
        let (from, to): (Vec<_>, Vec<_>) = on_source.zip(on_target).unzip();
        // A similarity has seven unknowns, and a pair of points says three of them.
        if from.len() < 3 {
            return Similarity::IDENTITY;
        }
        Similarity::fit(&from, &to, &vec![1.0; from.len()], self.orientation)
    }
}

#[cfg(test)]
mod tests {
    use mimesh_core::{stage::Marker, testkit::meshes};

    use super::*;

    #[test]
    fn a_mesh_that_was_moved_and_scaled_finds_itself() {
        let source = meshes::icosphere(2);
        let mut target = source.clone();
        target.positions.iter_mut().for_each(|p| *p = Point3::new(3.0 * p.x + 5.0, 3.0 * p.y, 3.0 * p.z));
        let at = |v: u32| SurfacePoint::Vertex(v);
        let markers: Vec<_> = (0..12).map(|v| Marker { name: v.to_string(), source: at(v), target: at(v) }).collect();
        let pair = TransferPair { source: &source, target: &target, markers: &markers, proximity: None };
        let map = MyStage::default().correspond(pair).unwrap();
        assert!((0..).zip(&map.triangles).all(|(t, partner)| *partner == Some(t)));
    }
}
