//! Why a commit failed, and what it left.

use std::{io, path::Path};

use mimesh_core::Error;
use mimesh_document::{Diagnostic, Kind, Location};
use mimesh_markers::IntoDiagnostic;

use super::{
    journal::{Ending, Journal},
    moves::Moving,
};

/// Why files were not moved.
pub(super) struct Failure {
    pub diagnostic: Diagnostic,
    /// Whether everything is as it was.
    pub is_undone: bool,
}

impl Failure {
    /// A failure before anything was moved.
    pub fn whole(diagnostic: Diagnostic) -> Box<Self> {
        Box::new(Self { diagnostic, is_undone: true })
    }

    /// The failure `error` of moving to `place`, after all of `moving` was put back.
    pub fn after_undoing(place: &Path, error: &io::Error, moving: &[Moving], journal: &mut Journal) -> Box<Self> {
        let diagnostic = Error::write(place, io::Error::new(error.kind(), error.to_string())).into_diagnostic();
        let stuck: Vec<_> = moving
            .iter()
            .rev()
            .filter(|file| file.undo().is_err())
            .map(|file| file.place.display().to_string())
            .collect();
        if stuck.is_empty() {
            // Whoever finds the journal, if we are killed before it is removed, has nothing to do.
            let _ = journal.end(Ending::Undone);
            return Box::new(Self { diagnostic, is_undone: true });
        }
        let message = format!(
            "{}; these could not be put back, so that the results are of two runs: {}",
            diagnostic.message,
            stuck.join(", ")
        );
        let diagnostic =
            Diagnostic { message, ..diagnostic }.hint("run it again: the next run ends what this one has left");
        Box::new(Self { diagnostic, is_undone: false })
    }
}

/// What another program has taken away while the run was at work.
pub(super) fn gone(place: &Path, what: &str) -> Diagnostic {
    let message = format!("{what} by another program before it was in place, so all earlier results stay");
    let hint = "run it again, and leave files whose names begin with `.mimesh-` alone while it works";
    Diagnostic::new(Kind::CannotWrite, message).at(Location::File(place.into())).hint(hint)
}
