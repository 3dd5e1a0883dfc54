//! What a search reports.

use std::collections::BTreeMap;

use mimesh_core::{Error, Figures};

use crate::{
    candidates::{HandleRules, MIN_POINTS},
    judge::Failure,
    search::{Added, Ending, Exchanged, Limits, Search},
};

/// Most candidates that could not be judged that are named one by one.
const MAX_NAMED: usize = 3;

/// Reports the figures of a search, and why it ended where it should not.
pub fn report(
    figures: &mut Figures,
    search: &Search<'_>,
    rules: &HandleRules,
    limits: Limits,
    done: (&Added, &Exchanged),
) {
    let (added, exchanged) = done;
    figures.set("error", search.error);
    figures.set("ended_by", name(added.ending));
    figures.set("points_tried", added.tried);
    figures.set("rounds_of_exchanges", exchanged.rounds);
    figures.set("judged", search.judge.judged);
    figures.set("ranked", search.judge.ranked);
    if let Some(warning) = ending(search, limits, added) {
        figures.warn(warning);
    }
    if exchanged.is_cut_short {
        let rounds = exchanged.rounds;
        figures.warn(format!(
            "exchanges ended with round {rounds}, which still lowered the error; allow more with `max_rounds`"
        ));
    }
    if search.chosen.len() < MIN_POINTS && added.ending != Ending::Interrupted {
        figures.warn(format!(
            "{} key points are fewer than the {MIN_POINTS} that transfers need; give more candidates",
            search.chosen.len()
        ));
    }
    failures(figures, "judged", &search.judge.not_judged, rules);
    failures(figures, "ranked", &search.judge.not_ranked, rules);
}

fn name(ending: Ending) -> &'static str {
    match ending {
        Ending::Threshold => "threshold",
        Ending::MaxCount => "max_count",
        Ending::Candidates => "candidates",
        Ending::NotJudged => "not_judged",
        Ending::Interrupted => "interrupted",
    }
}

/// Why the error is above the threshold, and the way out.
fn ending(search: &Search<'_>, limits: Limits, added: &Added) -> Option<String> {
    let (count, tried) = (search.chosen.len(), added.tried);
    if search.error <= limits.threshold {
        return None;
    }
    let reason = match added.ending {
        // An exchange never raises the error; what is above a threshold of 0 is rounding.
        Ending::Threshold | Ending::Interrupted => return None,
        Ending::NotJudged => "no other candidate can be judged".into(),
        _ if count < tried => {
            format!("up to {tried} were tried, and more did not help; other candidates may, set `sampler`")
        }
        Ending::MaxCount => "allow more with `max_count`".into(),
        Ending::Candidates => format!("these are all {tried} candidates; give more with `sampler`"),
    };
    Some(format!(
        "{count} key points leave an error of {:.4}, above the threshold of {}; {reason}",
        search.error, limits.threshold
    ))
}

/// Warns of candidates whose sets could not be judged or ranked, the first by name.
fn failures(figures: &mut Figures, verb: &str, failures: &BTreeMap<usize, Failure>, rules: &HandleRules) {
    for (&candidate, Failure { sets, error }) in failures.iter().take(MAX_NAMED) {
        let hint = match error {
            Error::Data { hint, .. } => format!("; {hint}"),
            _ => String::new(),
        };
        let name = rules.name(candidate);
        figures.warn(format!("{name} could not be {verb} in {sets} of the sets tried, the first time: {error}{hint}"));
    }
    if failures.len() > MAX_NAMED {
        figures.warn(format!("{} more candidates could not be {verb} in some sets", failures.len() - MAX_NAMED));
    }
}
