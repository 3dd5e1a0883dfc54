//! Point caches, in and out: positions of the vertices of a mesh at many times, without the mesh.
//!
//! [`samples`] reads, [`spool`] writes; [`pc2`] and [`mdd`] are the two layouts.

mod mdd;
mod pc2;
mod samples;
mod spool;

pub use mdd::Mdd;
pub use pc2::Pc2;
