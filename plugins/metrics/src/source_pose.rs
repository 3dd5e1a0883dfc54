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
    /// The vertices that edges use, and the number of edges of each.
    used: Vec<u32>,
    edges_at: Vec<f64>,
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
        let edges = elements::edges(surface);
        let mut count = vec![0.0; surface.vertex_count()];
        edges.corners.iter().flatten().for_each(|&v| count[v as usize] += 1.0);
        let used: Vec<u32> = (0..surface.vertex_count() as u32).filter(|&v| count[v as usize] > 0.0).collect();
        let edges_at = used.iter().map(|&v| count[v as usize]).collect();
        Self { surface, diagonal: surface.diagonal(), edges, used, edges_at }
    }

    /// The scale of a pose; 1 where nothing is finite.
    pub fn scale(&self, posed: &[Point3<f64>]) -> f64 {
        self.scale_of(&self.edges.sizes(posed))
    }

    /// The scale of a pose with edges of these lengths.
    fn scale_of(&self, lengths: &[f64]) -> f64 {
        let stretches = self.edges.ratios(lengths).into_iter().zip(self.edges.rest.iter().copied());
        Distribution::weighted(stretches).map_or(1.0, |stretches| stretches.percentile(0.5))
    }

    /// The scale and the turn of a pose.
    pub fn frame(&self, posed: &[Point3<f64>]) -> PoseFrame {
        self.frame_of(posed, &self.edges.sizes(posed))
    }

    /// The same of a pose whose edges have these lengths. Each vertex counts by its edges.
    pub fn frame_of(&self, posed: &[Point3<f64>], lengths: &[f64]) -> PoseFrame {
        let of_used = |positions: &[Point3<f64>]| -> Vec<Point3<f64>> {
            self.used.iter().map(|&v| positions[v as usize]).collect()
        };
        let (from, to) = (of_used(posed), of_used(&self.surface.positions));
        let similarity = Similarity::fit(&from, &to, &self.edges_at, Orientation::Fitted);
        PoseFrame { scale: self.scale_of(lengths), back: similarity.rotation }
    }

    /// The largest motion of a vertex, ‖Q ũ / κ − u‖ less the mean motion, in percent of the diagonal; `frame` is that of the pose.
    pub fn reach(&self, posed: &[Point3<f64>], frame: &PoseFrame) -> f64 {
        let back = frame.back / frame.scale;
        let motion = |&v: &u32| back * posed[v as usize].coords - self.surface.positions[v as usize].coords;
        let motions: Vec<Vector3<f64>> = self.used.iter().map(motion).collect();
        let weighted = motions.iter().zip(&self.edges_at).map(|(motion, edges)| motion * *edges);
        let mean = weighted.sum::<Vector3<f64>>() / self.edges_at.iter().sum::<f64>().max(1.0);
        let largest = motions.iter().map(|d| (d - mean).norm()).filter(|size| size.is_finite()).fold(0.0, f64::max);
        100.0 * largest / self.diagonal
    }
}
