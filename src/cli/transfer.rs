//! `mimesh transfer`: two mesh files in, motion out.

use std::path::PathBuf;

use mimesh_pipeline::Plan;

use crate::cli::{
    CommandResult,
    mesh_pair::{MeshPair, in_arguments},
    run::Execution,
    saved_pipeline::SavedPipeline,
    terminal,
};

/// Gives the poses of one mesh to another; all that is not said is chosen by the meshes.
///
/// The command runs the pipeline of the two files: corresponding points are found by shape where none are given, and so on.
/// The summary tells what was chosen and why, and `--save` writes it as a pipeline to go on from. Nothing is overwritten.
#[derive(Debug, clap::Args)]
#[command(
    name = "transfer",
    after_help = "Examples:
  mimesh transfer horse.glb camel.obj
  mimesh transfer horse.obj camel.obj --poses 'horse-??.obj' -o camel.glb -o camel.html
  mimesh transfer fox.glb wolf.glb --clip Run --markers pairs.yaml --save fox-to-wolf.yaml"
)]
pub struct TransferCommand {
    #[command(flatten)]
    meshes: MeshPair,
    /// Also write the pipeline with every choice spelled out into this file, for `mimesh run`
    #[arg(long, value_name = "FILE")]
    save: Option<PathBuf>,
    /// Overwrite results and a saved pipeline that are there already
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    execution: Execution,
}

impl TransferCommand {
    /// Runs the command.
    pub fn run(&self) -> CommandResult {
        let place = if self.force { SavedPipeline::replacing } else { SavedPipeline::new };
        let saved = self.save.as_deref().map(place).transpose()?;
        let cache = self.execution.cache.open()?;
        let mut profiler = self.execution.profiler()?;
        let all = self.meshes.prepare(cache.as_ref())?;
        if !self.force {
            // What is there may be a part of a run that was stopped.
            all.iter().flat_map(|run| &run.unfinished).for_each(|warning| terminal::warn(warning));
            self.meshes.check_is_new(&all)?;
        }
        if let Some(saved) = &saved {
            saved.write(&all)?;
        }
        if let Some(profiler) = &mut profiler {
            profiler.choose_file(&all, self.save.as_deref())?;
        }
        let results = self.execution.execute(
            self.meshes.name(),
            &all,
            |_, run| Plan::new(run, cache.as_ref()),
            cache.as_ref(),
            profiler.as_ref(),
        );
        let results = results.map_err(in_arguments)?;
        Ok(self.execution.finish(&results))
    }
}
