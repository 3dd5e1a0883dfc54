//! Verdicts against true errors, on results of real meshes and on spoiled ones.
//!
//! It takes half an hour, so it runs only when asked:
//!
//! ```sh
//! cargo test --release --test verdicts -- --ignored --nocapture
//! ```
//!
//! It prints the table of docs/metrics.md. `VERDICTS_ONLY=face` takes the cases with `face` in their names, and `VERDICTS_OUT=FILE`
//! writes a line of JSON with all statistics for each pose, which limits are chosen from. Maps and results are kept in the target
//! folder; remove `tmp/verdicts` there after a change of a correspondence or a transfer.

mod cases;
mod spoil;
mod transferred;
mod truth;

use std::{fs::File, io::Write};

use cases::{Case, Positions};
use mimesh::core::{
    mesh::Surface,
    plugin::instances,
    stage::{Frame, Metric, MetricContext, MetricInput, Posed, TransferPair},
    testkit::data::data,
};
use mimesh_pipeline::metrics::{Level, MetricSet};
use rayon::prelude::*;
use serde_json::json;
use spoil::Spoiled;
use transferred::transferred;
use truth::{Table, Truth};

#[test]
#[ignore = "takes half an hour"]
fn no_bad_result_is_called_good_and_hardly_any_good_one_bad() {
    let Some(data) = data("") else { return };
    let mut out = std::env::var_os("VERDICTS_OUT").map(|path| File::create(path).unwrap());
    let mut tables = [Table::default(), Table::default()];
    cases::all(&data, |case| {
        for (pose, line) in judged(&case) {
            tables[usize::from(!case.chooses)].add(&pose);
            if let Some(out) = &mut out {
                writeln!(out, "{line}").unwrap();
            }
        }
    });
    let [choice, report] = tables;
    println!("limits chosen on\n{choice}\nreported on\n{report}");
    assert_eq!(report.count(Truth::Bad, Level::Good), 0, "bad results that are called good");
    let good = report.of(Truth::Good);
    assert!(20 * report.count(Truth::Good, Level::Bad) <= good, "good results that are called bad, of {good}");
}

/// A pose that was judged.
pub struct JudgedPose {
    /// The case and the fault.
    pub name: String,
    /// How good it truly is.
    pub truth: Truth,
    /// The worse of the verdicts on the pose and on map and markers.
    pub verdict: Level,
}

/// All poses of a case, good and spoiled, each with a line of JSON.
fn judged(case: &Case) -> Vec<(JudgedPose, String)> {
    let surface = Surface::new(&case.target).unwrap();
    let mut runs = vec![("none", case.markers.clone())];
    runs.extend(spoil::markers(case, &surface));
    let mut all = Vec::new();
    for (fault, pairs) in runs {
        let markers = transferred::markers(&pairs);
        let Some((map, results)) = transferred(case, &surface, &pairs, fault) else { continue };
        let pair = TransferPair { source: &case.source, target: &surface, markers: &markers, proximity: None };
        let context = MetricContext { rest: &case.target, surface: &surface, pair: Some(pair), map: Some(&map) };
        let metrics = instances::<dyn Metric>().into_iter().map(|(_, metric)| metric).filter(|m| m.by_default());
        let metrics = MetricSet::bind(&metrics.collect::<Vec<_>>(), context).unwrap();
        let results_of = |spoiled: &Spoiled| judged_results(case, &surface, &metrics, spoiled);
        if fault == "none" {
            all.extend(spoil::results(case, &surface, &results).iter().flat_map(results_of));
        }
        all.extend(results_of(&Spoiled { name: fault, results, scale: 1.0 }));
    }
    all
}

/// The poses of one set of results.
fn judged_results(
    case: &Case,
    surface: &Surface,
    metrics: &MetricSet<'_>,
    spoiled: &Spoiled,
) -> Vec<(JudgedPose, String)> {
    let scaled = |positions: &Positions| -> Positions { positions.iter().map(|p| p * spoiled.scale).collect() };
    let results = &spoiled.results;
    let on_surface: Vec<Positions> = results.iter().map(|result| surface.from_mesh(result).unwrap()).collect();
    let sources: Vec<Positions> = case.poses.iter().map(|(_, pose)| scaled(pose)).collect();
    let posed = |k: usize| Posed { mesh: &results[k], surface: &on_surface[k] };
    let rest = Posed { mesh: &case.target.positions, surface: &surface.positions };
    let pose = |k: usize| {
        let frame = |back: usize| {
            let k = k.checked_sub(back)?;
            Some(Frame { result: posed(k), source: Some(&sources[k]) })
        };
        let blind =
            MetricInput { source: Some(&sources[k]), before: [frame(1), frame(2)], ..MetricInput::alone(posed(k)) };
        let measured = metrics.measure(blind).metrics();
        let known = scaled(&case.truth[k]);
        let known_surface = surface.from_mesh(&known).unwrap();
        let ground_truth = Posed { mesh: &known, surface: &known_surface };
        let against =
            |result| metrics.measure_against_ground_truth(MetricInput::against(result, ground_truth)).metrics();
        let (error, nothing) = (against(posed(k)), against(rest));
        let statistic = |name: &str| error.value("point_error", name).unwrap_or(0.0);
        let [mean, component, vertex] = ["mean", "comp_max", "max"].map(statistic);
        let motion = nothing.value("point_error", "mean").unwrap();
        let truth = Truth::new(mean, component, vertex, motion);
        let verdicts = [metrics.verdict(&measured), metrics.rest_verdict(&measured)];
        let verdict = verdicts.iter().flatten().map(|verdict| verdict.level).max().unwrap_or_default();
        let line = json!({ "case": case.name, "chooses": case.chooses, "fault": spoiled.name, "pose": case.poses[k].0,
            "mean": mean, "component": component, "vertex": vertex, "motion": motion,
            "verdict": verdicts[0], "rest_verdict": verdicts[1], "statistics": measured.statistics });
        (JudgedPose { name: format!("{}, {}", case.name, spoiled.name), truth, verdict }, line.to_string())
    };
    (0..results.len()).into_par_iter().map(pose).collect()
}
