//! The residual that the maps of a few handles leave of the source's poses.

use std::fmt;

use mimesh_core::{Result, mesh::Surface, operators::vertex_normals, spatial::ClosestPoint};
use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

/// The search for points of a source at rest.
pub(super) struct Search {
    closest: ClosestPoint,
    triangles: Vec<[u32; 3]>,
    area_normals: Vec<Vector3<f64>>,
}

impl Search {
    pub(super) fn new(source: &Surface) -> Result<Self> {
        Ok(Self {
            closest: ClosestPoint::new(&source.positions, &source.triangles)?,
            triangles: source.triangles.clone(),
            area_normals: source.area_normals(&source.positions),
        })
    }

    /// The point that is closest to `place` and faces along `normal`, sooner if that is near the triangle `guess`.
    fn find(&self, place: &Point3<f64>, normal: &Vector3<f64>, guess: Option<u32>) -> Option<Near> {
        let faces = |t: u32| self.area_normals[t as usize].dot(normal) > 0.0;
        let found = match guess.filter(|t| faces(*t)) {
            Some(guess) => self.closest.find_near(place, f64::INFINITY, guess, faces),
            None => self.closest.find(place, f64::INFINITY, faces),
        }?;
        let (triangle, barycentric) = (found.triangle, found.barycentric);
        Some(Near { triangle, corners: self.triangles[triangle as usize], barycentric })
    }
}

// The tree of boxes is nothing to read.
impl fmt::Debug for Search {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Search").field("triangles", &self.triangles.len()).finish_non_exhaustive()
    }
}

/// A point of the source at rest.
#[derive(Clone, Copy, Debug)]
struct Near {
    triangle: u32,
    corners: [u32; 3],
    barycentric: [f64; 3],
}

/// The point of the source at rest that is closest to each place and faces the same way.
#[derive(Clone, Debug)]
pub(super) struct Residual {
    /// `None` where no point of the source faces the same way.
    points: Vec<Option<Near>>,
    /// The places that they were found for.
    places: Vec<Point3<f64>>,
}

impl Residual {
    /// Finds the points for the vertices of `target`, in the source's frame, whose corresponding places are `places`.
    pub(super) fn new(search: &Search, target: &Surface, places: &[Point3<f64>]) -> Self {
        let normals = vertex_normals(&target.positions, &target.triangles);
        let points = places.par_iter().zip(&normals).map(|(place, normal)| search.find(place, normal, None)).collect();
        Self { points, places: places.to_vec() }
    }

    /// The same when the places have moved. Where one has moved by less than `slack` since its point was found, that point stays.
    pub(super) fn follow(&mut self, search: &Search, target: &Surface, places: &[Point3<f64>], slack: f64) {
        let normals = vertex_normals(&target.positions, &target.triangles);
        let all = self.points.par_iter_mut().zip(&mut self.places).zip(places).zip(&normals);
        all.filter(|(((_, at), place), _)| (*place - **at).norm() >= slack).for_each(
            |(((near, at), place), normal)| {
                *near = search.find(place, normal, near.map(|near| near.triangle));
                *at = *place;
            },
        );
    }

    /// Adds to `moved` what leads from the `fit` of the maps to the pose at those points.
    pub(super) fn add(&self, posed: &[Point3<f64>], fit: &[Point3<f64>], moved: &mut [Point3<f64>]) {
        for (q, point) in moved.iter_mut().zip(&self.points) {
            let Some(Near { corners, barycentric, .. }) = point else { continue };
            for (&v, b) in corners.iter().zip(barycentric) {
                *q += (posed[v as usize] - fit[v as usize]) * *b;
            }
        }
    }
}
