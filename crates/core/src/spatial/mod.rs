//! Spatial search: closest points of a surface, nearest neighbours, paths along it, similarity transforms.

mod closest_point;
mod edge_paths;
mod nearest;
mod similarity;

pub use closest_point::{ClosestPoint, OnSurface};
pub use edge_paths::EdgePaths;
pub use nearest::Nearest;
pub use similarity::{Orientation, Similarity};
