//! What failures of stages say beside what the stage says.

use mimesh_document::{Diagnostic, Diagnostics};

/// The failure with the stage that it came from.
pub(super) fn doing(failure: Diagnostics, stage: String) -> Diagnostics {
    let strip = |diagnostic: Diagnostic| {
        // Some errors name the stage themselves.
        let message = diagnostic.message.trim_start_matches("landmarks: ").to_owned();
        Diagnostic { message, ..diagnostic }.doing(stage.clone())
    };
    Diagnostics { list: failure.list.into_iter().map(strip).collect() }
}

/// The failure with one more way out of each diagnostic that has none like it.
pub(super) fn with_remedy(failure: Diagnostics, action: &'static str, words: &str) -> Diagnostics {
    let list = failure.list.into_iter().map(|diagnostic| match diagnostic.remedy {
        Some(_) => diagnostic,
        None => diagnostic.remedy(action, "", words),
    });
    Diagnostics { list: list.collect() }
}
