//! Biharmonic transfer between real bodies whose results are known.
//!
//! The meshes are not part of this repository: they are looked for in `../shared/data`. Where they are absent the test says
//! that it was skipped, and fails if the environment has CI=true.
#![cfg(feature = "bundled")]

mod common;

use std::path::Path;

use common::{Project, data};
use serde_json::Value;

/// The mean error over six poses, in percent of the target's diagonal.
fn error(bodies: &Path, target: &str, landmarks: usize, reconstruction: &str) -> f64 {
    let text = std::fs::read_to_string(bodies.join(target).join("landmarks.json")).expect("landmarks");
    let json: Value = serde_json::from_str(&text).expect("landmarks in JSON");
    let side = |key: &str| json[key].as_array().expect("a list").iter().map(|v| v.as_u64().expect("a vertex"));
    let pairs: Vec<_> = side("source").zip(side("target")).take(landmarks).collect();
    let project = Project::new();
    let lines: String = pairs.iter().map(|(s, t)| format!("{s}, {t}\n")).collect();
    project.write("m.cons", &format!("{landmarks}\n{lines}"));
    let bodies = bodies.display();
    let poses = ["kick", "crouch", "twist", "stride", "reach", "bow"].map(|p| format!("\"{bodies}/source/{p}.obj\""));
    project.write(
        "p.yaml",
        &format!(
            "source: {{ rest: \"{bodies}/source/rest.obj\", poses: [{}] }}\ntarget: {{ rest: \"{bodies}/{target}/rest.obj\" }}\n\
             markers: m.cons\ntransfer: {{ type: biharmonic, reconstruction: {reconstruction} }}\n\
             truth: \"{bodies}/{target}/truth-{{pose}}.ply\"\noutput: out/all.glb\n",
            poses.join(", ")
        ),
    );
    let said = project.mimesh(&["run", "p.yaml", "--json"]);
    assert_eq!(said.status, 0, "{}", said.err);
    let report: Value = serde_json::from_str(&said.out).expect("a report");
    report["metrics"]["point_error"]["average"]["mean"].as_f64().expect("a mean")
}

#[test]
fn twenty_handles_carry_poses_from_body_to_body() {
    let Some(data) = data() else { return };
    let bodies = data.join("bodies");
    let error = |target: &str, landmarks, reconstruction: &str| error(&bodies, target, landmarks, reconstruction);
    let [child, heavy] = ["target-child", "target-heavy"].map(|target| error(target, 20, "gradients"));
    assert!(child <= 0.25 && heavy <= 0.25, "child {child}, heavy {heavy}");
    let few = error("target-child", 10, "gradients");
    assert!(few <= 0.3, "child with ten landmarks: {few}");
    // The giant has other proportions, whose joints the paper's reconstruction does not follow.
    let [own, paper] = ["gradients", "blend"].map(|reconstruction| error("target-giant", 20, reconstruction));
    assert!(own < 0.75 * paper, "giant: {own} and {paper}");
}
