//! What a check of the whole pipeline finds.

use std::path::PathBuf;

use mimesh_document::{Document, diagnostic};
use mimesh_pipeline::{Prepared, choices::Choice};
use serde_json::{Value, json};

use crate::error::{ApiDiagnostic, PathStep};

/// What a check of the whole pipeline found.
#[derive(Clone, Debug, Default)]
pub struct Checked {
    /// What is wrong, and what looks wrong.
    pub diagnostics: Vec<ApiDiagnostic>,
    /// What is chosen where the text says nothing.
    pub choices: Value,
    /// The files that a run writes.
    pub outputs: Vec<PathBuf>,
}

impl Checked {
    /// The outcome of preparing the runs of `document`.
    pub fn of(prepared: &diagnostic::Result<Vec<Prepared>>, document: Option<&Document>) -> Self {
        let all = match prepared {
            Ok(all) => all,
            Err(failure) => {
                let mut list: Vec<_> = failure.list.iter().map(|one| ApiDiagnostic::of(one, document)).collect();
                // The markers are set beside the text.
                for (one, diagnostic) in list.iter_mut().zip(&failure.list) {
                    if matches!(&diagnostic.location, Some(mimesh_document::Location::Setting(_))) {
                        one.path = Some(vec![PathStep::Key("markers".into())]);
                    }
                }
                return Self { diagnostics: list, choices: json!([]), outputs: vec![] };
            }
        };
        let warnings =
            all.iter().flat_map(|one| one.warnings.iter().chain(&one.unfinished)).map(ApiDiagnostic::warning);
        let mut diagnostics: Vec<ApiDiagnostic> = warnings.collect();
        diagnostics.dedup();
        let choices = all.first().map(|one| one.choices.iter().map(choice).collect()).unwrap_or_default();
        let outputs = all.iter().flat_map(|one| one.outputs.files()).map(Into::into).collect();
        Self { diagnostics, choices: Value::Array(choices), outputs }
    }
}

fn choice(choice: &Choice) -> Value {
    json!({ "slot": choice.stage, "value": choice.chosen, "reason": choice.why })
}
