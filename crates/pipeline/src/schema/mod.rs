//! The JSON Schema of pipelines, the one home of what a value may be.
//!
//! [`SchemaNode`] finds the schema of a value by its path; the kind of stage in a slot stands there as `x-stage`, the slot's own
//! defaults as `x-defaults`, earlier names of keys as `x-renamed`, and settings that name a file as `x-file`. Ranges, choices,
//! overrides, suggestions, `show` and the cache ask it.

mod defaults;
mod file;
mod node;
mod settings;
mod shapes;
mod values;
mod words;

pub use defaults::merge_slot_defaults;
pub use file::{Composition, file_schema};
pub use node::SchemaNode;
pub use settings::{description, inlined_settings_schema, settings_schema};
pub use shapes::{PipelineShapes, types};
pub use values::{FileSetting, check_ranges, file_settings, resolve_files};
pub use words::{choices, described_choices, range};
