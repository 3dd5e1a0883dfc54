//! What is open: two meshes with poses, the document of markers and the pipeline.

mod facts;
mod initial;
mod open;
mod poses;
mod recent;
mod state;

pub use facts::SessionView;
pub use open::{Context, Opening};
pub use state::{Project, Ready};
