//! The JSON Schema of pipelines, the one home of what a value may be.
//!
//! [`SchemaNode`] finds the schema of a value by its path. `x-stage` is the kind of stage in a slot, `x-defaults` the slot's own
//! defaults, `x-renamed` earlier names of keys, and `x-file` marks settings that name a file. Ranges, choices, overrides,
//! suggestions, `show` and the cache ask it.

mod aliases;
mod defaults;
mod file;
mod node;
mod settings;
mod shapes;
mod values;
mod words;

pub use aliases::{check_aliases, expand_aliases};
pub use defaults::merge_slot_defaults;
pub use file::{COMPOSITION_KEYS, Composition, file_schema, is_of_whole_file};
pub use node::SchemaNode;
pub use settings::{description, inlined_settings_schema, settings_schema};
pub use shapes::{PipelineShapes, SchemaShapes, types};
pub use values::{FileSetting, check_ranges, file_settings, resolve_files};
pub use words::{choices, described_choices, range};
