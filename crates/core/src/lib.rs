//! The vocabulary of deformation transfer: meshes, operators, solvers and the stage traits.
//!
//! In reading order:
//! - [`mesh`]: the user's [`Mesh`](mesh::Mesh) as its file gives it, and the welded, triangulated
//!   [`Surface`](mesh::Surface) that stages compute on;
//! - [`operators`]: Laplacian, mass, gradient, deformation gradients, polar decomposition;
//! - [`linalg`]: sparse symmetric systems, factored once and solved often;
//! - [`spatial`]: closest points and nearest neighbours, similarity transforms;
//! - [`memory`]: what the process may take of it;
//! - [`random`]: seeded random numbers, the same everywhere;
//! - [`stage`]: one trait a stage of a pipeline, with the data that passes between stages;
//! - [`plugin`]: the registry of implementations linked into the program.
//!
//! This crate knows no method and no pipeline, reads no file and prints nothing.
//!
//! # Notation
//!
//! V, #V × 3, are vertex positions in the unit of the file and F, #F × 3, corners of triangles, counter-clockwise seen
//! from outside; `rest` is undeformed and `posed` deformed; a `source` gives its motion to a `target`.

mod error;
pub mod figures;
pub mod linalg;
pub mod memory;
pub mod mesh;
pub mod operators;
pub mod plugin;
pub mod random;
pub mod spatial;
pub mod stage;
#[cfg(any(test, feature = "testkit"))]
pub mod testkit;

pub use error::{Error, Result};
pub use figures::Figures;
pub use plugin::Plugin;

#[doc(hidden)]
pub use inventory;
#[doc(hidden)]
pub use schemars;
#[doc(hidden)]
pub use serde_json;
