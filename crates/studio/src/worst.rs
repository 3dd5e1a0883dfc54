//! Statistics above their limits, worst first, with where to look.

use std::{cmp::Ordering, collections::HashMap};

use mimesh_pipeline::{
    Prepared,
    metrics::{Level, PoseMeasurements, Reason},
};
use serde::Serialize;

use crate::project::Project;

/// The most entries of a list.
const MAX_ENTRIES: usize = 200;

/// The most entries of one statistic, so that it leaves room for others.
const MAX_OF_STATISTIC: usize = 20;

/// A statistic above its limit.
#[derive(Clone, Debug, Serialize)]
pub struct Worst {
    pose: Option<usize>,
    pose_name: Option<String>,
    metric: String,
    title: String,
    value: Option<f64>,
    unit: String,
    limit: f64,
    level: Level,
    about: Option<String>,
    vertex: Option<usize>,
    /// The whole reason in words, as reports have it.
    words: String,
    /// What the metric finds wrong, and what helps.
    fault: &'static str,
    /// What the statistic is, exactly.
    meaning: String,
}

impl Worst {
    /// The statistic that `reason` is about, of the pose at a place among those of `prepared`, which `project` counts in its own way;
    /// `measured` are the measurements of the pose, if they are at hand.
    pub fn new(
        place: Option<usize>,
        reason: &Reason,
        project: &Project,
        prepared: &Prepared,
        measured: Option<&PoseMeasurements>,
    ) -> Self {
        let named = place.and_then(|place| prepared.poses.get(place));
        let metric = prepared.metrics.iter().find(|metric| metric.typetag_name() == reason.metric);
        let statistics = metric.map(|metric| metric.statistics()).unwrap_or_default();
        let statistic = statistics.iter().find(|statistic| statistic.name == reason.statistic);
        Self {
            pose: place.and_then(|place| project.index_of(prepared, place)),
            pose_name: named.map(|pose| pose.name.clone()),
            metric: reason.metric.clone(),
            title: reason.title(),
            value: reason.value,
            unit: statistic.map_or("", |statistic| statistic.unit).into(),
            limit: reason.limit,
            level: reason.level,
            about: reason.about.clone().or_else(|| reason.note.clone()),
            vertex: named_vertex(reason).or_else(|| worst_vertex(measured?, &reason.metric)),
            words: reason.words(),
            fault: metric.map_or("", |metric| metric.fault()),
            meaning: statistic
                .map(|one| format!("`{}` of `{}`: {}", one.name, reason.metric, one.meaning))
                .unwrap_or_default(),
        }
    }

    /// The list with the worst first, no longer than a page shows, and with no statistic in place of all others.
    pub fn sorted(mut list: Vec<Self>) -> Vec<Self> {
        list.sort_by(|a, b| (b.level, b.ratio()).partial_cmp(&(a.level, a.ratio())).unwrap_or(Ordering::Equal));
        let mut counts: HashMap<String, usize> = HashMap::new();
        list.retain(|one| {
            let count = counts.entry(one.title.clone()).or_default();
            *count += 1;
            *count <= MAX_OF_STATISTIC
        });
        list.truncate(MAX_ENTRIES);
        list
    }

    /// The same about the marker that a page numbers otherwise than the file, whose numbers are its places.
    pub fn renumbered(mut self, number_at: impl Fn(usize) -> Option<usize>) -> Self {
        let place = self.about.as_ref().and_then(|about| about.strip_prefix("marker ")?.parse::<usize>().ok());
        if let Some(number) = place.and_then(|place| number_at(place.checked_sub(1)?)) {
            let about = format!("marker {number}");
            self.words = self.words.replace(self.about.as_deref().unwrap_or_default(), &about);
            self.about = Some(about);
        }
        self
    }

    /// How many times its limit the value is.
    fn ratio(&self) -> f64 {
        self.value.map_or(f64::INFINITY, |value| value.abs() / self.limit.abs().max(1e-12))
    }
}

/// The vertex of the target's file that a reason names, as `around vertex 12`.
fn named_vertex(reason: &Reason) -> Option<usize> {
    reason.about.as_ref()?.strip_prefix("around vertex ")?.parse().ok()
}

/// The vertex of the target's file at which a metric shows the largest number.
fn worst_vertex(measured: &PoseMeasurements, metric: &str) -> Option<usize> {
    let (_, measured) = measured.measured.iter().find(|(name, _)| name == metric)?;
    let known = measured.field.iter().enumerate().filter(|(_, value)| value.is_finite());
    known.max_by(|a, b| a.1.total_cmp(b.1)).map(|(vertex, _)| vertex)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn worst(title: &str, value: f64) -> Worst {
        Worst {
            pose: None,
            pose_name: None,
            metric: "m".into(),
            title: title.into(),
            value: Some(value),
            unit: String::new(),
            limit: 1.0,
            level: Level::Bad,
            about: Some("marker 2".into()),
            vertex: None,
            words: "m at marker 2, above 1".into(),
            fault: "",
            meaning: String::new(),
        }
    }

    #[test]
    fn one_statistic_does_not_fill_the_list() {
        let many = (0..500).map(|i| worst("stretch", 100.0 + f64::from(i)));
        let list = Worst::sorted(many.chain([worst("gap", 2.0)]).collect());
        assert_eq!(list.iter().filter(|one| one.title == "stretch").count(), MAX_OF_STATISTIC);
        assert_eq!((list[0].value, list.last().map(|one| one.title.as_str())), (Some(599.0), Some("gap")));
    }

    #[test]
    fn a_marker_has_the_number_of_its_label() {
        let one = worst("a", 1.0).renumbered(|place| (place == 1).then_some(7));
        assert_eq!((one.about.as_deref(), one.words.as_str()), (Some("marker 7"), "m at marker 7, above 1"));
        assert_eq!(worst("a", 1.0).renumbered(|_| None).about.as_deref(), Some("marker 2"));
    }
}
