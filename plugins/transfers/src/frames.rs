//! Bound transfers that other transfers are made of, pose by pose or frame by frame.

use mimesh_core::{
    Result,
    stage::{BoundTransfer, Motion, Transferred},
};
use nalgebra::Point3;

/// A transfer within a motion: one that takes poses as frames, or one whose poses stand alone.
pub enum Frames<'a> {
    Motion(Box<dyn Motion + 'a>),
    Alone(&'a dyn BoundTransfer),
}

impl<'a> Frames<'a> {
    /// A fresh start of each of `transfers`; `None` if the poses of all of them stand alone.
    pub fn of(transfers: impl Iterator<Item = &'a dyn BoundTransfer>) -> Option<Vec<Self>> {
        let all: Vec<_> = transfers.map(|bound| bound.motion().map_or(Self::Alone(bound), Self::Motion)).collect();
        all.iter().any(|frames| matches!(frames, Self::Motion(_))).then_some(all)
    }

    /// The target at frame `frame`, when the source is at `posed`.
    pub fn frame(&mut self, frame: usize, posed: &[Point3<f64>]) -> Result<Transferred> {
        match self {
            Self::Motion(motion) => motion.frame(frame, posed),
            Self::Alone(bound) => bound.transfer(posed),
        }
    }
}

/// At most `wanted` of `poses`, spread over all.
pub fn evenly_spaced(poses: &[Vec<Point3<f64>>], wanted: usize) -> Vec<Vec<Point3<f64>>> {
    let count = poses.len().min(wanted);
    (0..count).map(|k| poses[k * poses.len() / count].clone()).collect()
}
