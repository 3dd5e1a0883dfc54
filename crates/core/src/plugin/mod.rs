//! The registry: which implementations of which stages are linked into the program.
//!
//! A stage trait `S` is made known once, by [`stage_kind!`](crate::stage_kind); an implementation registers itself with
//! [`register!`](crate::register) in its own file. All a [`Plugin`] says is derived from the implementing type: its name
//! in YAML from typetag, its schema with the doc comments from schemars, its defaults from `Default`.

pub(crate) mod ranges;
mod registry;
mod slot;

pub use ranges::{check_ranges, is_inside, range};
pub use registry::{Plugin, StageKind, all, configured, description, instance, instances, nested};
pub use slot::{slot, stage_of};
