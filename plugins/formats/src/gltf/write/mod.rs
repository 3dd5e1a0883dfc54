//! glTF out: the file that the mesh was read from with morph targets added ([`patch`]), or a new one ([`writer`]).

pub(super) mod binary;
mod materials;
mod offset;
mod options;
pub(super) mod output;
mod patch;
mod plan;
mod pose_clips;
pub mod size;
mod writer;

use mimesh_core::{
    mesh::Mesh,
    stage::{SequenceWriter, WriteError},
};

pub use options::{Options, PoseAnimation};
use patch::PatchWriter;
use writer::Writer;

/// A file of `mesh`: a copy of the glTF from which it was read, or a new one.
///
/// # Errors
///
/// If the mesh is damaged, or there is no room for temporary data.
pub fn start(options: Options, mesh: &Mesh) -> Result<Box<dyn SequenceWriter>, WriteError> {
    Ok(match PatchWriter::new(options, mesh)? {
        Some(writer) => Box::new(writer),
        None => Box::new(Writer::new(options, mesh)?),
    })
}
