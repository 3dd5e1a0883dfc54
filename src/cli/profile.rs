//! `--profile`: where the time of a command went, as a table and as a trace.

use std::path::{Path, PathBuf};

use mimesh_core::Error;
use mimesh_document::diagnostic::{Diagnostic, Kind, Location, Result};
use mimesh_pipeline::{
    Prepared,
    profile::{Profile, Row},
    staging::Transaction,
    text::{seconds, table, thousands},
};
use tracing::subscriber::set_global_default;
use tracing_subscriber::{Registry, layer::SubscriberExt};

use crate::cli::{out_file::OutFile, terminal};

/// The option.
const OPTION: &str = "--profile";

/// The name of a trace that the user does not name.
const NAME: &str = "profile.json";

/// A profile that is being recorded, and the file for its trace.
pub struct Profiler {
    profile: Profile,
    /// The file; it is beside the report if it is not named.
    file: Option<PathBuf>,
}

impl Profiler {
    /// Begins to record; the trace goes into `file`, or beside the report.
    ///
    /// # Errors
    ///
    /// A diagnostic if `file` cannot take a trace, or if the program around mimesh has a subscriber of its own.
    pub fn begin(file: Option<&Path>) -> Result<Self> {
        if let Some(file) = file {
            let out = OutFile { option: OPTION, file };
            out.check(&["json"])?;
            check_replaceable(out)?;
        }
        let (profile, recorder) = Profile::begin();
        set_global_default(Registry::default().with(recorder)).map_err(|_| {
            let diagnostic = Diagnostic::new(Kind::Usage, "this program has a subscriber for spans of its own");
            diagnostic
                .at(Location::Argument(OPTION.into()))
                .hint("leave it out, or give that subscriber the layer of `mimesh_pipeline::profile`")
        })?;
        Ok(Self { profile, file: file.map(Path::to_owned) })
    }

    /// Chooses the file for the runs `all`; the command writes `others` too.
    ///
    /// # Errors
    ///
    /// A diagnostic if the command reads or writes it otherwise, or if something else is there.
    pub fn choose_file<'p>(&mut self, all: &[Prepared], others: impl IntoIterator<Item = &'p Path>) -> Result<()> {
        let file = self.file.get_or_insert_with(|| beside(all));
        let out = OutFile { option: OPTION, file };
        let inputs = all.iter().flat_map(|run| &run.inputs).map(|input| &*input.path);
        let outputs = all.iter().flat_map(|run| run.outputs.files());
        out.check_is_none_of(inputs.chain(outputs), "a run reads or writes this file")?;
        out.check_is_none_of(others, "the command writes another result into this file")?;
        out.check_is_no_folder()?;
        check_replaceable(out)
    }

    /// Writes the trace, and gives the table.
    ///
    /// # Errors
    ///
    /// A diagnostic if the file cannot be written.
    pub fn finish(&self) -> Result<String> {
        let file = self.file.as_deref().unwrap_or(Path::new(NAME));
        let failed = |error| Error::write(file, error);
        let transaction = Transaction::begin([file])?;
        let staged = transaction.stage(file, |out| self.profile.write_trace(out).map_err(failed))?;
        transaction.warnings().iter().for_each(|warning| terminal::warn(warning));
        transaction.commit(vec![staged])?;
        Ok(text_of(&self.profile.rows(), file))
    }
}

/// The file beside the reports of all runs: `profile.json` for `run.json`.
fn beside(all: &[Prepared]) -> PathBuf {
    let mut reports = all.iter().map(|run| &*run.outputs.report);
    let Some(first) = reports.next() else { return NAME.into() };
    let name = match (first.file_name().map(|name| name.to_string_lossy()), all.len()) {
        (Some(name), 1) => name.strip_suffix("run.json").map(|stem| format!("{stem}profile.json")),
        _ => None,
    };
    let folder = |report: &'_ Path| report.parent().unwrap_or(Path::new("")).to_owned();
    let common = reports.fold(folder(first), |common, report| {
        common.components().zip(folder(report).components()).take_while(|(a, b)| a == b).map(|(a, _)| a).collect()
    });
    common.join(name.unwrap_or_else(|| NAME.into()))
}

/// Checks that nothing is lost by writing the file: it is not there, or is a trace of an earlier run.
fn check_replaceable(out: OutFile<'_>) -> Result<()> {
    if !out.file.exists() || Profile::is_trace(out.file) {
        return Ok(());
    }
    let diagnostic = out.diagnostic(Kind::CannotWrite, "is there already, and is no trace of mimesh");
    Err(diagnostic.hint("only traces of earlier runs are replaced; choose another name").into())
}

/// The table, and where the trace is.
fn text_of(rows: &[Row], file: &Path) -> String {
    let heading = ["", "calls", "wall", "CPU", "waiting"].map(str::to_owned).to_vec();
    let row = |row: &Row| {
        let waiting = if row.depth == 0 { String::new() } else { seconds(row.waiting.as_secs_f64()) };
        let times = [row.wall, row.cpu].map(|time| seconds(time.as_secs_f64()));
        let [wall, cpu] = times;
        vec![format!("{}{}", "  ".repeat(row.depth), row.label), thousands(row.count as usize), wall, cpu, waiting]
    };
    let cells: Vec<_> = std::iter::once(heading).chain(rows.iter().map(row)).collect();
    format!(
        "\nprofile (times of threads side by side are added up)\n{}  trace: {} (open it at ui.perfetto.dev)\n",
        table(&cells),
        file.display()
    )
}
