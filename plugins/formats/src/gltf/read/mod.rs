//! glTF in: from bytes to a mesh with its poses.
//!
//! - [`container`], [`uri`], [`tree`], [`tolerant`], [`extensions`], [`asset`] and [`open`]: the JSON, made readable for `gltf-json`, and the bytes;
//! - [`meshopt`], [`draco`], [`views`] and [`accessor`]: numbers out of bytes;
//! - [`nodes`], [`scene`], [`skin`], [`morphs`], [`sampler`] and [`clips`]: what places and moves vertices;
//! - [`evaluator`] and [`poses`]: positions in any state of that;
//! - [`primitive`], [`attributes`], [`materials`], [`builder`] and [`reader`]: the mesh;
//! - [`empties`]: nodes that stand for points;
//! - [`untidy`], [`untidy_data`] and [`untidy_joints`]: what is read though it is not as it should be, which [`told`] holds.

mod accessor;
mod asset;
mod attributes;
mod builder;
mod clips;
mod container;
mod draco;
mod empties;
mod evaluator;
mod extensions;
mod materials;
mod meshopt;
mod morphs;
mod nodes;
mod open;
mod poses;
mod primitive;
mod reader;
mod sampler;
mod scene;
mod skin;
mod told;
mod tolerant;
mod tree;
mod untidy;
mod untidy_data;
mod untidy_joints;
mod uri;
mod views;

pub use asset::Asset;
pub use empties::points;
pub use reader::read;
