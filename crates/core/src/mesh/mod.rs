//! Meshes: what a file gives, and what stages compute on.
//!
//! [`Mesh`] keeps the user's file: polygons, vertex order and count, texture coordinates, normals, parts and materials.
//! [`Surface`] is the view that stages solve on: polygons cut into triangles (a fan from the first corner), seams welded.
//! Results on a surface go back to every vertex of the mesh through [`Surface::to_mesh`].

mod attributes;
mod bounds;
mod coarse;
mod collapsing;
mod frames;
mod mesh_point;
mod outward;
mod polygon_mesh;
mod polygons;
mod pose;
mod seams;
mod sequence;
mod simplify;
mod statistics;
mod strays;
mod surface;
mod surface_point;
mod topology;
mod weld;

pub use attributes::{CornerAttribute, Image, Material, Part};
pub use bounds::{MAX_COORDINATE, bounding_box, check_finite, diagonal};
pub use coarse::{Coarse, coarsen};
pub use frames::{PosesAre, poses_are_frames};
pub use mesh_point::MeshPoint;
pub use outward::inward_components;
pub use polygon_mesh::{Document, Mesh};
pub use polygons::Polygons;
pub use pose::{ClipTime, ComputePoses, Pose, Positions};
pub use seams::Seams;
pub use sequence::{Animation, Landmark, MeshSequence};
pub use simplify::{simplify, simplify_keeping};
pub use statistics::Statistics;
pub use strays::Stray;
pub use surface::Surface;
pub use surface_point::SurfacePoint;
pub use topology::{Components, Topology};
pub use weld::Welding;
