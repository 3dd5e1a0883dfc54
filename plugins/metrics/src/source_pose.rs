//! Scale, turn and reach of a pose of the source.

use mimesh_core::{
    mesh::Surface,
    spatial::{Orientation, Similarity},
};
use nalgebra::{Matrix3, Point3, Vector3};

use crate::{
    distribution::Distribution,
    elements::{self, Elements},
};

/// The source at rest, for the frames of its poses.
pub struct SourcePoses<'a> {
    surface: &'a Surface,
    /// The diagonal at rest.
    pub diagonal: f64,
    /// The edges at rest.
    pub edges: Elements<2>,
}

/// What a pose does as a whole.
pub struct PoseFrame {
    /// The median stretch of edges, κ: 1 for a pose that only bends. It is the scale of a pose whose file has another unit than rest.
    pub scale: f64,
    /// The rotation Q that takes the pose to rest with least squares.
    pub back: Matrix3<f64>,
}

impl<'a> SourcePoses<'a> {
    /// The poses of `surface`.
    pub fn new(surface: &'a Surface) -> Self {
        Self { surface, diagonal: surface.diagonal(), edges: elements::edges(surface) }
    }

    /// The scale of a pose; 1 where nothing is finite.
    pub fn scale(&self, posed: &[Point3<f64>]) -> f64 {
        let stretches = self.edges.logarithms(posed).into_iter().zip(self.edges.rest.iter().copied());
        Distribution::weighted(stretches).map_or(1.0, |stretches| stretches.percentile(0.5).exp())
    }

    /// The scale and the turn of a pose.
    pub fn frame(&self, posed: &[Point3<f64>]) -> PoseFrame {
        let of_corners = |positions: &[Point3<f64>]| -> Vec<Point3<f64>> {
            self.edges.corners.iter().flatten().map(|&v| positions[v as usize]).collect()
        };
        let (from, to) = (of_corners(posed), of_corners(&self.surface.positions));
        let similarity = Similarity::fit(&from, &to, &vec![1.0; from.len()], Orientation::Fitted);
        PoseFrame { scale: self.scale(posed), back: similarity.rotation }
    }

    /// The largest motion of a vertex, ‖Q ũ / κ − u‖ less the mean motion, in percent of the diagonal.
    pub fn reach(&self, posed: &[Point3<f64>]) -> f64 {
        let frame = self.frame(posed);
        let motion =
            |&v: &u32| frame.back * posed[v as usize].coords / frame.scale - self.surface.positions[v as usize].coords;
        let motions: Vec<Vector3<f64>> = self.edges.corners.iter().flatten().map(motion).collect();
        let mean = motions.iter().sum::<Vector3<f64>>() / motions.len().max(1) as f64;
        let largest = motions.iter().map(|d| (d - mean).norm()).filter(|size| size.is_finite()).fold(0.0, f64::max);
        100.0 * largest / self.diagonal
    }
}
