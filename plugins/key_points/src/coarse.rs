//! The source with fewer vertices, on which candidates are ranked.

use mimesh_core::{
    Result,
    mesh::{Coarse, Surface, SurfacePoint, coarsen},
    stage::{Clusterer, Deformer},
};
use nalgebra::Point3;

use crate::{candidates::nearest_vertex, evaluator::Ground};

/// A source of up to this many times the vertices asked for is taken as it is.
const MIN_RATIO: f64 = 1.5;

/// The fewest vertices a candidate, so that handles stay apart.
const VERTICES_A_CANDIDATE: usize = 4;

/// The source with fewer vertices, the candidates being among them.
pub struct CoarseSource {
    coarse: Coarse,
    /// The candidates on it.
    pub points: Vec<SurfacePoint>,
}

impl CoarseSource {
    /// The source with about `vertices` vertices; `None` if it has hardly more, or if a candidate would be lost.
    pub fn new(source: &Surface, points: &[SurfacePoint], vertices: usize) -> Result<Option<Self>> {
        let vertices = vertices.max(VERTICES_A_CANDIDATE * points.len());
        if (source.vertex_count() as f64) < MIN_RATIO * vertices as f64 {
            return Ok(None);
        }
        let kept: Vec<u32> = points.iter().map(|point| nearest_vertex(source, *point)).collect();
        let coarse = coarsen(source, vertices, &kept)?;
        let points: Option<Vec<_>> = kept.iter().map(|&v| coarse.find(v).map(SurfacePoint::Vertex)).collect();
        Ok(points.map(|points| Self { coarse, points }))
    }

    /// The surface.
    pub fn surface(&self) -> &Surface {
        &self.coarse.surface
    }

    /// The surface with `poses` of the source.
    pub fn ground(
        &self,
        poses: &[Vec<Point3<f64>>],
        clusterer: &dyn Clusterer,
        deformer: &dyn Deformer,
    ) -> Result<Ground<'static>> {
        let poses: Vec<_> = poses.iter().map(|pose| self.coarse.restrict(pose)).collect();
        Ok(Ground {
            regions: clusterer.bind(self.surface(), &poses)?,
            deformer: deformer.bind_coarse(self.surface(), &self.coarse.counts)?,
            poses: poses.into(),
            counts: Some(self.coarse.counts.clone()),
        })
    }
}

#[cfg(test)]
mod tests {
    use mimesh_core::testkit::meshes;

    use super::*;

    #[test]
    fn candidates_are_vertices_of_the_coarse_source() {
        let sphere = meshes::icosphere(4);
        let within = SurfacePoint::Triangle(5, [0.1, 0.8, 0.1]);
        let points: Vec<_> = (0..40).map(|k| SurfacePoint::Vertex(61 * k)).chain([within]).collect();
        for (asked, expected) in [(500, 500), (10, VERTICES_A_CANDIDATE * points.len())] {
            let coarse = CoarseSource::new(&sphere, &points, asked).unwrap().unwrap();
            assert_eq!(coarse.surface().vertex_count(), expected);
            for (point, on_coarse) in points.iter().zip(&coarse.points) {
                let vertex = nearest_vertex(&sphere, *point) as usize;
                let SurfacePoint::Vertex(v) = on_coarse else { panic!("a vertex") };
                assert_eq!(coarse.surface().positions[*v as usize], sphere.positions[vertex]);
            }
        }
        assert!(CoarseSource::new(&sphere, &points, 2000).unwrap().is_none(), "hardly fewer");
    }
}
