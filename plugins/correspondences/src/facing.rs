//! Closest points of the source that face the same way as what is looked for.

use mimesh_core::{
    Result,
    mesh::SurfacePoint,
    operators::relative_height,
    spatial::{ClosestPoint, OnSurface},
};
use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

/// Source triangles with a smaller relative height correspond to nothing.
const MIN_RELATIVE_HEIGHT: f64 = 1e-4;

/// Searches the triangles of the source whose normals are less than 90 degrees from a given one.
///
/// Triangles that face away, as on the far side of an ear, are skipped in the search, so that the closest valid point is
/// found; Sumner and Popović 2004 ask for compatible normals too.
pub struct Facing {
    search: ClosestPoint,
    /// Normals of any length; `None` for needles, whose deformation would be noise.
    normals: Vec<Option<Vector3<f64>>>,
    /// How much nearer a point that faces away must be to be taken; `None` for never.
    inner_depth: Option<f64>,
}

impl Facing {
    pub fn new(positions: &[Point3<f64>], triangles: &[[u32; 3]]) -> Result<Self> {
        let normals = triangles
            .iter()
            .map(|t| {
                let corners = t.map(|v| positions[v as usize]);
                (relative_height(&corners) > MIN_RELATIVE_HEIGHT).then(|| normal(&corners))
            })
            .collect();
        Ok(Self { search: ClosestPoint::new(positions, triangles)?, normals, inner_depth: None })
    }

    /// Lets a point take the closest point whichever way it faces, where that is nearer by more than `depth`.
    pub fn with_inner_sides(self, depth: f64) -> Self {
        Self { inner_depth: Some(depth), ..self }
    }

    /// The closest valid point nearer than `limit`.
    pub fn find(&self, point: &Point3<f64>, normal: &Vector3<f64>, limit: f64) -> Option<OnSurface> {
        let found = self.find_among(point, normal, limit, |_| true);
        let Some(depth) = self.inner_depth else { return found };
        let reach = found.map_or(limit, |found| found.distance - depth);
        self.search.find(point, reach, |t| self.normals[t as usize].is_some()).or(found)
    }

    /// The closest point nearer than `limit` on a triangle that `accept` takes and whose normal is less than 90 degrees from `normal`.
    pub fn find_among(
        &self,
        point: &Point3<f64>,
        normal: &Vector3<f64>,
        limit: f64,
        accept: impl Fn(u32) -> bool,
    ) -> Option<OnSurface> {
        let same_way = |t: u32| self.normals[t as usize].is_some_and(|n| n.dot(normal) > 0.0);
        self.search.find(point, limit, |t| same_way(t) && accept(t))
    }

    /// For each vertex the closest valid point of the source nearer than `limit`.
    pub fn points(&self, positions: &[Point3<f64>], normals: &[Vector3<f64>], limit: f64) -> Vec<Option<SurfacePoint>> {
        let find = |(p, n)| self.find(p, n, limit).map(|f| SurfacePoint::Triangle(f.triangle, f.barycentric));
        (positions, normals).into_par_iter().map(find).collect()
    }

    /// For each triangle the source triangle with the closest valid point to its barycentre nearer than `limit`.
    ///
    /// Zhou et al. 2010 compare barycentres with barycentres, which misses large triangles.
    pub fn triangles(&self, positions: &[Point3<f64>], triangles: &[[u32; 3]], limit: f64) -> Vec<Option<u32>> {
        let find = |t: &[u32; 3]| {
            let corners = t.map(|v| positions[v as usize]);
            let barycentre = Point3::from((corners[0].coords + corners[1].coords + corners[2].coords) / 3.0);
            self.find(&barycentre, &normal(&corners), limit).map(|found| found.triangle)
        };
        triangles.par_iter().map(find).collect()
    }
}

fn normal([a, b, c]: &[Point3<f64>; 3]) -> Vector3<f64> {
    (b - a).cross(&(c - a))
}
