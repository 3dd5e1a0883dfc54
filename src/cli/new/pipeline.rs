//! `mimesh new pipeline`: a pipeline for two meshes to begin with.

use std::path::PathBuf;

use mimesh_pipeline::{choices::rows, text::pairs};

use crate::cli::{
    CommandResult, cache::CacheOptions, mesh_pair::MeshPair, saved_pipeline::SavedPipeline, status::Status, terminal,
};

/// Writes a pipeline for two meshes, with comments.
///
/// All that is not said is chosen by the meshes, as `mimesh transfer` does, and stands in the file with the reason. Nothing runs.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  mimesh new pipeline horse.obj camel.obj --poses 'horse-??.obj'")]
pub struct NewPipeline {
    #[command(flatten)]
    meshes: MeshPair,
    /// Write this file, which must not exist [default: TARGET-from-SOURCE.yaml]
    #[arg(long, value_name = "FILE")]
    path: Option<PathBuf>,
    #[command(flatten)]
    cache: CacheOptions,
}

impl NewPipeline {
    /// Runs the command.
    pub fn run(&self) -> CommandResult {
        let file = self.path.clone().unwrap_or_else(|| format!("{}.yaml", self.meshes.stem()).into());
        let saved = SavedPipeline::named("--path", &file)?;
        let all = self.meshes.prepare(self.cache.open()?.as_ref())?;
        saved.write(&all)?;
        let shown = file.display();
        let chosen: String = all.iter().map(|prepared| rows(&prepared.choices)).collect();
        terminal::print(&format!(
            "wrote {shown}\n{chosen}\n{}",
            pairs(&[
                (format!("mimesh check {shown}"), "finds mistakes".into()),
                (format!("mimesh run {shown}"), "runs it".into()),
            ])
        ));
        Ok(Status::Done)
    }
}
