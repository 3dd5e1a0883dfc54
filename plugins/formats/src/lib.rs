//! File formats: each finds its files by extension, reads a mesh with its poses, and most write them.
//!
//! | type | extension | in | out |
//! |---|---|---|---|
//! | [`obj`](Obj) | obj | polygons, normals, texture coordinates, groups, materials | one file a pose |
//! | [`glb`](Glb), [`gltf`](Gltf) | glb, gltf | meshes of the scene, morph targets as poses | one file with all poses |
//! | [`ply`](Ply) | ply | polygons; normals, texture coordinates, colours of vertices | one file a pose |
//! | [`stl`](Stl) | stl | triangles | |
//!
//! Texture coordinates have their origin at the lower left, whatever the file says.

mod gltf;
mod normals;
mod number;
mod obj;
mod ply;
mod stl;

pub use gltf::{Glb, Gltf, LengthUnit, PoseAnimation, UpAxis};
pub use obj::Obj;
pub use ply::{Encoding, Ply, Precision};
pub use stl::Stl;
