//! `mimesh compare`: runs beside each other, as a table and as a page.

mod names;
mod pictures;
mod report_files;
mod results;
mod written_files;

use std::path::PathBuf;

use mimesh_document::diagnostic::Result;
use mimesh_pipeline::{
    page::{self, ComparedRun},
    text::{number, seconds, table},
};
use serde_json::{Value, json};

use crate::cli::{
    CommandResult,
    out_file::{OutFile, write_all},
    roots::Roots,
    status::Status,
    terminal,
};
use written_files::WrittenFiles;

/// Compares runs: statistics, curves and pictures.
///
/// If all runs have the same target, `*` marks the best value of each line. The page shows pictures of results that are
/// unchanged since their run, with errors in colour where the truth is known.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  mimesh compare out/gradient/run.json out/biharmonic/run.json
  mimesh compare 'out/herd/*/run.json' --out herd.html
  mimesh compare try-1 try-2 --json")]
pub struct Compare {
    /// At least two reports of runs (run.json), folders that have one, or globs of them in quotes
    #[arg(required = true)]
    runs: Vec<String>,
    /// Write a page with curves and pictures into this file
    #[arg(long, value_name = "FILE.html")]
    out: Option<PathBuf>,
    /// Print the table as JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    roots: Roots,
}

impl Compare {
    /// Runs the command.
    pub fn run(&self) -> CommandResult {
        let out = self.out.as_deref().map(|file| OutFile { option: "--out", file });
        out.map_or(Ok(()), |out| out.check(&["html", "htm"]))?;
        let files = report_files::find_all(&self.runs)?;
        let reports = files.iter().map(|file| report_files::read(file)).collect::<Result<Vec<_>>>()?;
        let names = names::distinct(&files, &reports);
        let named = names.into_iter().zip(reports);
        let mut runs: Vec<_> = named.map(|(name, report)| ComparedRun { name, report, pictures: vec![] }).collect();
        if let Some(out) = out {
            for (run, file) in runs.iter().zip(&files) {
                let written = WrittenFiles::new(&run.report, file);
                out.check_is_none_of(written.paths().chain([&**file]), "one of the runs wrote this file")?;
            }
            for (run, file) in runs.iter_mut().zip(&files) {
                let (pictures, problems) = pictures::draw(&run.report, file, &self.roots);
                problems.iter().for_each(|problem| terminal::warn(&format!("{}: {problem}", run.name)));
                run.pictures = pictures;
            }
            let page = page::compare("Comparison of runs", &runs);
            write_all(&[(out.file, page.as_bytes())])?;
        }
        if self.json {
            terminal::print_json(&as_json(&files, &runs));
        } else {
            terminal::print(&as_text(&runs));
            if let Some(out) = out {
                terminal::print(&format!("\nwritten\n  {}\n", out.file.display()));
            }
        }
        Ok(Status::Done)
    }
}

/// A table with a column for each run.
fn as_text(runs: &[ComparedRun]) -> String {
    let verdict = |run: &ComparedRun| run.report.verdict.map_or("-", |level| level.word()).to_owned();
    let mut rows = vec![row("", runs.iter().map(|run| run.name.clone())), row("verdict", runs.iter().map(verdict))];
    for column in page::columns(runs) {
        let values: Vec<_> = runs.iter().map(|run| page::average(&run.report, &column)).collect();
        let best = page::best(runs, &values);
        let cell = |(i, value): (usize, &Option<f64>)| match value {
            Some(value) => format!("{}{}", if best == Some(i) { "*" } else { "" }, number(*value)),
            None => "-".into(),
        };
        let heading = format!("{} {}", column.metric, column.statistic);
        rows.push(row(&heading, values.iter().enumerate().map(cell)));
    }
    rows.push(row("seconds", runs.iter().map(|run| seconds(run.report.seconds))));
    table(&rows) + "  averages over poses\n"
}

/// A row of a table: its heading, then its cells.
fn row(heading: &str, cells: impl Iterator<Item = String>) -> Vec<String> {
    std::iter::once(heading.to_owned()).chain(cells).collect()
}

fn as_json(files: &[PathBuf], runs: &[ComparedRun]) -> Value {
    let run_json = |(file, run): (&PathBuf, &ComparedRun)| {
        json!({
            "name": run.name, "place": terminal::shown(file), "run": run.report.run, "status": run.report.status,
            "verdict": run.report.verdict, "markers": run.report.markers, "seconds": run.report.seconds,
            "metrics": run.report.metrics,
        })
    };
    json!({ "runs": files.iter().zip(runs).map(run_json).collect::<Vec<_>>() })
}
