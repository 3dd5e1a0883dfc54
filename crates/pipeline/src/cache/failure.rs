//! Why a pose has no result, where it would have none anywhere and at any time.

use std::path::PathBuf;

use mimesh_document::{Diagnostic, Kind, Location};
use serde::{Deserialize, Serialize};

use super::codec::CacheCodec;
use crate::json::to_bytes;

/// Why a pose fails.
///
/// Only what depends on its key alone is stored: bad data fails on every machine, and memory may be enough on another.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct PoseFailure {
    message: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    hint: Option<String>,
    /// A file, and a line of it where that is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    place: Option<(PathBuf, Option<usize>)>,
}

impl PoseFailure {
    /// The part of `diagnostic` that is stored; `None` for a failure of this machine or this time.
    pub fn of(diagnostic: &Diagnostic) -> Option<Self> {
        if diagnostic.kind != Kind::BadData {
            return None;
        }
        let place = match &diagnostic.location {
            Some(Location::File(file)) => Some((file.clone(), None)),
            Some(Location::Line { file, line }) => Some((file.clone(), Some(*line))),
            _ => None,
        };
        Some(Self { message: diagnostic.message.clone(), hint: diagnostic.hint.clone(), place })
    }

    /// The diagnostic as it was.
    pub fn into_diagnostic(self) -> Diagnostic {
        let location = self.place.map(|(file, line)| match line {
            Some(line) => Location::Line { file, line },
            None => Location::File(file),
        });
        Diagnostic { location, hint: self.hint, ..Diagnostic::new(Kind::BadData, self.message) }
    }
}

impl CacheCodec for PoseFailure {
    fn encode(&self) -> Vec<u8> {
        to_bytes(self)
    }

    fn decode(bytes: &[u8]) -> Option<Self> {
        serde_json::from_slice(bytes).ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bad_data_comes_back_as_it_was_and_what_may_go_well_elsewhere_is_not_stored() {
        let plain = Diagnostic::new(Kind::BadData, "transfer: pose 3: no").hint("look at it");
        let line = plain.clone().at(Location::Line { file: "a.obj".into(), line: 7 });
        for diagnostic in [plain.clone(), line, plain.clone().at(Location::File("a.obj".into()))] {
            let stored = PoseFailure::of(&diagnostic).unwrap().encode();
            assert_eq!(PoseFailure::decode(&stored).unwrap().into_diagnostic(), diagnostic);
        }
        for kind in [Kind::Memory, Kind::CannotWrite, Kind::MissingInput, Kind::Internal] {
            assert_eq!(PoseFailure::of(&Diagnostic { kind, ..plain.clone() }), None);
        }
    }
}
