//! The pipelines of the project, as they stand.
#![cfg(feature = "bundled")]

mod common;

use common::{Project, assert_at_most, json, pipelines};

/// The measured mean error of each pipeline over all poses, in percent of the target's diagonal; of several runs the worst.
/// In the order of their files.
const MEASURED: [(&str, f64); 15] = [
    ("automatic", 0.2871),
    ("baseline", 0.6694),
    ("benchmark", 0.8044),
    ("biharmonic", 0.1922),
    ("combined-blend", 0.3169),
    ("combined-chain", 0.8794),
    ("combined", 0.3003),
    ("gallop", 0.2662),
    ("giraffe", 0.2238),
    ("herd", 0.2097),
    ("keypoints", 0.6619),
    ("pebbles", 0.2788),
    ("plates", 0.3587),
    ("robot", 0.3050),
    // Rounding: the meshes are the same.
    ("same-mesh", 1e-11),
];

#[test]
fn every_pipeline_runs_and_comes_near_the_known_result() {
    let project = Project::new();
    let mut found = Vec::new();
    for file in &pipelines() {
        let pipeline = file.file_stem().expect("a name").to_string_lossy().into_owned();
        let output = project.mimesh(&["run", &file.to_string_lossy(), "--out", &pipeline, "--quiet"]);
        assert_eq!(output.status, 0, "{}: {}", file.display(), output.stderr);
        // Several runs have a folder each.
        let names = project.names(&pipeline);
        let runs = if names.contains(&"run.json".into()) { vec![String::new()] } else { names };
        for run in runs {
            let report = json(&project.read(&format!("{pipeline}/{run}/run.json")));
            let error = &report["metrics"]["point_error"];
            let mean = error["average"]["mean"].as_f64().expect("a mean");
            let baseline = error["nothing"]["mean"].as_f64().expect("a mean");
            let measured = MEASURED.iter().find(|(known, _)| *known == pipeline);
            let (_, measured) = measured.unwrap_or_else(|| panic!("{pipeline}: {mean} is not in the list"));
            // A method that deserves its place leaves less than half of the error of the target at rest.
            assert_at_most(&format!("{pipeline} {run}"), mean, 0.5 * baseline, *measured);
        }
        found.push(pipeline);
    }
    assert_eq!(found, MEASURED.map(|(pipeline, _)| pipeline), "the list names a pipeline that is not there");
}
