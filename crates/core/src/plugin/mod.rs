//! The registry: which implementations of which stages are linked into the program.
//!
//! A stage trait `S` is made known once, by [`stage_kind!`](crate::stage_kind); an implementation registers itself with
//! [`register!`](crate::register) in its own file. All a [`Plugin`] says is derived from the implementing type: its name
//! in YAML from typetag, its schema with the doc comments from schemars, its defaults from `Default`. An [`Alias`] is a stage that the
//! program learns of while it runs.

mod alias;
pub(crate) mod ranges;
mod registry;
mod slot;

pub use alias::alias;
pub use ranges::{check_ranges, check_values, is_inside, range};
pub use registry::{Alias, Plugin, StageKind, all, changes, configured, description, instance, instances, nested};
#[doc(hidden)]
pub use registry::{Implementation, ImplementingType};
pub use slot::{slot, stage_of};
