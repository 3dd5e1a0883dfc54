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
    /// Whether its result was kept from an earlier run.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub reused: bool,
    /// What it says of its work.
    pub figures: Figures,
}

impl StageReport {
    /// That of a stage whose result was kept.
    pub fn reused(self) -> Self {
        Self { reused: true, ..self }
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
        let seconds = self.begin.elapsed().as_secs_f64();
        StageReport { stage: stage.into(), name: name.into(), seconds, cpu_seconds, reused: false, figures }
    }
}
