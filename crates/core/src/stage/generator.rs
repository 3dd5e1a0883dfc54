use std::fmt::Debug;

use crate::{Result, mesh::MeshSequence};

/// Makes a mesh with poses, so that pipelines run without any file.
///
/// # Contract
///
/// - rest and poses are finite, valid and of one vertex count;
/// - equal settings give equal meshes, on one thread or many.
#[typetag::serde(tag = "type")]
pub trait Generator: Debug + Send + Sync {
    /// The mesh, its poses and its named landmarks.
    ///
    /// Used as a target, the poses are the known result to which a transfer is compared.
    ///
    /// # Errors
    ///
    /// [`Error::Setting`](crate::Error::Setting) for settings out of range.
    fn make(&self) -> Result<MeshSequence>;
}

crate::stage_kind!(Generator, "generator");
