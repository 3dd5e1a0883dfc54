//! Biharmonic transfer between real bodies whose results are known.
//!
//! tests/DATA.md lists the meshes. Bounds are in percent of the target's diagonal: the requirement, then the measured value.
#![cfg(feature = "bundled")]

mod common;

use std::path::Path;

use common::{Project, assert_at_most};
use mimesh::core::testkit::data::data;
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
    let output = project.mimesh(&["run", "p.yaml", "--json"]);
    assert_eq!(output.status, 0, "{}", output.stderr);
    output.json()["metrics"]["point_error"]["average"]["mean"].as_f64().expect("a mean")
}

#[test]
fn twenty_handles_carry_poses_from_body_to_body() {
    let Some(bodies) = data("bodies") else { return };
    let error = |target: &str, landmarks, reconstruction: &str| error(&bodies, target, landmarks, reconstruction);
    let [child, heavy] = ["target-child", "target-heavy"].map(|target| error(target, 20, "gradients"));
    // The best other program has 0.27 and 0.28 with 16 landmarks.
    assert_at_most("child, 20 landmarks", child, 0.25, 0.187);
    assert_at_most("heavy, 20 landmarks", heavy, 0.25, 0.203);
    let few = error("target-child", 10, "gradients");
    // Half the handles may cost a fifth.
    assert_at_most("child, 10 landmarks", few, 0.3, 0.230);
    // The giant has other proportions, whose joints the paper's reconstruction does not follow.
    let [own, paper] = ["gradients", "blend"].map(|reconstruction| error("target-giant", 20, reconstruction));
    assert_at_most("giant, ratio to the paper's reconstruction", own / paper, 0.75, 0.555);
}
