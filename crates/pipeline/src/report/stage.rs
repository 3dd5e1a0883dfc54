//! The report of a stage, and the clock that measures it.

use std::time::Instant;

use mimesh_core::Figures;
use serde::{Deserialize, Serialize};

use super::process;

/// A stage that ran once.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct StageReport {
    /// What was done, e.g. `correspondence`.
    pub stage: String,
    /// By which implementation; empty for what the pipeline does itself.
    #[serde(rename = "type", default, skip_serializing_if = "String::is_empty")]
    pub name: String,
    /// Time on the clock.
    pub seconds: f64,
    /// CPU time of all threads.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cpu_seconds: Option<f64>,
    /// Whether its result was cached by an earlier run.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub reused: bool,
    /// What it reports of its work.
    pub figures: Figures,
}

impl StageReport {
    /// The report of a stage whose result was cached.
    pub fn reused(self) -> Self {
        Self { reused: true, ..self }
    }

    /// The report without the time of `part`, a stage of its own that ran within this one.
    pub fn without(self, part: &Self) -> Self {
        let rest = |whole: f64, part: f64| (whole - part).max(0.0);
        let cpu_seconds = self.cpu_seconds.map(|whole| rest(whole, part.cpu_seconds.unwrap_or_default()));
        Self { seconds: rest(self.seconds, part.seconds), cpu_seconds, ..self }
    }
}

/// Measures a stage.
#[derive(Clone, Copy, Debug)]
pub struct Clock {
    begin: Instant,
    cpu_seconds: Option<f64>,
}

impl Clock {
    /// Begins to measure.
    pub fn start() -> Self {
        Self { begin: Instant::now(), cpu_seconds: process::usage().cpu_seconds }
    }

    /// What a stage took since the start.
    pub fn stop(self, stage: &'static str, name: &str, figures: Figures) -> StageReport {
        let cpu_seconds = process::usage().cpu_seconds.zip(self.cpu_seconds).map(|(now, then)| now - then);
        let seconds = self.seconds();
        StageReport { stage: stage.into(), name: name.into(), seconds, cpu_seconds, reused: false, figures }
    }
    /// Seconds since the start.
    pub fn seconds(&self) -> f64 {
        self.begin.elapsed().as_secs_f64()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_time_of_a_part_counts_once() {
        let report = |seconds, cpu_seconds| StageReport {
            stage: "reading".into(),
            name: String::new(),
            seconds,
            cpu_seconds,
            reused: false,
            figures: Figures::default(),
        };
        let rest = report(3.0, Some(5.0)).without(&report(1.0, Some(4.0)));
        assert_eq!((rest.seconds, rest.cpu_seconds), (2.0, Some(1.0)));
        // Clocks may disagree by a tick.
        let rest = report(1.0, None).without(&report(2.0, Some(1.0)));
        assert_eq!((rest.seconds, rest.cpu_seconds), (0.0, None));
    }
}
