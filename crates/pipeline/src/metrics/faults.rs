//! What verdicts find wrong, in plain words.

use mimesh_core::{plugin::instance, stage::Metric};

use super::verdict::{Reason, Verdict};

/// What the metrics in the reasons of `verdicts` find wrong, in plain words, each once by its name; the worst first.
pub fn faults<'a>(verdicts: impl IntoIterator<Item = &'a Verdict>) -> Vec<(String, &'static str)> {
    let mut reasons: Vec<&Reason> = verdicts.into_iter().flat_map(|verdict| &verdict.reasons).collect();
    reasons.sort_by_key(|reason| std::cmp::Reverse(reason.level));
    let mut found: Vec<(String, &'static str)> = Vec::new();
    for Reason { metric, .. } in reasons {
        let is_new = found.iter().all(|(name, _)| name != metric);
        if let Some(stage) = instance::<dyn Metric>(metric).filter(|stage| is_new && !stage.fault().is_empty()) {
            found.push((metric.clone(), stage.fault()));
        }
    }
    found
}
