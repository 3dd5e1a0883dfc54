use std::path::PathBuf;

use super::{Ended, cache::CacheOptions, progress::Progress, summary, terminal};
use crate::{
    pipeline::{self, Options, staging},
    status::Status,
};

/// Runs a pipeline: pairs the meshes, transfers every pose and writes the results.
///
/// Beside the first result a `run.json` records settings, inputs and figures. Inputs are never overwritten, and a run
/// that fails leaves what was there before.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  mimesh run horse-to-camel.yaml
  mimesh run horse-to-camel.yaml --set transfer.type=copy_displacement --out try
  mimesh run horse-to-camel.yaml --set 'output=[out/{pose}.ply]' --json")]
pub struct Run {
    /// The pipeline's YAML file
    pipeline: PathBuf,
    #[command(flatten)]
    overrides: Overrides,
    #[command(flatten)]
    cache: CacheOptions,
    /// Threads to use; results do not depend on their number [default: all]
    #[arg(long, value_name = "N", value_parser = threads)]
    threads: Option<u16>,
    /// Print the report (the contents of run.json) to stdout instead of the summary
    #[arg(long)]
    json: bool,
    /// Tell nothing but errors
    #[arg(long, short)]
    quiet: bool,
}

/// What `run` and `check` let the command line change.
#[derive(Debug, clap::Args)]
pub struct Overrides {
    /// Replace a value of the file, e.g. transfer.type=gradient; the value is YAML, its paths relative to the file
    #[arg(long = "set", value_name = "KEY=VALUE")]
    settings: Vec<String>,
    /// Write all results into this folder instead
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

impl Overrides {
    /// As the pipeline takes them.
    pub fn options(&self) -> Options {
        Options { settings: self.settings.clone(), out: self.out.clone() }
    }
}

impl Run {
    /// Runs the command.
    pub fn run(&self) -> Ended {
        // Without a handler an interrupt would leave files that are half written.
        let _ = ctrlc::set_handler(|| staging::discard_all_and_exit(Status::Interrupted as u8));
        let options = self.overrides.options();
        let progress = Progress::new(self.quiet);
        let prepared = pipeline::prepare(&self.pipeline, &options)?;
        let tell = !self.json && !self.quiet;
        if tell {
            // Before what they warn of may fail.
            prepared.warnings.iter().for_each(|warning| terminal::warn(warning));
        }
        let cache = self.cache.open()?;
        let threads = self.threads.map_or(0, usize::from);
        let outcome = pipeline::run(&prepared, &options.settings, threads, cache.as_ref(), &progress);
        progress.finish();
        let outcome = outcome?;
        outcome.failed.iter().for_each(terminal::tell_one);
        if self.json {
            terminal::print_json(&outcome.report);
        } else if tell {
            let new = outcome.report.warnings.iter().filter(|warning| !prepared.warnings.contains(warning));
            new.for_each(|warning| terminal::warn(warning));
            terminal::print(&summary::of(&outcome.report, &prepared.outputs.report));
        }
        Ok(outcome.status())
    }
}

/// A number of threads.
fn threads(text: &str) -> Result<u16, String> {
    text.parse()
        .ok()
        .filter(|count| *count > 0)
        .ok_or_else(|| format!("expected a whole number from 1 to {}", u16::MAX))
}
