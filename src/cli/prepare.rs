//! `mimesh prepare`: the stages that run once, before parts of a run need them.

use std::path::PathBuf;

use serde_json::{Value, json};
use {
    mimesh_pipeline as pipeline,
    mimesh_pipeline::{
        Options, Plan, Prepared, Progress as _, prepare_stages,
        report::StageReport,
        text::{count, pairs, seconds},
    },
};

use crate::cli::{
    CommandResult, cache::CacheOptions, help_commands, overrides::Overrides, progress::ProgressOptions, run::threads,
    shard_options::RunNames, status::Status, terminal,
};

/// Computes the stages that run once, so that parts of a run find them in the cache.
///
/// These are the corresponding points that a stage proposes, the proximity graph and the correspondence. The transfer is bound once, which
/// finds what is wrong with it; each part binds it again, since a bound transfer is no data. What is cached is not computed again.
///
/// While a result is computed its entry is locked: another `prepare`, and a part that needs it, ends at once with status 75. The system
/// releases the lock when the process ends in any way. It holds between machines if the file system of the cache has locks.
#[derive(Debug, clap::Args)]
#[command(
    name = "prepare",
    after_help = "Examples:
  mimesh prepare horse-to-camel.yaml --cache /farm/cache
  mimesh prepare pipelines/herd.yaml --run camel --json"
)]
pub struct Prepare {
    /// The pipeline's YAML file
    pipeline: PathBuf,
    #[command(flatten)]
    overrides: Overrides,
    #[command(flatten)]
    runs: RunNames,
    #[command(flatten)]
    cache: CacheOptions,
    /// Threads to use; results do not depend on their number [default: all]
    #[arg(long, value_name = "N", value_parser = threads)]
    threads: Option<u16>,
    /// Print what is ready as JSON
    #[arg(long, conflicts_with = "progress")]
    json: bool,
    /// Print errors only
    #[arg(long, short)]
    quiet: bool,
    #[command(flatten)]
    progress: ProgressOptions,
    /// Let stages run programs that the pipeline names
    #[arg(long)]
    allow_commands: bool,
}

impl Prepare {
    /// Runs the command.
    pub fn run(&self) -> CommandResult {
        let cache = self.cache.open_shared("prepare")?;
        let help = help_commands::of_pipeline(&self.pipeline);
        let runs = self.runs.names.clone();
        let options = Options { allow_commands: self.allow_commands, help, runs, ..self.overrides.options() };
        let all = pipeline::prepare_all(&self.pipeline, &options, Some(&cache))?;
        let mut ready = Vec::new();
        for (i, run) in all.iter().enumerate() {
            let progress = self.progress.begin(self.quiet);
            if all.len() > 1 {
                progress.stage(&format!("{} ({} of {})", run.variant.name, i + 1, all.len()));
            }
            let stages = prepare_stages(run, self.threads.map_or(0, usize::from), &cache, &progress);
            progress.finish();
            let stages = stages?.into_iter().filter(|stage| !stage.name.is_empty()).collect();
            let missing = Plan::new(run, Some(&cache)).missing().len();
            ready.push(Ready { run, stages, cached: run.poses.len() - missing });
        }
        if !self.json && !self.quiet {
            cache.warnings().iter().for_each(|warning| terminal::warn(warning));
        }
        match &ready[..] {
            [one] if self.json => terminal::print_json(&one.json()),
            several if self.json => terminal::print_json(&several.iter().map(Ready::json).collect::<Vec<_>>()),
            _ if self.quiet => {}
            ready => terminal::print(&ready.iter().map(Ready::text).collect::<Vec<_>>().join("\n")),
        }
        Ok(Status::Done)
    }
}

/// What is ready of a run.
struct Ready<'a> {
    run: &'a Prepared,
    stages: Vec<StageReport>,
    /// The number of poses that have results.
    cached: usize,
}

impl Ready<'_> {
    fn text(&self) -> String {
        let row = |stage: &StageReport| {
            let how = match stage.reused {
                true => "cached".into(),
                false if stage.stage == "transfer" => {
                    format!("bound in {}; each part binds it again", seconds(stage.seconds))
                }
                false => format!("computed in {}", seconds(stage.seconds)),
            };
            (format!("{} ({})", stage.stage, stage.name), how)
        };
        let poses = format!("{} of {} cached", self.cached, count(self.run.poses.len(), "pose", "poses"));
        let rows: Vec<_> = self.stages.iter().map(row).chain([("poses".to_owned(), poses)]).collect();
        let name = &self.run.variant.name;
        if name.is_empty() { pairs(&rows) } else { format!("{name}\n{}", pairs(&rows)) }
    }

    fn json(&self) -> Value {
        let mut value =
            json!({ "stages": self.stages, "poses": { "cached": self.cached, "of": self.run.poses.len() } });
        if !self.run.variant.name.is_empty() {
            value["run"] = self.run.variant.name.clone().into();
        }
        value
    }
}
