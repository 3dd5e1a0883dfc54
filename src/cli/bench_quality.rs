use std::path::{Path, PathBuf};

use serde_json::json;

use super::{Ended, progress::Progress, terminal};
use crate::{
    bench::{self, Entry, METHODS, Method},
    diagnostic::{Diagnostic, Kind, Location},
    pipeline::{Watch, staging, words::did_you_mean},
    status::Status,
    text::table,
};

/// Measures the methods of transfer where the result is known: on built-in samples, or on folders of meshes of your own.
///
/// Errors are in percent of the target's diagonal after aligning centroids. A folder has `source/rest.obj` and a mesh for each
/// pose, `source/POSE.obj`, and for each target `TARGET/rest.obj`, `TARGET/truth-POSE.ply` and `TARGET/landmarks.json`
/// (`{ "source": [vertices], "target": [vertices] }`, farthest points first, so that any number from the front is spread).
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  mimesh bench-quality
  mimesh bench-quality bodies --markers 10,20,64 --out bench --table bench.md
  mimesh bench-quality --methods gradient,multi_component --json")]
pub struct BenchQuality {
    /// Folders of meshes [default: built-in samples]
    folders: Vec<PathBuf>,
    /// Numbers of landmarks to use of each folder; samples use all of theirs
    #[arg(long, value_name = "N,…", value_delimiter = ',', default_value = "20", value_parser = marker_count)]
    markers: Vec<usize>,
    /// Methods to measure [default: all]
    #[arg(long, value_name = "NAME,…", value_delimiter = ',')]
    methods: Vec<String>,
    /// Keep pipelines, results and reports of all runs in this folder
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Write the table into this file too, as .csv or .md
    #[arg(long, value_name = "FILE")]
    table: Option<PathBuf>,
    /// Print the table as JSON
    #[arg(long)]
    json: bool,
    /// Threads to use; results do not depend on their number [default: all]
    #[arg(long, value_name = "N", value_parser = super::run::threads)]
    threads: Option<u16>,
}

impl BenchQuality {
    /// Runs the command.
    pub fn run(&self) -> Ended {
        let _ = ctrlc::set_handler(|| staging::discard_all_and_exit(Status::Interrupted as u8));
        let methods = self.methods()?;
        let write = self.table.as_deref().map(table_kind).transpose()?;
        if let Some(table) = self.table.as_deref().filter(|table| table.is_dir()) {
            let place = Location::Option(format!("--table {}", table.display()));
            return Err(Diagnostic::new(Kind::CannotWrite, "there is a folder of that name").at(place).into());
        }
        let mut cases = if self.folders.is_empty() { bench::samples() } else { vec![] };
        for folder in &self.folders {
            let mut markers = self.markers.clone();
            markers.sort_unstable();
            markers.dedup();
            let (of_folder, passed) = bench::folder(folder, &markers)?;
            passed.iter().for_each(|why| terminal::warn(&format!("passed over: {why}")));
            for case in of_folder {
                if cases.iter().any(|other: &bench::Case| other.name == case.name) {
                    let message = format!("{}: there is a target of that name in another folder", case.name);
                    return Err(Diagnostic::new(Kind::Usage, message).hint("measure the folders one by one").into());
                }
                cases.push(case);
            }
        }
        if !cases.iter().any(|case| methods.iter().any(|method| method.takes(case.components))) {
            let message = "no method named takes any of the targets";
            let hint = "gradient takes targets of one component, multi_component and combined those of several";
            return Err(Diagnostic::new(Kind::Usage, message).hint(hint).into());
        }
        let temporary = if self.out.is_none() { Some(tempfile::tempdir().map_err(cannot_make)?) } else { None };
        let folder = self.out.as_deref().or(temporary.as_ref().map(tempfile::TempDir::path)).unwrap_or(Path::new("."));
        let mut entries: Vec<Entry> = Vec::new();
        for case in &cases {
            for method in methods.iter().filter(|method| method.takes(case.components)) {
                let progress = Progress::new(false);
                progress.stage(&format!("{}: {}", case.name, method.name));
                let threads = self.threads.map_or(0, usize::from);
                let entry = bench::run(case, method, folder, threads, &crate::pipeline::Unwatched)?;
                progress.finish();
                if let Err(diagnostics) = &entry.ended {
                    diagnostics.iter().for_each(terminal::tell_one);
                }
                entry.failed.iter().for_each(terminal::tell_one);
                entries.push(entry);
            }
        }
        if self.json {
            terminal::print_json(&entries.iter().map(as_json).collect::<Vec<_>>());
        } else {
            terminal::print(&format!("errors in percent of the diagonal\n{}", table(&bench::rows(&entries))));
            if let Some(out) = &self.out {
                terminal::print(&format!("pipelines, results and reports are in {}\n", out.display()));
            }
        }
        if let (Some(path), Some(text)) = (&self.table, write) {
            staging::write(path, text(&entries).as_bytes())?;
        }
        let whole = entries.iter().all(|entry| entry.ended.is_ok() && entry.failed.is_empty());
        let none = entries.iter().all(|entry| entry.ended.is_err());
        let diagnostics = entries.iter().filter_map(|entry| entry.ended.as_ref().err()).flatten();
        Ok(match (whole, none) {
            (true, _) => Status::Done,
            (false, true) => Kind::of_all(diagnostics.map(|diagnostic| diagnostic.kind)).into(),
            (false, false) => Status::Partly,
        })
    }

    fn methods(&self) -> crate::diagnostic::Result<Vec<Method>> {
        if self.methods.is_empty() {
            return Ok(METHODS.to_vec());
        }
        let known: Vec<&str> = METHODS.iter().map(|method| method.name).collect();
        let find = |name: &String| -> crate::diagnostic::Result<Method> {
            METHODS.iter().find(|method| method.name == name).copied().ok_or_else(|| {
                let hint = did_you_mean(name, &known).unwrap_or_else(|| format!("known methods: {}", known.join(", ")));
                Diagnostic::new(Kind::Usage, format!("--methods: unknown method `{name}`")).hint(hint).into()
            })
        };
        let mut methods: Vec<Method> = Vec::new();
        for name in &self.methods {
            let method = find(name)?;
            if !methods.iter().any(|other| other.name == method.name) {
                methods.push(method);
            }
        }
        Ok(methods)
    }
}

/// A number of markers that says anything of how two meshes lie to each other.
fn marker_count(text: &str) -> std::result::Result<usize, String> {
    text.parse().ok().filter(|count| *count >= 3).ok_or_else(|| "expected a whole number, 3 or more".into())
}

/// How the table is written into `path`.
fn table_kind(path: &Path) -> crate::diagnostic::Result<fn(&[Entry]) -> String> {
    let extension = path.extension().map(|extension| extension.to_string_lossy().to_lowercase());
    match extension.as_deref() {
        Some("csv") => Ok(bench::csv),
        Some("md") => Ok(bench::markdown),
        _ => {
            let place = Location::Option(format!("--table {}", path.display()));
            Err(Diagnostic::new(Kind::Usage, "a table is written as .csv or .md").at(place).into())
        }
    }
}

fn cannot_make(error: std::io::Error) -> Diagnostic {
    Diagnostic::new(Kind::CannotWrite, format!("no temporary folder can be made: {error}"))
        .hint("name a folder with `--out`")
}

fn as_json(entry: &Entry) -> serde_json::Value {
    let (report, diagnostics) = match &entry.ended {
        Ok(report) => (Some(report), vec![]),
        Err(diagnostics) => (None, diagnostics.iter().map(Diagnostic::to_json).collect()),
    };
    json!({
        "case": entry.case, "method": entry.method, "clicks": report.map(|report| report.markers),
        "metrics": report.map(|report| &report.metrics), "verdict": report.and_then(|report| report.verdict),
        "seconds": report.map(|report| report.seconds), "mistakes": diagnostics,
    })
}
