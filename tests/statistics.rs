//! Statistics over poses, combined as the bundled metrics declare them.
#![cfg(feature = "bundled")]

// Links the bundled metrics.
use mimesh::core::{plugin, stage::Metric};
use mimesh_pipeline::{
    metrics::{Level, MetricSet, PoseMetrics, over_poses, primary_statistics},
    report::PoseReport,
};
use serde_json::{Value, json};

fn pose(metrics: Value) -> PoseReport {
    PoseReport { metrics: metrics.as_object().unwrap().clone().into(), ..PoseReport::default() }
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

/// Metrics that give verdicts on measurements, and such measurements.
fn verdicts(values: Value) -> (MetricSet<'static>, PoseMetrics) {
    let names = ["map_tears", "edge_stretch", "point_error"];
    let set = MetricSet::for_verdicts(&names.map(|name| plugin::instance::<dyn Metric>(name).unwrap()));
    (set, PoseMetrics { statistics: values.as_object().unwrap().clone(), ..PoseMetrics::default() })
}

#[test]
fn faults_of_the_map_are_judged_once_and_with_no_pose() {
    let (set, torn) = verdicts(json!({ "map_tears": { "share": 5.0 }, "edge_stretch": { "beyond": 0.0 } }));
    assert_eq!(set.verdict(&torn).unwrap().level, Level::Good);
    let shared = set.rest_verdict(&torn).unwrap();
    assert_eq!((shared.level, shared.reasons[0].metric.as_str()), (Level::Bad, "map_tears"));
    let (set, no_map) = verdicts(json!({ "edge_stretch": { "beyond": 0.0 } }));
    assert!(set.rest_verdict(&no_map).is_none());
}

#[test]
fn suspicions_are_no_worse_than_doubtful_where_the_result_is_known() {
    let level = |values: Value| {
        let (set, measured) = verdicts(values);
        set.verdict(&measured).unwrap().level
    };
    let stretch = json!({ "beyond": 900.0 });
    assert_eq!(level(json!({ "edge_stretch": stretch })), Level::Bad);
    assert_eq!(level(json!({ "edge_stretch": stretch, "point_error": { "mean": 0.1 } })), Level::Doubtful);
    assert_eq!(level(json!({ "edge_stretch": stretch, "point_error": { "mean": 6.0 } })), Level::Bad);
}
