//! What to do after a run, in plain words.

use std::collections::BTreeMap;

use maud::{Markup, html};
use mimesh_core::{plugin::instance, stage::Metric};

use super::words::prose;
use crate::{
    input::HelpCommands,
    metrics::{Level, Reason, key_in_words, limit_with_unit, unit, with_unit},
    report::{PoseReport, Report},
};

/// The name of the verdict on landmarks that a stage proposed.
const LANDMARKS: &str = "landmarks";

/// Returns what to do next as a list, the most useful first; `help` are the commands of the host.
pub fn next_steps_section(report: &Report, help: &HelpCommands) -> Markup {
    html! {
        section {
            h2 { "What to do next" }
            ol.next { @for step in next_steps(report, help) { li { (prose(&step)) } } }
        }
    }
}

/// Returns what to do next, the most useful first; at least one sentence. Names and commands stand in backticks.
pub fn next_steps(report: &Report, help: &HelpCommands) -> Vec<String> {
    let mut steps = Vec::new();
    steps.extend(of_failed_poses(report, help));
    steps.extend(of_map_and_markers(report, help));
    let has_shared = !steps.is_empty();
    steps.extend(of_poses(report, help, has_shared));
    steps.extend(of_gates(report));
    if steps.is_empty() {
        steps.push(where_nothing_is_wrong(report));
    }
    if !report.warnings.is_empty() {
        steps.push("Read the warnings further down: they name what was left out or looks wrong.".into());
    }
    steps
}

/// A command with what it does, as a sentence with a blank behind it; empty if the host has no such command.
fn sentence(command: &Option<String>, does: &str) -> String {
    command.as_ref().map(|command| format!("`{command}` {does}. ")).unwrap_or_default()
}

fn of_failed_poses(report: &Report, help: &HelpCommands) -> Option<String> {
    let failed = report.poses.iter().filter(|pose| pose.error.is_some()).count();
    let poses = if failed == 1 { "1 pose was".to_owned() } else { format!("{failed} poses were") };
    let check = sentence(&help.check_poses, "reads all poses and reports every mistake at once");
    (failed > 0).then(|| {
        format!(
            "{poses} not transferred, for the reasons in the table of poses. {check}Mend or leave out these files, and run \
             again."
        )
    })
}

/// What to do about faults that all poses share: they come first, since each pose follows them.
fn of_map_and_markers(report: &Report, help: &HelpCommands) -> Vec<String> {
    let verdict = report.rest_verdict.as_ref().filter(|verdict| verdict.level > Level::Good);
    let mut kinds = Vec::new();
    let mut steps = Vec::new();
    for reason in verdict.into_iter().flat_map(|verdict| &verdict.reasons) {
        let kind = SharedFault::of(reason);
        // Reasons of one kind ask for the same, and the first of them is the worst.
        if !kinds.contains(&kind) {
            kinds.push(kind);
            steps.push(kind.step(reason, help));
        }
    }
    steps
}

/// What a fault that all poses share asks for.
#[derive(Clone, Copy, PartialEq, Eq)]
enum SharedFault {
    /// Better landmarks than those that a stage proposed.
    Landmarks,
    /// Another marker, since the correspondence is wrong.
    Map,
    /// A look at the markers that are there.
    Markers,
}

impl SharedFault {
    fn of(reason: &Reason) -> Self {
        let needs_map = instance::<dyn Metric>(&reason.metric).is_some_and(|metric| metric.needs_map());
        match reason.metric.as_str() {
            LANDMARKS => Self::Landmarks,
            _ if needs_map => Self::Map,
            _ => Self::Markers,
        }
    }

    fn step(self, reason: &Reason, help: &HelpCommands) -> String {
        let place = place(reason);
        match self {
            Self::Landmarks => {
                let propose =
                    sentence(&help.propose_landmarks, "draws them on both meshes and writes them to a file of markers");
                format!(
                    "Correct the landmarks before anything else. {propose}Mend the wrong ones there, name the file as `clicks`, and \
                     run again."
                )
            }
            Self::Map => {
                let suggest = sentence(&help.suggest_marker, "names the point that helps most");
                format!(
                    "Mend the correspondence before you look at single poses, since all of them follow it. Add a marker{place}. \
                     {suggest}Then run again."
                )
            }
            Self::Markers => format!(
                "Look at the numbered markers{place} in the pictures “At rest”. Each number must lie on the same part of both \
                 meshes. Correct or remove those that do not, and run again."
            ),
        }
    }
}

/// Where a reason is, as ` around vertex 12` or ` at marker 28`; empty if it belongs to no place.
fn place(reason: &Reason) -> String {
    match &reason.about {
        Some(about) if about.starts_with("around") => format!(" {about}"),
        Some(about) => format!(" at {about}"),
        None => String::new(),
    }
}

/// The worst of the poses that are not good.
fn worst(report: &Report) -> Option<(&PoseReport, &Reason)> {
    let reasons = report.poses.iter().filter_map(|pose| Some((pose, pose.verdict.as_ref()?.reasons.first()?)));
    reasons.reduce(|worst, one| {
        let is_worse = one.1.level.cmp(&worst.1.level).then(one.1.excess().total_cmp(&worst.1.excess())).is_gt();
        if is_worse { one } else { worst }
    })
}

/// What to do about the poses themselves; `has_shared` if there is something else to be done first.
fn of_poses(report: &Report, help: &HelpCommands, has_shared: bool) -> Option<String> {
    let (pose, reason) = worst(report)?;
    let first = format!("pose `{}`, the worst by {}", pose.name, reason.title());
    if has_shared {
        return Some(format!("After that, look at {first}, again: faults of poses often go with those they share."));
    }
    let list = sentence(&help.list_transfers, "names the methods");
    let other = sentence(&help.run_other_transfer, "runs one of them");
    let compare = sentence(&help.compare, "shows both results beside each other");
    Some(format!(
        "Look at {first}: its colours show where. If that place looks right, keep the result. If not, add a marker there, or try \
         another `transfer`. {list}{other}{compare}"
    ))
}

/// What to do about broken gates: each once, with the poses that break it.
fn of_gates(report: &Report) -> Vec<String> {
    let mut broken: BTreeMap<(&str, &str), Vec<&Reason>> = BTreeMap::new();
    for reason in report.verdicts().flat_map(|verdict| &verdict.reasons).filter(|reason| reason.level == Level::Failed)
    {
        broken.entry((&reason.metric, &reason.statistic)).or_default().push(reason);
    }
    let step = |((metric, statistic), reasons): ((&str, &str), Vec<&Reason>)| {
        let unit = unit(metric, statistic);
        let limit = limit_with_unit(reasons[0].limit, unit);
        let most = reasons.iter().filter_map(|reason| reason.value).map(f64::abs).reduce(f64::max);
        let reached =
            most.map_or("could not be measured everywhere".into(), |most| format!("reaches {}", with_unit(most, unit)));
        let name = key_in_words(metric, statistic);
        format!(
            "The gate of {name} is {limit}, and the run {reached}. If the result is good enough to look at, set a larger limit \
             under `gates`."
        )
    };
    broken.into_iter().map(step).collect()
}

fn where_nothing_is_wrong(report: &Report) -> String {
    if report.verdict.is_none() {
        return "Nothing was measured. Name `metrics` in the pipeline, or leave the key out for the usual ones.".into();
    }
    if report.metrics.contains_key("point_error") {
        return "Nothing needs mending. The pictures show the largest errors first; the files are listed at the end."
            .into();
    }
    "No limit is exceeded. The known result is not given, so look through the pictures once: hands, feet, lips and the places \
     where parts touch. If all is well, the files are listed at the end."
        .into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_is_named_as_it_is_given() {
        let reason = |about: Option<&str>| Reason {
            level: Level::Bad,
            metric: "m".into(),
            statistic: "s".into(),
            about: about.map(Into::into),
            value: Some(1.0),
            limit: 0.5,
            note: None,
        };
        let all = [None, Some("around vertex 3"), Some("marker 28")].map(|about| place(&reason(about)));
        assert_eq!(all, ["", " around vertex 3", " at marker 28"]);
    }
}
