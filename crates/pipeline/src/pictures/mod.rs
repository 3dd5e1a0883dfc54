//! Pictures of meshes and of a run's poses.
//!
//! - [`Camera`]: the side that meshes are seen from;
//! - [`draw_mesh`], [`draw_markers`]: a mesh with its errors, or with numbered points;
//! - [`Thumbnails`]: source, result and errors of each pose, drawn while poses stream by.

mod alignment;
mod camera;
mod drawing;
mod thumbnails;

pub use camera::Camera;
pub use drawing::{draw_markers, draw_mesh, image};
pub use thumbnails::{PoseView, Thumbnails};
