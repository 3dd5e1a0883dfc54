//! glTF out: the file that the mesh was read from with morph targets added ([`patch`]), or a new one ([`writer`]).

pub(super) mod binary;
mod materials;
mod offset;
mod options;
pub(super) mod output;
mod patch;
mod plan;
mod pose_clips;
mod room;
pub mod size;
mod writer;

use mimesh_core::{
    mesh::Mesh,
    stage::{SequenceFile, SequenceWriter, WriteError},
};

pub use options::{Options, PoseAnimation};
use output::Output;
use patch::PatchWriter;
use writer::Writer;

/// Starts `file` with `mesh`: as a copy of the glTF from which it was read, or a new one. At most `poses` poses follow.
///
/// # Errors
///
/// If the mesh is damaged, or the file cannot be written.
pub fn start(
    options: Options,
    mesh: &Mesh,
    poses: usize,
    file: Box<dyn SequenceFile>,
) -> Result<Box<dyn SequenceWriter>, WriteError> {
    mesh.validate()?;
    let (output, binary) = Output::new(file, options.binary)?;
    Ok(match patch::document(mesh) {
        Some(document) => Box::new(PatchWriter::new(options, mesh, document, poses, output, binary)?),
        None => Box::new(Writer::new(options, mesh, poses, output, binary)?),
    })
}
