//! What a run did: the contents of `run.json`, from which the summary is made.

use std::{path::PathBuf, time::Instant};

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use super::{
    check::Side,
    compose::Variant,
    judge::{Level, Reason, Verdict},
    process::{self, Usage},
    staging::WrittenFile,
};
use crate::core::{Figures, mesh::Topology, plugin, stage::Metric};

/// A run, whole.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Report {
    /// The program's version.
    pub mimesh: String,
    /// `done`, or `partly` if some poses failed.
    pub status: String,
    /// The pipeline's file.
    pub pipeline: PathBuf,
    /// Which of its runs this was, if it declares several.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub run: Option<RunOf>,
    /// Its settings in full, with defaults and with what the command line set.
    pub settings: Value,
    /// What the command line set.
    pub set: Vec<String>,
    /// Threads used.
    pub threads: usize,
    /// Every file read.
    pub inputs: Vec<InputFile>,
    /// The mesh that gave its motion.
    pub source: MeshFigures,
    /// The mesh that took it.
    pub target: MeshFigures,
    /// Number of markers.
    pub markers: usize,
    /// The worst verdict of any pose; none where nothing was measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub verdict: Option<Level>,
    /// The gates of the pipeline.
    #[serde(default, skip_serializing_if = "Map::is_empty")]
    pub gates: Map<String, Value>,
    /// The stages in their order.
    pub stages: Vec<StageReport>,
    /// The poses in their order.
    pub poses: Vec<PoseReport>,
    /// For each metric its figures over all poses.
    #[serde(default, skip_serializing_if = "Map::is_empty")]
    pub metrics: Map<String, Value>,
    /// Every file written, without this one.
    pub outputs: Vec<WrittenFile>,
    /// Sentences about what looks wrong or was left out.
    pub warnings: Vec<String>,
    /// Seconds from start to end.
    pub seconds: f64,
    /// What the process used, from its own start.
    pub process: Usage,
}

/// One of the runs that a pipeline declares.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub struct RunOf {
    /// Its name, which `{name}` stands for.
    pub name: String,
    /// The target's name.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub target: Option<String>,
    /// The keys that the matrix varies, with their values.
    #[serde(default, skip_serializing_if = "Map::is_empty")]
    pub matrix: Map<String, Value>,
}

impl RunOf {
    /// Of `variant`; `None` for the only run of a file.
    pub fn new(variant: &Variant) -> Option<Self> {
        let several = variant.target.is_some() || !variant.values.is_empty();
        let Variant { name, target, values, .. } = variant;
        several.then(|| Self { name: name.clone(), target: target.clone(), matrix: values.iter().cloned().collect() })
    }
}

/// A file that was read.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub struct InputFile {
    /// What it is.
    pub role: String,
    /// The file.
    pub path: PathBuf,
    /// Its size.
    pub bytes: u64,
    /// The hash of its contents.
    pub blake3: String,
}

/// Counts and size of a mesh.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct MeshFigures {
    /// Vertices of the file.
    pub vertices: usize,
    /// Polygons of the file.
    pub polygons: usize,
    /// Vertices after welding seams.
    pub welded_vertices: usize,
    /// Triangles after cutting polygons.
    pub triangles: usize,
    /// Connected components.
    pub components: usize,
    /// Edges of more than two triangles.
    pub non_manifold_edges: usize,
    /// Length of the diagonal of the bounding box, in the unit of the file.
    pub diagonal: f64,
}

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

/// A pose.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
pub struct PoseReport {
    /// Its name.
    pub name: String,
    /// Why it failed, if it did.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error: Option<Value>,
    /// Whether it was kept from an earlier run.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub reused: bool,
    /// What the transfer says of it.
    pub figures: Figures,
    /// What is to be said of it; none where nothing was measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub verdict: Option<Verdict>,
    /// For each metric its figures.
    #[serde(default, skip_serializing_if = "Map::is_empty")]
    pub metrics: Map<String, Value>,
    /// Those against the truth for the target at rest in place of the result.
    #[serde(default, skip_serializing_if = "Map::is_empty")]
    pub nothing: Map<String, Value>,
}

impl MeshFigures {
    /// Of a mesh.
    pub fn new(side: &Side) -> Self {
        let mesh = &side.sequence.rest;
        Self {
            vertices: mesh.positions.len(),
            polygons: mesh.polygons.len(),
            welded_vertices: side.surface.vertex_count(),
            triangles: side.surface.triangle_count(),
            components: side.surface.components().count(),
            non_manifold_edges: Topology::new(&side.surface.triangles).non_manifold.len(),
            diagonal: mesh.diagonal(),
        }
    }
}

/// The figure that a metric is told by.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Headline {
    /// Type of the metric.
    pub metric: String,
    /// The figure.
    pub figure: String,
}

impl Headline {
    /// That figure of a pose.
    pub fn of(&self, pose: &PoseReport) -> Option<f64> {
        pose.metrics.get(&self.metric)?.get(&self.figure)?.as_f64()
    }
}

/// For each metric that says anything of `poses` the figure that says most, and those that verdicts are about.
pub fn headlines(poses: &[PoseReport]) -> Vec<Headline> {
    let mut all: Vec<Headline> = Vec::new();
    for (metric, figures) in poses.iter().flat_map(|pose| &pose.metrics) {
        if all.iter().any(|one| one.metric == *metric) {
            continue;
        }
        let known = plugin::instance::<dyn Metric>(metric).and_then(|metric| metric.figures().first().copied());
        let first = || figures.as_object()?.iter().find(|(_, value)| value.is_number()).map(|(name, _)| name.clone());
        if let Some(figure) = known.map(str::to_owned).or_else(first) {
            all.push(Headline { metric: metric.clone(), figure });
        }
    }
    let judged = poses.iter().filter_map(|pose| pose.verdict.as_ref()).flat_map(|verdict| &verdict.reasons);
    for Reason { metric, figure, .. } in judged {
        let blamed = Headline { metric: metric.clone(), figure: figure.clone() };
        if !all.contains(&blamed) {
            let after = all.iter().rposition(|one| one.metric == blamed.metric).map_or(all.len(), |at| at + 1);
            all.insert(after, blamed);
        }
    }
    // What is known to be wrong goes before what looks so.
    all.sort_by_key(|headline| headline.metric != "point_error");
    all
}

/// For each metric `average`, `worst` and `nothing` over poses: means, but the root mean square of `rms`, and largest
/// values.
pub fn over_poses(poses: &[PoseReport]) -> Map<String, Value> {
    let names = poses.iter().flat_map(|pose| pose.metrics.keys());
    let mut result = Map::new();
    for name in names {
        if result.contains_key(name) {
            continue;
        }
        let of = |pick: fn(&PoseReport) -> &Map<String, Value>| {
            poses.iter().filter_map(|pose| pick(pose).get(name)).collect()
        };
        let (scored, nothing): (Vec<&Value>, Vec<&Value>) = (of(|pose| &pose.metrics), of(|pose| &pose.nothing));
        let summary = serde_json::json!({
            "average": combine(&scored, average),
            "worst": combine(&scored, |_, values| largest(values)),
            "nothing": combine(&nothing, average),
        });
        result.insert(name.clone(), summary);
    }
    result
}

/// The value of largest size, with its sign.
fn largest(values: &[f64]) -> f64 {
    values.iter().copied().fold(0.0, |most: f64, value| if value.abs() > most.abs() { value } else { most })
}

/// The mean; of root mean squares the root mean square.
fn average(figure: &str, values: &[f64]) -> f64 {
    let count = values.len() as f64;
    if figure.ends_with("rms") {
        (values.iter().map(|value| value * value).sum::<f64>() / count).sqrt()
    } else {
        values.iter().sum::<f64>() / count
    }
}

fn combine(poses: &[&Value], how: impl Fn(&str, &[f64]) -> f64) -> Value {
    let keys = poses.iter().filter_map(|figures| figures.as_object()).flat_map(|figures| figures.keys());
    let mut result = Map::new();
    for key in keys {
        // The number of a component or a marker has no average.
        if key != "worst" && !result.contains_key(key) {
            let of_key: Vec<&Value> = poses.iter().filter_map(|figures| figures.get(key)).collect();
            let numbers: Vec<f64> = of_key.iter().filter_map(|value| value.as_f64()).collect();
            if of_key.iter().all(|value| value.is_u64() && *value == of_key[0]) {
                result.insert(key.clone(), of_key[0].clone());
            } else if !numbers.is_empty() {
                result.insert(key.clone(), how(key, &numbers).into());
            } else if let Some(curve) = combine_curves(&of_key, |values| how(key, values)) {
                result.insert(key.clone(), curve);
            }
        }
    }
    Value::Object(result)
}

/// Lists of equally many numbers, one number after the other.
fn combine_curves(curves: &[&Value], how: impl Fn(&[f64]) -> f64) -> Option<Value> {
    let numbers = |curve: &&Value| curve.as_array()?.iter().map(Value::as_f64).collect::<Option<Vec<f64>>>();
    let curves: Vec<Vec<f64>> = curves.iter().filter_map(numbers).collect();
    let length = curves.first()?.len();
    let at = |k: usize| how(&curves.iter().filter_map(|curve| curve.get(k).copied()).collect::<Vec<f64>>());
    Some((0..length).map(at).collect::<Vec<f64>>().into())
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn the_rms_over_poses_is_a_root_mean_square_and_the_rest_are_means() {
        let pose = |rms: f64, mean: f64| PoseReport {
            metrics: json!({ "point_error": { "rms": rms, "mean": mean } }).as_object().unwrap().clone(),
            ..PoseReport::default()
        };
        let all = over_poses(&[pose(3.0, 1.0), pose(4.0, 2.0)]);
        assert_eq!(all["point_error"]["average"]["rms"], json!((12.5f64).sqrt()));
        assert_eq!(all["point_error"]["average"]["mean"], json!(1.5));
        assert_eq!(all["point_error"]["worst"]["rms"], json!(4.0));
    }
}
