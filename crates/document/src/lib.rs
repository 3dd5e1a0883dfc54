//! YAML documents that know where each of their values was written.
//!
//! A [`Document`] is read with [`include::read`], changed by [`overrides`] and [`variables`], and turned into typed values by
//! [`deserialize()`]. What is wrong on the way becomes [`Diagnostics`], each at its place in the file. The crate knows no mesh and
//! no stage: what a program knows of its values it says by implementing [`Shapes`].
//!
//! In reading order: [`diagnostic`], [`source_tree`], [`document`], [`merge`], [`mod@include`], [`variables`], [`overrides`],
//! [`mod@deserialize`].

pub mod braces;
pub mod cells;
mod describe;
pub mod deserialize;
pub mod diagnostic;
pub mod document;
pub mod encoding;
pub mod files;
mod finite;
pub mod include;
pub mod limits;
pub mod merge;
pub mod overrides;
pub mod paths;
pub mod serde_errors;
pub mod shapes;
pub mod source_tree;
pub mod step;
pub mod suggest;
pub mod variables;
pub mod yaml;

pub use describe::describe;
pub use deserialize::deserialize;
pub use diagnostic::{Diagnostic, Diagnostics, Kind, Location, Remedy, Result};
pub use document::{At, Document};
pub use shapes::{NoShapes, Shapes, Variants};
pub use step::{Step, path};
