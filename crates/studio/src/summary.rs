//! What came of a run, in a few sentences: those of the report.

use mimesh_pipeline::{
    Report,
    input::HelpCommands,
    metrics::{Level, faults},
    page::next_steps,
};
use serde::Serialize;

/// What came of a run.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// The whole in a few words, e.g. `good`, or `look at 3 things`.
    total: String,
    /// How many faults there are.
    things: usize,
    /// What each metric finds wrong, the worst first.
    faults: Vec<Fault>,
    /// What to do next, the most useful first.
    next_steps: Vec<String>,
}

#[derive(Clone, Debug, Serialize)]
struct Fault {
    metric: String,
    sentence: String,
}

impl Summary {
    /// The summary of `report`; `help` are the commands that it names.
    pub fn new(report: &Report, help: &HelpCommands) -> Self {
        let failed = report.poses.iter().filter(|pose| pose.error.is_some()).count();
        let of_metrics = faults(report.verdicts()).into_iter();
        let mut faults: Vec<Fault> =
            of_metrics.map(|(metric, sentence)| Fault { metric, sentence: sentence.into() }).collect();
        // What no metric has a sentence for says it by itself.
        for reason in report.verdicts().flat_map(|verdict| &verdict.reasons) {
            if faults.iter().all(|fault| fault.metric != reason.metric) {
                faults.push(Fault { metric: reason.metric.clone(), sentence: reason.words() });
            }
        }
        Self {
            total: total(report.verdict, faults.len(), failed),
            things: faults.len(),
            faults,
            next_steps: next_steps(report, help),
        }
    }
}

fn total(verdict: Option<Level>, things: usize, failed: usize) -> String {
    let count = |count: usize, one: &str, many: &str| format!("{count} {}", if count == 1 { one } else { many });
    let look = format!("look at {}", count(things, "thing", "things"));
    let level = match verdict {
        None => "not measured".into(),
        Some(Level::Good) => "good".into(),
        Some(Level::Doubtful) => format!("doubtful: {look}"),
        Some(Level::Bad) => look,
        Some(Level::Failed) => format!("a limit of yours is exceeded: {look}"),
    };
    if failed == 0 { level } else { format!("{} not transferred; {level}", count(failed, "pose was", "poses were")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_total_says_how_much_there_is_to_look_at() {
        assert_eq!(total(Some(Level::Good), 0, 0), "good");
        assert_eq!(total(Some(Level::Bad), 3, 0), "look at 3 things");
        assert_eq!(total(Some(Level::Doubtful), 1, 0), "doubtful: look at 1 thing");
        assert_eq!(total(Some(Level::Good), 0, 1), "1 pose was not transferred; good");
        assert_eq!(total(None, 0, 2), "2 poses were not transferred; not measured");
    }
}
