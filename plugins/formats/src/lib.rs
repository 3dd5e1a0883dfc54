//! File formats: each finds its files by extension, reads a mesh with its poses, and most write them.
//!
//! | type | extension | in | out |
//! |---|---|---|---|
//! | [`obj`](Obj) | obj | polygons, normals, texture coordinates, colours of vertices, groups, materials with images | one file a pose |
//! | [`glb`](Glb), [`gltf`](Gltf) | glb, gltf | meshes of the scene, morph targets as poses | one file with all poses |
//! | [`fbx`](Fbx) | fbx | meshes of the scene in metres with Y up, blend shapes and frames of clips as poses | |
//! | [`ply`](Ply) | ply | polygons, strips; normals, texture coordinates, colours of vertices and faces | one file a pose |
//! | [`pc2`](Pc2), [`mdd`](Mdd) | pc2, mdd | frames as poses of the mesh in another file | one file with all poses |
//! | [`off`](Off) | off | polygons; normals, texture coordinates, colours of vertices and faces | one file a pose |
//! | [`stl`](Stl) | stl | triangles | one file a pose |
//! | [`usda`](Usda) | usda | | one file with all poses as time samples |
//!
//! Texture coordinates have their origin at the lower left, whatever the file says.

mod attributes;
mod beside;
mod clip_frames;
mod counts;
mod encoding;
mod extras;
mod fbx;
mod gltf;
mod images;
mod lost;
mod names;
mod normals;
mod number;
mod obj;
mod off;
mod paths;
mod ply;
mod point_cache;
mod single;
mod stl;
mod tail;
mod usd;

pub use fbx::Fbx;
pub use gltf::{Glb, Gltf, PoseAnimation};
pub use mimesh_core::spatial::{LengthUnit, UpAxis};
pub use obj::Obj;
pub use off::Off;
pub use ply::{Encoding, Ply, Precision};
pub use point_cache::{Mdd, Pc2};
pub use stl::Stl;
pub use usd::Usda;
