//! Pictures of meshes and of a run's poses.
//!
//! - [`Camera`]: the side that meshes are seen from;
//! - [`draw_mesh`], [`draw_markers`]: a mesh with its errors, or with numbered points;
//! - [`Thumbnails`]: source, result and errors of each pose, drawn while poses stream by;
//! - [`too_large_to_turn`]: the limit for pages that show meshes in 3D.

mod alignment;
mod camera;
mod drawing;
mod scene;
mod thumbnails;

pub use camera::Camera;
pub use drawing::{draw_markers, draw_mesh, image};
pub use scene::too_large_to_turn;
pub use thumbnails::{PoseView, Thumbnails};
