//! The reports of runs that arguments stand for.

use std::path::{Path, PathBuf};

use mimesh_document::{
    diagnostic::{Diagnostic, Kind, Location, Result},
    files::{read_text, why_no_file},
};
use mimesh_pipeline::{Report, globs};

/// The hint for a report that is missing.
const WHERE_REPORTS_ARE: &str = "a run writes its report beside its first result, as `run.json`";

/// Finds the reports of all `patterns`, without repetitions.
///
/// # Errors
///
/// A diagnostic if a pattern has no report, or if there is only one report.
pub fn find_all(patterns: &[String]) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for pattern in patterns {
        for file in find(pattern)? {
            if !files.contains(&file) {
                files.push(file);
            }
        }
    }
    match &files[..] {
        [only] => {
            let message = format!("{} is the only report, expected at least two", only.display());
            let hint = "a run with a matrix or several targets has a report for each combination";
            Err(Diagnostic::new(Kind::Usage, message).hint(hint).into())
        }
        _ => Ok(files),
    }
}

/// Reads the report of a run.
///
/// # Errors
///
/// A diagnostic if the file cannot be read, or is not a report.
pub fn read(file: &Path) -> Result<Report> {
    let text = read_text(file)?;
    let report = serde_json::from_str(&text).map_err(|error| {
        Diagnostic::new(Kind::BadData, format!("not the report of a run: {error}"))
            .at(Location::File(file.into()))
            .hint("give a `run.json` of `mimesh run`; if an older version wrote it, run the pipeline again")
    })?;
    Ok(report)
}

/// Finds the reports of one pattern, at least one.
fn find(pattern: &str) -> Result<Vec<PathBuf>> {
    let mut matches = globs::expand(Path::new(""), pattern, &mut 0)
        .map_err(|refused| Diagnostic::new(Kind::Usage, refused.message).hint(refused.hint))?;
    if globs::is_glob(pattern) {
        // A glob may match folders, whose reports are added here.
        for report in ["run.json", "run-*.json"] {
            let inner = format!("{}/{report}", pattern.trim_end_matches('/'));
            matches.extend(globs::expand(Path::new(""), &inner, &mut 0).unwrap_or_default());
        }
    }
    let mut files: Vec<PathBuf> = Vec::new();
    for found in matches {
        if found.path.is_dir() {
            files.extend(in_folder(&found.path));
        } else {
            files.push(found.path);
        }
    }
    let message = match files.iter().find(|file| !file.is_file()) {
        Some(missing) => why_no_file(missing).map(|(message, _)| message).unwrap_or_default(),
        None if files.is_empty() => format!("no file matches `{pattern}`"),
        None => return Ok(files),
    };
    Err(Diagnostic::new(Kind::MissingInput, message).hint(WHERE_REPORTS_ARE).into())
}

/// The report in a folder, or all reports if several runs wrote there.
fn in_folder(folder: &Path) -> Vec<PathBuf> {
    let single = folder.join("run.json");
    let several = globs::expand(folder, "run-*.json", &mut 0).unwrap_or_default();
    if single.is_file() || several.is_empty() {
        return vec![single];
    }
    several.into_iter().map(|found| found.path).collect()
}
