//! What a call of Python asks of a pipeline.

use std::path::{Path, PathBuf};

use mimesh_document::{Diagnostic, Document, Kind, diagnostic::Result};
use mimesh_pipeline::{
    Options, Prepared,
    cache::{Cache, DEFAULT_LIMIT},
    prepare_all, prepare_document,
};
use pyo3::prelude::*;
use serde::Deserialize;

use crate::{command_line::identity, in_memory::KeptMesh, mesh::MeshData};

/// A pipeline with what is asked of it, as Python writes it in JSON.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Job {
    /// The file of the pipeline; for one of no file what messages call it.
    pub file: PathBuf,
    /// The text of a pipeline that no file holds.
    pub text: Option<String>,
    /// `slot.key=value`, in the order given.
    pub set: Vec<String>,
    /// The folder for results.
    pub out: Option<PathBuf>,
    /// Folders whose files meshes may open.
    pub roots: Vec<PathBuf>,
    /// Whether stages may run programs.
    pub allow_commands: bool,
    /// Threads; 0 for all.
    pub threads: usize,
    /// Whether results of stages are cached.
    pub is_cached: bool,
    /// The folder of the cache, if it is not the user's own.
    pub cache: Option<PathBuf>,
}

impl Job {
    /// The job that `text` describes.
    ///
    /// # Errors
    ///
    /// A fault of the package itself.
    pub fn new(text: &str) -> Result<Self> {
        let wrong =
            |error: serde_json::Error| Diagnostic::new(Kind::Internal, format!("a job is not understood: {error}"));
        Ok(serde_json::from_str(text).map_err(wrong)?)
    }

    /// The cache, if there is to be one.
    ///
    /// # Errors
    ///
    /// If there is no folder for it.
    pub fn cache(&self) -> Result<Option<Cache>> {
        if !self.is_cached {
            return Ok(None);
        }
        Cache::new(self.cache.as_deref(), DEFAULT_LIMIT, identity()?).map(Some)
    }

    /// The runs of the pipeline, checked.
    ///
    /// # Errors
    ///
    /// All that can be found wrong without computing.
    pub fn prepare(&self, cache: Option<&Cache>) -> Result<Vec<Prepared>> {
        let options = Options {
            settings: self.set.clone(),
            out: self.out.clone(),
            roots: self.roots.clone(),
            allow_commands: self.allow_commands,
            view_script: mimesh::cli::view_script(),
            ..Options::default()
        };
        match &self.text {
            None => prepare_all(&self.file, &options, cache),
            Some(text) => prepare_document(Document::parse(Path::new(&self.file), text)?, &options, cache),
        }
    }
}

/// Keeps the meshes that the text of a pipeline names by their content.
pub fn keep(py: Python<'_>, meshes: &[(String, Py<MeshData>)]) -> Vec<KeptMesh> {
    let kept = |(name, mesh): &(String, Py<MeshData>)| KeptMesh::new(name, mesh.bind(py).get().sequence.clone());
    meshes.iter().map(kept).collect()
}
