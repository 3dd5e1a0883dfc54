//! `mimesh run`: the runs that a pipeline declares, and their results.

use std::{
    collections::HashSet,
    path::{Path, PathBuf},
    time::Instant,
};

use mimesh_document::diagnostic::{Diagnostics, Kind, Result};
use {
    mimesh_pipeline as pipeline,
    mimesh_pipeline::{
        Finished, Options, Plan, Prepared, Progress as _,
        cache::Cache,
        metrics::Level,
        report::{Results, Row, RunOutcome},
        staging,
    },
};

use crate::cli::{
    cache::CacheOptions,
    flags::with_flags,
    help_commands,
    overrides::Overrides,
    profile::Profiler,
    progress::{ProgressOptions, TerminalProgress},
    results_file::ResultsFile,
    saved_pipeline::SavedPipeline,
    shard_options::{self, RunNames, ShardOptions},
    status::Status,
    summary, terminal,
};

/// Runs a pipeline: pairs the meshes, transfers every pose and writes the results.
///
/// Several targets or a matrix of settings make several runs, with a table of results at the end. A run that fails does
/// not stop the others.
///
/// Beside the first result, `run.json` records settings, inputs and statistics. Inputs are never overwritten. A run
/// that fails leaves earlier results as they were.
///
/// `--frames` and `--shard` compute a part of the poses, on any machine that shares the cache. `mimesh merge` then writes
/// the files of all poses, with the bytes of a run that was not split.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  mimesh run horse-to-camel.yaml
  mimesh run horse-to-camel.yaml --set transfer.type=copy_displacement --out try
  mimesh run horse-to-camel.yaml --set 'output=[out/{pose}.ply]' --json
  mimesh run horse-to-camel.yaml --no-cache --profile
  mimesh run horse-to-camel.yaml --frames 0-24 --cache /farm/cache
  mimesh run horse-to-camel.yaml --shard 0/4 --cache /farm/cache
  mimesh run pipelines/herd.yaml --set variables.detail=30 --table herd.csv")]
pub struct Run {
    /// The pipeline's YAML file
    pipeline: PathBuf,
    #[command(flatten)]
    overrides: Overrides,
    #[command(flatten)]
    runs: RunNames,
    #[command(flatten)]
    part: ShardOptions,
    #[command(flatten)]
    execution: Execution,
    /// Also write the table of results into this file, as .csv or .md
    #[arg(long, value_name = "FILE", conflicts_with_all = ["frames", "shard"])]
    table: Option<PathBuf>,
    /// Let stages run programs that the pipeline names
    #[arg(long)]
    allow_commands: bool,
    /// Also write the pipeline with every choice spelled out into this file, which must not exist; for a single run
    #[arg(long, value_name = "FILE")]
    save: Option<PathBuf>,
}

/// How runs are executed, and what they print.
#[derive(Debug, clap::Args)]
pub struct Execution {
    #[command(flatten)]
    pub cache: CacheOptions,
    /// Threads to use; results do not depend on their number [default: all]
    #[arg(long, value_name = "N", value_parser = threads)]
    threads: Option<u16>,
    /// Print the report as JSON instead of the summary: run.json, or the table of several runs with their reports
    #[arg(long, conflicts_with = "progress")]
    json: bool,
    /// Print errors only
    #[arg(long, short)]
    quiet: bool,
    #[command(flatten)]
    progress: ProgressOptions,
    /// Also show where the time went, and write a trace to open at ui.perfetto.dev [default: profile.json, beside the report]
    #[arg(long, value_name = "FILE", num_args = 0..=1, require_equals = true)]
    profile: Option<Option<PathBuf>>,
}

impl Run {
    /// Runs the command.
    pub fn run(&self) -> super::CommandResult {
        let table = self.table.as_deref().map(ResultsFile::new).transpose()?;
        let saved = self.save.as_deref().map(SavedPipeline::new).transpose()?;
        let cache = self.execution.cache.open()?;
        let mut profiler = self.execution.profiler()?;
        let help = help_commands::of_pipeline(&self.pipeline);
        let runs = self.runs.names.clone();
        let options = Options { allow_commands: self.allow_commands, help, runs, ..self.overrides.options() };
        let all = pipeline::prepare_all(&self.pipeline, &options, cache.as_ref())?;
        let parts = self.part.parts(&self.pipeline, &all, cache.as_ref())?;
        if let Some(table) = &table {
            table.check(&all)?;
        }
        if let Some(saved) = &saved {
            saved.write(&all)?;
        }
        if let Some(profiler) = &mut profiler {
            profiler.choose_file(&all, [&self.table, &self.save].into_iter().filter_map(|file| file.as_deref()))?;
        }
        let plan = |i: usize, run: &Prepared| shard_options::plan(run, i, parts.as_deref(), cache.as_ref());
        let results = self.execution.execute(&self.pipeline, &all, plan, cache.as_ref(), profiler.as_ref())?;
        if let Some(table) = &table {
            table.write(&results.0)?;
        }
        let status = self.execution.finish(&results);
        if parts.is_some() && !self.execution.json && !self.execution.quiet {
            terminal::print_beside(&format!("{}\n", self.what_is_left(&all)));
        }
        Ok(status)
    }

    /// What a part of `runs` leaves to a merge, with the command.
    fn what_is_left(&self, runs: &[Prepared]) -> String {
        let of_all: Vec<_> = runs.iter().flat_map(|run| run.outputs.files_of_all()).collect();
        let reports = runs.iter().map(|run| run.outputs.report.as_path());
        let left: Vec<_> = of_all.into_iter().chain(reports).collect();
        let first = left.first().map_or_else(String::new, |file| file.display().to_string());
        let more = if left.len() > 1 { format!(" and {} more", left.len() - 1) } else { String::new() };
        let mut command = format!("mimesh merge {}", help_commands::argument(&self.pipeline));
        let given = self.runs.arguments().into_iter().chain(self.part.warm_arguments());
        for argument in given.chain(self.overrides.arguments()).chain(self.execution.cache.arguments()) {
            command += &format!(" {}", help_commands::quoted(&argument));
        }
        format!("`{command}` writes {first}{more} when all poses are computed")
    }
}

impl Execution {
    /// Begins to record, if the user wants a profile.
    ///
    /// # Errors
    ///
    /// Those of [`Profiler::begin`].
    pub fn profiler(&self) -> Result<Option<Profiler>> {
        self.profile.as_ref().map(|file| Profiler::begin(file.as_deref())).transpose()
    }

    /// Runs all that is prepared from `file` as `plan` says, and shows what happens; with the results the table of the profile, if there is one.
    ///
    /// # Errors
    ///
    /// The failure of a single run; that of one of several is among the results.
    pub fn execute(
        &self,
        file: &Path,
        all: &[Prepared],
        plan: impl Fn(usize, &Prepared) -> Plan,
        cache: Option<&Cache>,
        profiler: Option<&Profiler>,
    ) -> Result<(Results, Option<String>)> {
        let results = self.execute_all(file, all, plan, cache);
        // A run that fails has a trace too.
        let profile = profiler.map(Profiler::finish).transpose();
        Ok((results?, profile?))
    }

    fn execute_all(
        &self,
        file: &Path,
        all: &[Prepared],
        plan: impl Fn(usize, &Prepared) -> Plan,
        cache: Option<&Cache>,
    ) -> Result<Results> {
        // Without a handler an interrupt would leave files that are half written.
        let _ = ctrlc::set_handler(|| staging::discard_all_and_exit(Status::Interrupted as u8));
        let mut shown_warnings = HashSet::new();
        let mut results = Results { pipeline: file.into(), rows: vec![] };
        for (i, prepared) in all.iter().enumerate() {
            let started = Instant::now();
            let progress = self.progress.begin(self.quiet);
            if all.len() > 1 {
                progress.stage(&format!("{} ({} of {})", prepared.variant.name, i + 1, all.len()));
            }
            // The run may fail for the reason that a warning gives, so that warnings come first.
            self.warn(&prepared.warnings, &mut shown_warnings);
            let finished = self.run_one(prepared, &plan(i, prepared), cache, &progress);
            progress.finish();
            shown_warnings.extend(progress.warned());
            let outcome = match finished {
                Ok(finished) => self.report(finished, &mut shown_warnings),
                // A single run that fails is the failure of the command.
                Err(failure) if all.len() == 1 => return Err(failure),
                Err(failure) => report_failure(failure, &prepared.variant.name),
            };
            results.rows.push(Row {
                variant: prepared.variant.clone(),
                place: prepared.outputs.report.clone(),
                outcome,
                seconds: started.elapsed().as_secs_f64() + prepared.seconds(),
            });
        }
        Ok(results)
    }

    /// Prints the results and the table of the profile; the exit status of all runs together.
    pub fn finish(&self, (results, profile): &(Results, Option<String>)) -> Status {
        self.print(results);
        match profile {
            Some(_) if self.quiet => {}
            Some(text) if self.json => terminal::print_beside(text),
            Some(text) => terminal::print(text),
            None => {}
        }
        status(results)
    }

    /// Executes one of the declared runs.
    fn run_one(
        &self,
        prepared: &Prepared,
        plan: &Plan,
        cache: Option<&Cache>,
        progress: &TerminalProgress,
    ) -> Result<Finished> {
        pipeline::run(prepared, plan, self.threads.map_or(0, usize::from), cache, progress)
    }

    /// Shows the failed poses and the warnings of a run that has results.
    fn report(&self, finished: Finished, shown_warnings: &mut HashSet<String>) -> RunOutcome {
        finished.failed.iter().for_each(terminal::report_one);
        // A broken gate explains exit status 3. Without a summary nothing else would name it.
        if self.json || self.quiet {
            let broken_gates = summary::reasons(&finished.report, Level::Failed);
            broken_gates.iter().for_each(|line| terminal::warn(line));
        }
        self.warn(&finished.report.warnings, shown_warnings);
        RunOutcome::Report(Box::new(finished.report))
    }

    /// Shows the warnings that have not been shown yet, unless `--json` or `--quiet` is given.
    fn warn(&self, warnings: &[String], shown: &mut HashSet<String>) {
        if self.json || self.quiet {
            return;
        }
        for warning in warnings {
            if shown.insert(warning.clone()) {
                terminal::warn(warning);
            }
        }
    }

    /// Prints the results to stdout in the form that the flags ask for.
    fn print(&self, results: &Results) {
        match &results.rows[..] {
            [Row { outcome: RunOutcome::Report(report), .. }] if self.json => {
                terminal::print_json(report);
            }
            [Row { outcome: RunOutcome::Report(report), place, .. }] if !self.quiet => {
                terminal::print(&summary::of_run(report, place));
            }
            _ if self.json => terminal::print_json(&results.json()),
            _ if !self.quiet => terminal::print(&summary::of_runs(results)),
            _ => {}
        }
    }
}

/// Shows why one of several runs failed.
fn report_failure(failure: Diagnostics, run: &str) -> RunOutcome {
    let diagnostics: Vec<_> = failure.list.into_iter().map(|diagnostic| with_flags(&diagnostic.doing(run))).collect();
    diagnostics.iter().for_each(terminal::report_one);
    RunOutcome::Failed(diagnostics)
}

/// The exit status of all runs together.
///
/// It is that of a broken gate if nothing is worse, and "partly done" if only some of several runs gave results.
fn status(results: &Results) -> Status {
    let failed = results.rows.iter().filter_map(|row| match &row.outcome {
        RunOutcome::Failed(diagnostics) => Some(diagnostics),
        RunOutcome::Report(_) => None,
    });
    match results.status() {
        "done" => Status::Done,
        "gate" => Status::Gate,
        "failed" => Kind::of_all(failed.flatten().map(|diagnostic| diagnostic.kind)).into(),
        _ => Status::Partly,
    }
}

/// More threads than this no machine has cores for, and each takes memory.
const MAX_THREADS: u16 = 1024;

/// Parses a number of threads.
pub fn threads(text: &str) -> std::result::Result<u16, String> {
    text.parse()
        .ok()
        .filter(|count| (1..=MAX_THREADS).contains(count))
        .ok_or_else(|| format!("expected a whole number from 1 to {MAX_THREADS}"))
}
