use std::{
    collections::HashSet,
    path::{Path, PathBuf},
    time::Instant,
};

use super::{cache::CacheOptions, progress::Progress, summary, terminal};
use crate::{
    diagnostic::{Diagnostic, Kind, Location, Result},
    pipeline::{
        self, Options, Outcome, Prepared, Watch,
        cache::Cache,
        compose::{Ended, Results, Row},
        judge::Level,
        resolve, staging,
    },
    status::Status,
};

/// Runs a pipeline: pairs the meshes, transfers every pose and writes the results.
///
/// Several targets and a matrix of settings make several runs, one after the other, with a table of results at the end; one
/// that fails does not stop the others.
/// Beside the first result a `run.json` records settings, inputs and figures. Inputs are never overwritten, and a run
/// that fails leaves what was there before.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  mimesh run horse-to-camel.yaml
  mimesh run horse-to-camel.yaml --set transfer.type=copy_displacement --out try
  mimesh run horse-to-camel.yaml --set 'output=[out/{pose}.ply]' --json
  mimesh run pipelines/herd.yaml --set variables.detail=30 --table herd.csv")]
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
    /// Write the table of results into this file too, as .csv or .md
    #[arg(long, value_name = "FILE")]
    table: Option<PathBuf>,
    /// Print the report (the contents of run.json, or of several runs a list) to stdout instead of the summary
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
    /// Write all results into this folder instead; those of several runs each into a folder of its name in it
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
    pub fn run(&self) -> super::Ended {
        // Without a handler an interrupt would leave files that are half written.
        let _ = ctrlc::set_handler(|| staging::discard_all_and_exit(Status::Interrupted as u8));
        let table = self.table.as_deref().map(Table::at).transpose()?;
        let all = pipeline::prepare_all(&self.pipeline, &self.overrides.options())?;
        if let Some(table) = &table {
            table.check(&all)?;
        }
        let cache = self.cache.open()?;
        let mut told = HashSet::new();
        let mut results = Results { pipeline: self.pipeline.clone(), rows: vec![] };
        let several = all.len() > 1;
        for (i, prepared) in all.iter().enumerate() {
            let started = Instant::now();
            let progress = Progress::new(self.quiet);
            if several {
                progress.stage(&format!("{} ({} of {})", prepared.variant.name, i + 1, all.len()));
            }
            // Before what they warn of may fail.
            self.warn(&prepared.warnings, &mut told);
            let outcome = self.one(prepared, cache.as_ref(), &progress);
            progress.finish();
            let ended = match outcome {
                // What is wrong with a single run is told as ever.
                Err(failure) if !several => return Err(failure),
                Err(failure) => {
                    let of_run = |diagnostic: Diagnostic| diagnostic.doing(&prepared.variant.name);
                    let diagnostics: Vec<_> = failure.diagnostics.into_iter().map(of_run).collect();
                    diagnostics.iter().for_each(terminal::tell_one);
                    Ended::Failed(diagnostics)
                }
                Ok(outcome) => {
                    outcome.failed.iter().for_each(terminal::tell_one);
                    // A gate that breaks is what an exit status of 3 is about, so that it is told where the summary is not.
                    if self.json || self.quiet {
                        let broken = summary::reasons(&outcome.report, Level::Failed);
                        broken.iter().for_each(|line| terminal::warn(line));
                    }
                    self.warn(&outcome.report.warnings, &mut told);
                    Ended::Report(Box::new(outcome.report))
                }
            };
            results.rows.push(Row {
                variant: prepared.variant.clone(),
                place: prepared.outputs.report.clone(),
                ended,
                seconds: started.elapsed().as_secs_f64() + prepared.reading.seconds,
            });
        }
        if let Some(table) = &table {
            table.write(&results)?;
        }
        self.tell(&results);
        Ok(status(&results))
    }

    /// Runs one of the runs that the pipeline declares.
    fn one(&self, prepared: &Prepared, cache: Option<&Cache>, progress: &Progress) -> Result<Outcome> {
        let threads = self.threads.map_or(0, usize::from);
        pipeline::run(prepared, &self.overrides.settings, threads, cache, progress)
    }

    /// Warnings that have not been told yet, where anything is told.
    fn warn(&self, warnings: &[String], told: &mut HashSet<String>) {
        if !self.json && !self.quiet {
            warnings
                .iter()
                .filter(|warning| told.insert((*warning).clone()))
                .for_each(|warning| terminal::warn(warning));
        }
    }

    fn tell(&self, results: &Results) {
        match &results.rows[..] {
            [Row { ended: Ended::Report(report), .. }] if self.json => {
                terminal::print_json(report);
            }
            [Row { ended: Ended::Report(report), place, .. }] if !self.quiet => {
                terminal::print(&summary::of(report, place));
            }
            _ if self.json => terminal::print_json(&results.json()),
            _ if !self.quiet => terminal::print(&summary::of_all(results)),
            _ => {}
        }
    }
}

/// How all runs ended together: with a broken gate if any has one and nothing failed; partly done if any of several gave results and not all did.
fn status(results: &Results) -> Status {
    let failed = results.rows.iter().filter_map(|row| match &row.ended {
        Ended::Failed(diagnostics) => Some(diagnostics),
        Ended::Report(_) => None,
    });
    match results.status() {
        "done" => Status::Done,
        "gate" => Status::Gate,
        "failed" => Kind::of_all(failed.flatten().map(|diagnostic| diagnostic.kind)).into(),
        _ => Status::Partly,
    }
}

/// The file that takes the table of results.
struct Table<'a> {
    file: &'a Path,
    text: fn(&Results) -> String,
}

impl<'a> Table<'a> {
    fn at(file: &'a Path) -> Result<Self> {
        let extension = file.extension().map(|extension| extension.to_string_lossy().to_lowercase());
        let text = match extension.as_deref() {
            Some("csv") => Results::csv,
            Some("md") => Results::markdown,
            _ => {
                let message = "a table is written as .csv or .md";
                let place = Location::Option(format!("--table {}", file.display()));
                return Err(Diagnostic::new(Kind::Usage, message).at(place).hint("e.g. `--table results.csv`").into());
            }
        };
        Ok(Self { file, text })
    }

    /// That it is no file that a run reads or writes.
    fn check(&self, all: &[Prepared]) -> Result<()> {
        let identity = resolve::identity(self.file);
        let is_it = |path: &Path| resolve::identity(path) == identity;
        let taken = all.iter().any(|one| {
            one.inputs.iter().any(|input| is_it(&input.path)) || one.outputs.places().into_iter().any(is_it)
        });
        if taken || self.file.is_dir() {
            let place = Location::Option(format!("--table {}", self.file.display()));
            let message = if taken { "a run reads or writes this file" } else { "there is a folder of that name" };
            return Err(Diagnostic::new(Kind::CannotWrite, message).at(place).hint("choose another name").into());
        }
        Ok(())
    }

    fn write(&self, results: &Results) -> Result<()> {
        staging::write(self.file, (self.text)(results).as_bytes())?;
        Ok(())
    }
}

/// A number of threads.
pub fn threads(text: &str) -> std::result::Result<u16, String> {
    text.parse()
        .ok()
        .filter(|count| *count > 0)
        .ok_or_else(|| format!("expected a whole number from 1 to {}", u16::MAX))
}
