//! The choices that a pipeline leaves to the program: slots that are left out, or `auto`.
//!
//! They are made once the meshes are read, and before anything is computed. What was chosen stands in the typed pipeline as if the user
//! had named it, so that plans, keys and reports know no difference.

mod choice;
mod overlap;
mod slots;
mod stages;

pub use self::choice::{Choice, rows};
pub use self::slots::{AUTO, Open, is_open, stage_or_auto};
pub(crate) use self::stages::{choose_markers, choose_proximity, choose_stages, in_order};
