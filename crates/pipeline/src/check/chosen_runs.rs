//! Some of the runs that a file declares, by their names.

use std::path::PathBuf;

use mimesh_document::{Diagnostic, Kind, suggest::did_you_mean};

use super::{common::Options, outputs::report_place};
use crate::compose::Run;

/// The most names that a diagnostic lists.
const MAX_NAMES: usize = 20;

/// The runs that are wanted, and where the others write their reports: names of reports do not depend on which runs are wanted.
#[derive(Debug, Default)]
pub(super) struct ChosenRuns {
    /// The runs in the order of the file.
    pub runs: Vec<Run>,
    /// The reports of the other runs.
    pub other_reports: Vec<PathBuf>,
}

/// Those of `runs` that `options` name; all if none are named.
///
/// # Errors
///
/// [`Kind::Usage`] about each name that no run has.
pub(super) fn choose_runs(runs: Vec<Run>, options: &Options) -> Result<ChosenRuns, Vec<Diagnostic>> {
    if options.runs.is_empty() {
        return Ok(ChosenRuns { runs, ..ChosenRuns::default() });
    }
    let names: Vec<&str> = runs.iter().map(|run| run.variant.name.as_str()).collect();
    let unknown: Vec<_> = options.runs.iter().filter(|name| !names.contains(&name.as_str())).collect();
    if !unknown.is_empty() {
        return Err(unknown.into_iter().map(|name| unknown_run(name, &names)).collect());
    }
    let several = runs.len() > 1;
    let mut chosen = ChosenRuns::default();
    for run in runs {
        if options.runs.contains(&run.variant.name) {
            chosen.runs.push(run);
        } else {
            chosen.other_reports.extend(report_place(&run, options, several));
        }
    }
    Ok(chosen)
}

fn unknown_run(name: &str, names: &[&str]) -> Diagnostic {
    if let [""] = names {
        let message = format!("there is no run `{name}`: the pipeline declares one, without a name");
        return Diagnostic::new(Kind::Usage, message).hint("name no run");
    }
    let shown: Vec<String> = names.iter().take(MAX_NAMES).map(|name| format!("`{name}`")).collect();
    let more = names.len().saturating_sub(MAX_NAMES);
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    let message = format!("there is no run `{name}`, but {}{more}", shown.join(", "));
    Diagnostic::new(Kind::Usage, message).hint(did_you_mean(name, names).unwrap_or_default())
}
