//! The residual that the maps of a few handles leave of the source's poses.

use mimesh_core::{Result, mesh::Surface, operators::vertex_normals, spatial::ClosestPoint};
use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

/// The point of the source at rest that is closest to each place and faces the same way.
#[derive(Debug)]
pub(super) struct Residual {
    /// Corners and their barycentric coordinates; `None` where no point of the source faces the same way.
    points: Vec<Option<([u32; 3], [f64; 3])>>,
}

impl Residual {
    /// Finds the points for the vertices of `target`, in the source's frame, whose corresponding places are `places`.
    pub(super) fn new(source: &Surface, target: &Surface, places: &[Point3<f64>]) -> Result<Self> {
        let search = ClosestPoint::new(&source.positions, &source.triangles)?;
        let of_source = source.area_normals(&source.positions);
        let find = |(place, normal): (&Point3<f64>, &Vector3<f64>)| {
            let found = search.find(place, f64::INFINITY, |t| of_source[t as usize].dot(normal) > 0.0)?;
            Some((source.triangles[found.triangle as usize], found.barycentric))
        };
        let normals = vertex_normals(&target.positions, &target.triangles);
        Ok(Self { points: places.par_iter().zip(&normals).map(find).collect() })
    }

    /// Adds to `moved` what leads from the `fit` of the maps to the pose at those points.
    pub(super) fn add(&self, posed: &[Point3<f64>], fit: &[Point3<f64>], moved: &mut [Point3<f64>]) {
        for (q, point) in moved.iter_mut().zip(&self.points) {
            let Some((corners, barycentric)) = point else { continue };
            for (&v, b) in corners.iter().zip(barycentric) {
                *q += (posed[v as usize] - fit[v as usize]) * *b;
            }
        }
    }
}
