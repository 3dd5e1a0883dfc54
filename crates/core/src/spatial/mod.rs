//! Spatial search: closest points of a surface, nearest neighbours, paths along it, similarity transforms, mirror images, units and axes.

mod closest_point;
mod edge_paths;
mod handedness;
mod mirror_map;
mod nearest;
mod similarity;
mod surface_distance;
mod unit_axes;

pub use closest_point::{ClosestPoint, OnSurface};
pub use edge_paths::EdgePaths;
pub use handedness::{MIRRORED, mirror_gain, whitened};
pub use mirror_map::MirrorMap;
pub use nearest::Nearest;
pub use similarity::{Orientation, Oriented, Similarity, Taken, angle_between};
pub use surface_distance::{DistanceSearch, SurfaceDistance};
pub use unit_axes::{Axes, LengthUnit, MeshUnits, UnitAxes, UpAxis};
