//! What earlier runs, and others, have left where a run writes.

use std::{fs::File, io::BufReader, path::Path};

use mimesh_document::{Diagnostic, Kind, Location};
use mimesh_markers::OTHER_OUTPUT_FOLDER;
use serde::Deserialize;

use crate::{
    input::Prepared,
    staging::{Interrupted, survey},
};

/// Finds a file in the place of the report that is no report: nobody expects that a run takes its name.
pub(super) fn foreign_report(run: &Prepared) -> Option<Diagnostic> {
    let report = &run.outputs.report;
    if !report.is_file() || is_report(report) {
        return None;
    }
    let message = "cannot write the report: another program's file is there, or one that was cut";
    let diagnostic = Diagnostic::new(Kind::CannotWrite, message).at(Location::File(report.clone()));
    Some(diagnostic.remedy(OTHER_OUTPUT_FOLDER, "", "move it elsewhere, or write into another folder"))
}

/// Whether `file` is the report of a run.
fn is_report(file: &Path) -> bool {
    #[derive(Deserialize)]
    #[expect(dead_code, reason = "they must be there")]
    struct Head {
        mimesh: String,
        inputs: Vec<serde::de::IgnoredAny>,
        outputs: Vec<serde::de::IgnoredAny>,
    }
    File::open(file).is_ok_and(|file| serde_json::from_reader::<_, Head>(BufReader::new(file)).is_ok())
}

/// Notes what others have left where the run writes; diagnostics of what keeps it from writing there.
pub(super) fn look_around(run: &mut Prepared) -> Vec<Diagnostic> {
    let found = survey(run.outputs.files());
    run.unfinished = found.warnings;
    for (file, state) in found.interrupted {
        let file = file.display();
        run.unfinished.push(match state {
            Interrupted::Alive => format!("{file}: another process is writing this file now; `run` refuses until it has ended"),
            Interrupted::Writing => {
                format!("{file}: a run was stopped before its results were complete; the next run removes what it left")
            }
            Interrupted::Moving { moved, of } => format!(
                "{file}: a run was stopped when {moved} of its {of} results were in place, so the files are of two runs; \
                 the next run puts that right first"
            ),
            Interrupted::Ended => {
                format!("{file}: a run was stopped when its results were in order; the next run removes its temporary files")
            }
        });
    }
    found.refused
}
