//! Verdicts on poses, as reports keep them.

use serde::{Deserialize, Serialize};

use super::declared::{key_in_words, limit_with_unit, title, unit, with_unit};

/// The unit of statistics that only say whether something is so.
const YES_OR_NO: &str = "0 or 1";

/// How bad a statistic or a pose is, from the best to the worst.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Level {
    /// No limit is exceeded.
    #[default]
    Good,
    /// A person should look.
    Doubtful,
    /// Something is wrong.
    Bad,
    /// A gate of the pipeline is exceeded.
    #[serde(rename = "broken_gate")]
    Failed,
}

/// The verdict on a pose.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
pub struct Verdict {
    /// The worst level of its reasons.
    pub level: Level,
    /// The statistics above their limits, worst first.
    #[serde(default)]
    pub reasons: Vec<Reason>,
}

/// A statistic above its limit.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Reason {
    /// How bad that is.
    pub level: Level,
    /// The type of the metric.
    pub metric: String,
    /// The statistic.
    #[serde(rename = "figure")]
    pub statistic: String,
    /// The thing that the value belongs to, if it is one among many, e.g. `marker 28`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub about: Option<String>,
    /// The value; `None` if it could not be measured, which breaks a gate too.
    pub value: Option<f64>,
    /// The largest size that passes; of a confidence the smallest.
    pub limit: f64,
    /// The reason for people, where it is another than that a statistic is above its limit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub note: Option<String>,
}

impl Verdict {
    /// The verdict with one more reason, behind those that are as bad.
    pub fn with(mut self, reason: Reason) -> Self {
        self.level = self.level.max(reason.level);
        let place = self.reasons.partition_point(|other| other.level >= reason.level);
        self.reasons.insert(place, reason);
        self
    }
}

impl Reason {
    /// The reason of a pose whose known result could not be read: nobody knows how good it is.
    pub fn unscored() -> Self {
        Self {
            level: Level::Doubtful,
            metric: "truth".into(),
            statistic: "read".into(),
            about: None,
            value: None,
            limit: 0.0,
            note: Some("the pose is not scored, since its known result cannot be read".into()),
        }
    }
}

impl Level {
    /// The level for people, in a word or two.
    pub fn word(self) -> &'static str {
        match self {
            Self::Good => "good",
            Self::Doubtful => "doubtful",
            Self::Bad => "bad",
            Self::Failed => "broken gate",
        }
    }
}

impl Reason {
    /// The reason for people: `stretch beyond the source's 185 %, above 120 %`. A gate has the name that the pipeline gives it.
    pub fn words(&self) -> String {
        self.in_words("")
    }

    /// The same for the worst of several poses: `stretch beyond the source's up to 185 %, above 120 %`.
    pub fn words_of_worst(&self) -> String {
        self.in_words("up to ")
    }

    fn in_words(&self, how: &str) -> String {
        if let Some(note) = &self.note {
            return note.clone();
        }
        let statistic = self.title();
        let Some(value) = self.value else { return format!("{statistic} could not be measured") };
        let at =
            |about: &String| if about.starts_with("around") { format!(" {about}") } else { format!(" at {about}") };
        let about = self.about.as_ref().map(at).unwrap_or_default();
        let unit = unit(&self.metric, &self.statistic);
        if unit == YES_OR_NO && self.level != Level::Failed {
            return format!("{statistic}{about}");
        }
        format!("{statistic} {how}{}{about}, above {}", with_unit(value, unit), limit_with_unit(self.limit, unit))
    }

    /// What people call the statistic; a gate has the name that the pipeline gives it.
    pub fn title(&self) -> String {
        match self.level {
            Level::Failed => key_in_words(&self.metric, &self.statistic),
            _ => title(&self.metric, &self.statistic),
        }
    }

    /// The size of the value over its limit: at least 1, and infinite if the limit is 0 or there is no value.
    pub fn excess(&self) -> f64 {
        match self.value {
            Some(value) if self.limit > 0.0 => value.abs() / self.limit,
            _ => f64::INFINITY,
        }
    }
}
