//! `mimesh merge`: the files of all poses, of poses that parts of a run have computed.

use std::path::PathBuf;

use mimesh_document::{Diagnostic, Diagnostics, diagnostic::Result};
use {
    mimesh_pipeline as pipeline,
    mimesh_pipeline::{
        Options, Plan, Prepared,
        cache::Cache,
        shard::{COMPUTE_POSES, Merge, megabytes_of_poses, missing_poses},
        text::bytes,
    },
};

use crate::cli::{
    CommandResult, help_commands, overrides::Overrides, results_file::ResultsFile, run::Execution,
    shard_options::RunNames,
};

/// Writes all results of a pipeline whose poses were computed in parts, by `mimesh run --frames` or `--shard`.
///
/// Every pose is taken from the cache, and none is computed. The files have the bytes of a run that was not split; run.json differs in
/// times alone. If poses are missing, nothing is written: the command names them, and ends with status 75. A pose that failed in its part
/// is left out, as in a run.
#[derive(Debug, clap::Args)]
#[command(
    name = "merge",
    after_help = "Examples:
  mimesh merge horse-to-camel.yaml
  mimesh merge horse-to-camel.yaml --cache /farm/cache --json
  mimesh merge pipelines/herd.yaml --run camel"
)]
pub struct MergeCommand {
    /// The pipeline's YAML file
    pipeline: PathBuf,
    #[command(flatten)]
    overrides: Overrides,
    #[command(flatten)]
    runs: RunNames,
    /// Take frames of one motion whose parts were computed with `--warm N`, and tell how far the parts lie apart where they meet
    #[arg(long, value_name = "N")]
    warm: Option<usize>,
    #[command(flatten)]
    execution: Execution,
    /// Also write the table of results into this file, as .csv or .md
    #[arg(long, value_name = "FILE")]
    table: Option<PathBuf>,
    /// Let stages run programs that the pipeline names
    #[arg(long)]
    allow_commands: bool,
}

impl MergeCommand {
    /// Runs the command.
    pub fn run(&self) -> CommandResult {
        let table = self.table.as_deref().map(ResultsFile::new).transpose()?;
        let cache = self.execution.cache.open_shared("merge")?;
        let mut profiler = self.execution.profiler()?;
        let help = help_commands::of_pipeline(&self.pipeline);
        let runs = self.runs.names.clone();
        let options = Options { allow_commands: self.allow_commands, help, runs, ..self.overrides.options() };
        let all = pipeline::prepare_all(&self.pipeline, &options, Some(&cache))?;
        if let Some(table) = &table {
            table.check(&all)?;
        }
        let plan = |run: &Prepared| Plan::of_merge(run, &cache, Merge { warm: self.warm });
        let plans: Vec<Plan> = all.iter().map(plan).collect();
        self.check_complete(&all, &plans, &cache)?;
        if let Some(profiler) = &mut profiler {
            profiler.choose_file(&all, self.table.as_deref())?;
        }
        let plan = |i: usize, _: &Prepared| plans[i].clone();
        let results = self.execution.execute(&self.pipeline, &all, plan, Some(&cache), profiler.as_ref())?;
        if let Some(table) = &table {
            table.write(&results.0)?;
        }
        Ok(self.execution.finish(&results))
    }

    /// Checks that no pose of any run is missing.
    fn check_complete(&self, runs: &[Prepared], plans: &[Plan], cache: &Cache) -> Result<()> {
        let missing = |(run, plan): (&Prepared, &Plan)| Some(self.with_command(missing_poses(plan)?, run));
        let mut list: Vec<Diagnostic> = runs.iter().zip(plans).filter_map(missing).collect();
        if let Some(last) = list.last_mut()
            && let Some(full) = cache.store.bytes_if_full()
        {
            let limit = bytes(cache.store.limit());
            let megabytes = megabytes_of_poses(runs);
            let full = format!(
                "the cache has {} of the {limit} that it may grow to, and may have removed poses: give all parts `--cache-limit {megabytes}`",
                bytes(full)
            );
            last.hint = Some(last.hint.take().map_or_else(|| full.clone(), |hint| format!("{hint}; {full}")));
        }
        Diagnostics { list }.into_result()
    }

    /// The diagnostic of missing poses with the command that computes them.
    fn with_command(&self, mut diagnostic: Diagnostic, run: &Prepared) -> Diagnostic {
        let file = help_commands::argument(&self.pipeline);
        let name = &run.variant.name;
        diagnostic =
            if name.is_empty() { diagnostic.doing(&file) } else { diagnostic.doing(format!("{file}: {name}")) };
        if let Some(remedy) = diagnostic.remedy.take_if(|remedy| remedy.action == COMPUTE_POSES) {
            let mut command = format!("mimesh run {file}");
            if !name.is_empty() {
                command += &format!(" --run {}", help_commands::quoted(name));
            }
            command += &format!(" --frames {}", remedy.argument);
            if let Some(warm) = self.warm {
                command += &format!(" --warm {warm}");
            }
            for argument in self.overrides.arguments().into_iter().chain(self.execution.cache.arguments()) {
                command += &format!(" {}", help_commands::quoted(&argument));
            }
            let way_out = format!("{}: `{command}`", remedy.words);
            diagnostic.hint = Some(match diagnostic.hint.take() {
                Some(hint) => format!("{way_out}; {hint}"),
                None => way_out,
            });
        }
        diagnostic
    }
}
