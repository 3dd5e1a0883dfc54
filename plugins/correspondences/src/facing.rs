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
    /// Points nearer than this lie on the source.
    coincident: f64,
}

impl Facing {
    /// Prepares to search `triangles` over `positions`.
    ///
    /// # Errors
    ///
    /// [`Error::Data`](mimesh_core::Error::Data) if there is no triangle.
    pub fn new(positions: &[Point3<f64>], triangles: &[[u32; 3]]) -> Result<Self> {
        let normals = triangles
            .iter()
            .map(|t| {
                let corners = t.map(|v| positions[v as usize]);
                (relative_height(&corners) > MIN_RELATIVE_HEIGHT).then(|| normal(&corners))
            })
            .collect();
        let search = ClosestPoint::new(positions, triangles)?;
        Ok(Self { search, normals, inner_depth: None, coincident: 0.0 })
    }

    /// Lets a point take the closest point whichever way it faces, where that is nearer by more than `depth`.
    pub fn with_inner_sides(self, depth: f64) -> Self {
        Self { inner_depth: Some(depth), ..self }
    }

    /// Lets a point take the closest point whichever way it faces, where that is nearer than `coincident`.
    pub fn with_coincident(self, coincident: f64) -> Self {
        Self { coincident, ..self }
    }

    /// The closest valid point nearer than `limit`.
    pub fn find(&self, point: &Point3<f64>, normal: &Vector3<f64>, limit: f64) -> Option<OnSurface> {
        self.find_near(point, normal, limit, None)
    }

    /// What [`find`](Self::find) gives, sooner where `guess` is a triangle near by.
    fn find_near(
        &self,
        point: &Point3<f64>,
        normal: &Vector3<f64>,
        limit: f64,
        guess: Option<u32>,
    ) -> Option<OnSurface> {
        let faces = |t| self.faces(t, normal);
        let found = match guess.filter(|&t| faces(t)) {
            Some(guess) => self.search.find_near(point, limit, guess, faces),
            None => self.search.find(point, limit, faces),
        };
        let distance = found.map_or(limit, |found| found.distance);
        if distance <= self.coincident {
            return found;
        }
        let deeper = self.inner_depth.map_or(0.0, |depth| found.map_or(limit, |found| found.distance - depth));
        let reach = deeper.max(self.coincident).min(distance);
        self.search.find(point, reach, |t| self.normals[t as usize].is_some()).or(found)
    }

    /// The closest point of the triangles that `accept` takes, whichever way it faces, if one is nearer than `limit`.
    pub fn find_among(&self, point: &Point3<f64>, limit: f64, accept: impl Fn(u32) -> bool) -> Option<OnSurface> {
        self.search.find(point, limit, |t| self.normals[t as usize].is_some() && accept(t))
    }

    /// Whether source triangle `t` faces the same way as `normal`.
    pub fn faces(&self, t: u32, normal: &Vector3<f64>) -> bool {
        self.normals[t as usize].is_some_and(|n| n.dot(normal) > 0.0)
    }

    /// |cos| of the angle between `normal`, of unit length, and that of source triangle `t`; 0 for a needle.
    pub fn parallel(&self, t: u32, normal: &Vector3<f64>) -> f64 {
        self.normals[t as usize].map_or(0.0, |n| n.dot(normal).abs() / n.norm())
    }

    /// For each vertex the closest valid point of the source nearer than `limit`.
    ///
    /// `guesses` are points that are likely near, or empty; they only save time.
    pub fn points(
        &self,
        positions: &[Point3<f64>],
        normals: &[Vector3<f64>],
        limit: f64,
        guesses: &[Option<SurfacePoint>],
    ) -> Vec<Option<SurfacePoint>> {
        let find = |(v, (point, normal))| {
            let found = self.find_near(point, normal, limit, triangle_of(guesses, v))?;
            Some(SurfacePoint::Triangle(found.triangle, found.barycentric))
        };
        (positions, normals).into_par_iter().enumerate().map(find).collect()
    }

    /// For each triangle the source triangle with the closest valid point to its barycentre nearer than `limit`.
    ///
    /// `guesses` are points of vertices that are likely near, or empty; they only save time. Zhou et al. 2010 compare barycentres
    /// with barycentres, which misses large triangles.
    pub fn triangles(
        &self,
        positions: &[Point3<f64>],
        triangles: &[[u32; 3]],
        limit: f64,
        guesses: &[Option<SurfacePoint>],
    ) -> Vec<Option<u32>> {
        let find = |t: &[u32; 3]| {
            let corners = t.map(|v| positions[v as usize]);
            let barycentre = Point3::from((corners[0].coords + corners[1].coords + corners[2].coords) / 3.0);
            let guess = t.iter().find_map(|&v| triangle_of(guesses, v as usize));
            self.find_near(&barycentre, &normal(&corners), limit, guess).map(|found| found.triangle)
        };
        triangles.par_iter().map(find).collect()
    }
}

/// The triangle of the point of vertex `v`.
fn triangle_of(points: &[Option<SurfacePoint>], v: usize) -> Option<u32> {
    match points.get(v)?.as_ref()? {
        SurfacePoint::Triangle(t, _) => Some(*t),
        SurfacePoint::Vertex(_) => None,
    }
}

fn normal([a, b, c]: &[Point3<f64>; 3]) -> Vector3<f64> {
    (b - a).cross(&(c - a))
}
