//! Statistics over poses, combined as the bundled metrics declare them.
#![cfg(feature = "bundled")]

// Links the bundled metrics.
use mimesh as _;
use mimesh_pipeline::{
    metrics::{over_poses, primary_statistics},
    report::PoseReport,
};
use serde_json::{Value, json};

fn pose(metrics: Value) -> PoseReport {
    PoseReport { metrics: metrics.as_object().unwrap().clone(), ..PoseReport::default() }
}

#[test]
fn statistics_are_combined_as_they_are_declared() {
    let scored = |rms: f64, mean: f64, components: u32| {
        pose(json!({ "point_error": { "rms": rms, "mean": mean, "components": components, "within": [mean, 100.0] } }))
    };
    let all = over_poses(&[scored(3.0, 1.0, 7), scored(4.0, 2.0, 7)]);
    let (average, worst) = (&all["point_error"]["average"], &all["point_error"]["worst"]);
    assert_eq!(average["rms"], json!((12.5f64).sqrt()));
    assert_eq!(average["mean"], json!(1.5));
    assert_eq!(average["components"], json!(7));
    assert_eq!(average["within"], json!([1.5, 100.0]));
    assert_eq!((&worst["rms"], &worst["mean"]), (&json!(4.0), &json!(2.0)));
}

#[test]
fn numbers_of_things_have_no_average_and_metrics_that_are_not_linked_have_means() {
    let moved = |offset: f64, worst: u32| {
        let values = json!({ "offset_max": offset, "worst": worst });
        pose(json!({ "component_motion": values, "not_linked": values }))
    };
    let all = over_poses(&[moved(1.0, 2), moved(-3.0, 4)]);
    assert_eq!(all["component_motion"]["average"], json!({ "offset_max": -1.0 }));
    assert_eq!(all["component_motion"]["worst"], json!({ "offset_max": -3.0 }));
    assert_eq!(all["not_linked"]["average"], json!({ "offset_max": -1.0, "worst": 3.0 }));
}

#[test]
fn a_metric_is_shown_by_its_first_statistic_and_by_those_above_their_limits() {
    let measured = pose(json!({ "edge_stretch": { "p99": 30.0, "beyond": 30.0 }, "point_error": { "mean": 1.0 } }));
    let names = |poses: &[PoseReport]| -> Vec<String> {
        primary_statistics(poses).iter().map(|one| format!("{}.{}", one.metric, one.statistic)).collect()
    };
    assert_eq!(names(std::slice::from_ref(&measured)), ["point_error.mean", "edge_stretch.beyond"]);
    let reason = json!({ "level": "bad", "metric": "edge_stretch", "figure": "median", "value": 40.0, "limit": 30.0 });
    let verdict = serde_json::from_value(json!({ "level": "bad", "reasons": [reason] })).unwrap();
    let blamed = PoseReport { verdict: Some(verdict), ..measured };
    assert_eq!(names(&[blamed]), ["point_error.mean", "edge_stretch.beyond", "edge_stretch.median"]);
}
