//! A pose of the source in place of its rest, and the advice to take one.
#![cfg(feature = "bundled")]

mod common;

use common::{PIPELINE, Project, diagnostics, leaning};
use mimesh::core::testkit::data::data;
use serde_json::Value;

fn run(project: &Project, more: &[&str]) -> Value {
    let output = project.mimesh(&[&["run", "p.yaml", "--json"], more].concat());
    assert_eq!(output.status, 0, "{}", output.stderr);
    output.json()
}

/// A project whose source file rests as its pose 2 leans.
fn leaning_rest() -> Project {
    let project = Project::new();
    project.write("leaning.obj", &leaning(0.2));
    project.write(
        "p.yaml",
        &PIPELINE.replace("rest: rest.obj, poses: pose-*.obj", "rest: leaning.obj, poses: [rest.obj, pose-*.obj]"),
    );
    project
}

#[test]
fn a_pose_as_rest_gives_what_a_file_of_it_gives() {
    let expected = Project::new();
    run(&expected, &[]);
    let project = leaning_rest();
    run(&project, &["--set", "source.rest={ file: leaning.obj, pose: rest }"]);
    for pose in ["1", "2", "10"] {
        let name = format!("out/{pose}.obj");
        assert_eq!(project.read(&name), expected.read(&name), "{name}");
    }
    // The pose that serves as rest is a pose still, and gives the target at rest.
    assert_eq!(project.read("out/rest.obj"), project.read("target.obj"));
}

#[test]
fn the_pose_is_part_of_the_keys_and_the_plan_says_so() {
    let project = leaning_rest();
    run(&project, &[]);
    let resting = ["--set", "source.rest={ file: leaning.obj, pose: rest }"];
    let again = run(&project, &resting);
    assert!(again["poses"].as_array().expect("poses").iter().all(|pose| pose["reused"] != true));
    assert_eq!(again["settings"]["source"]["rest"]["pose"], "rest");
    let plan = project.mimesh(&[&["plan", "p.yaml"], &resting[..]].concat());
    assert!(plan.stdout.contains("cached for this transfer and these poses"), "{}", plan.stdout);
    // The file written as a mapping is the same as its path.
    let mapping = run(&project, &["--set", "source.rest={ file: leaning.obj }"]);
    assert!(mapping["poses"].as_array().expect("poses").iter().all(|pose| pose["reused"] == true));
    assert_eq!(mapping["settings"]["source"]["rest"], "leaning.obj");
}

#[test]
fn a_pose_that_does_not_exist_and_a_wrong_key_are_reported_at_their_places() {
    let project = leaning_rest();
    let one = |setting: &str| diagnostics(&project, &[setting]).join("\n");
    let missing = one("source.rest={ file: leaning.obj, pose: reset }");
    assert!(missing.contains("the source has no pose called `reset`"), "{missing}");
    let output = project.mimesh(&["check", "p.yaml", "--set", "source.rest={ file: leaning.obj, pose: reset }"]);
    assert!(output.stderr.contains("did you mean `rest`?"), "{}", output.stderr);
    assert!(one("source.rest={ file: leaning.obj, poses: rest }").contains("unknown"), "a key");
    assert!(one("source.rest={ pose: rest }").contains("file"), "the file is missing");
    assert!(one("source.rest=3").contains("a path, or a mapping `{ file: …, meshes: […] }`"), "a number");
}

#[test]
fn points_by_position_lie_on_the_file_whatever_pose_is_the_rest() {
    let project = leaning_rest();
    // Corners of the leaning box as its file has it, which are off the upright one by up to a fifth of the height.
    project.write("source.csv", "name,x,y,z\na,0,0,0\nb,1.6,2,3\nc,0.6,0,3\nd,1,2,0\n");
    project.write("target.csv", "name,x,y,z\na,0,0,0\nb,2,4,6\nc,0,0,6\nd,2,4,0\n");
    project.edit("correspondence:", "markers: { source: source.csv, target: target.csv }\ncorrespondence:");
    let report = run(&project, &["--set", "source.rest={ file: leaning.obj, pose: rest }"]);
    assert_eq!(report["markers"], 4);
}

/// The warnings about the rest of a horse that rests in a frame of its gallop or as it stands, onto the standing camel.
#[test]
fn a_rest_in_mid_gallop_is_noticed_and_the_standing_pose_is_named() {
    let (Some(horses), Some(camels), Some(markers)) =
        (data("sumner-horse-poses"), data("sumner-camel-poses"), data("markers"))
    else {
        return;
    };
    let project = Project::new();
    let (horses, camels, markers) = (horses.display(), camels.display(), markers.display());
    let pipeline = |rest: &str| {
        format!(
            "source: {{ rest: '{horses}/{rest}', poses: ['{horses}/horse-0?.obj', '{horses}/horse-reference.obj'] }}\n\
             target: {{ rest: '{camels}/camel-reference.obj' }}\nmarkers: '{markers}/horse_camel.cons'\n\
             correspondence: {{ type: nonrigid_fit }}\ntransfer: {{ type: gradient }}\noutput: out/{{pose}}.obj\n"
        )
    };
    project.write("p.yaml", &pipeline("horse-10.obj"));
    let advice = project.mimesh(&["check", "p.yaml"]);
    assert_eq!(advice.status, 0, "{}", advice.stderr);
    assert!(advice.stderr.contains("with the source in pose horse-reference"), "{}", advice.stderr);
    assert!(advice.stderr.contains("pose: horse-reference }"), "{}", advice.stderr);
    // Taken, it is content.
    let rest = format!("source.rest={{ file: '{horses}/horse-10.obj', pose: horse-reference }}");
    let taken = project.mimesh(&["check", "p.yaml", "--set", &rest]);
    assert_eq!((taken.status, taken.stderr.as_str()), (0, ""));
    project.write("p.yaml", &pipeline("horse-reference.obj"));
    assert_eq!(project.mimesh(&["check", "p.yaml"]).stderr.matches("rest in different shapes").count(), 0);
}

/// The same without clicks: landmarks by shape show it in a run.
#[test]
fn a_rest_in_a_crouch_is_noticed_by_landmarks_of_shape_too() {
    let Some(bodies) = data("bodies") else { return };
    let project = Project::new();
    let bodies = bodies.display();
    project.write(
        "p.yaml",
        &format!(
            "source: {{ rest: '{bodies}/source/crouch.obj', poses: ['{bodies}/source/rest.obj'] }}\n\
             target: {{ rest: '{bodies}/target-child/rest.obj' }}\nmarkers: auto\ncorrespondence: {{ type: nonrigid_fit }}\n\
             transfer: {{ type: gradient }}\noutput: out/{{pose}}.obj\n"
        ),
    );
    let output = project.mimesh(&["run", "p.yaml", "--json"]);
    let report: Value = serde_json::from_str(&output.stdout).unwrap();
    let warnings = report["warnings"].to_string();
    assert!(warnings.contains("with the source in pose rest;"), "{warnings}");
}
