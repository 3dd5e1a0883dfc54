//! The fast preview.

use mimesh_core::{plugin::instance, stage::Transfer};

/// Whether the stages of the fast preview are part of the program.
pub fn is_linked() -> bool {
    instance::<dyn Transfer>("biharmonic").is_some()
}
