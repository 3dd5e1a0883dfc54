//! Where points lie to each other: closest points of a surface, nearest neighbours, similarity transforms.

mod closest_point;
mod nearest;
mod similarity;

pub use closest_point::{ClosestPoint, OnSurface};
pub use nearest::Nearest;
pub use similarity::{Orientation, Similarity};
