//! Sets of shapes: which are taken, what they are called, how strong they are and where they may move the target.
//!
//! - [`ShapeSettings`]: what a pipeline says of them;
//! - [`Convention`]: the names that programs give to shapes of faces;
//! - [`side`]: left and right in names;
//! - [`ShapeEdit`]: what becomes of one shape;
//! - [`ShapeEditor`]: that which makes it so;
//! - [`read_mask`]: a painted mask.

mod conventions;
mod edit;
mod editor;
mod mask_file;
mod settings;
mod sides;

pub use conventions::Convention;
pub use edit::{Region, ShapeEdit};
pub use editor::ShapeEditor;
pub use mask_file::read_mask;
pub use settings::{Channel, Mask, Mirror, ShapeSettings};
pub use sides::{Side, side};
