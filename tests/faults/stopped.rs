//! Runs that were stopped while they moved their results: what is told of them, and what becomes of results edited since.

use std::fs;

use serde_json::{Value, json};

use crate::{
    common::{Project, json},
    sets::run,
};

/// The results of the pipeline, of which the report is moved last.
const RESULTS: [&str; 4] = ["out/1.obj", "out/2.obj", "out/10.obj", "out/run.json"];

/// What the names of the temporary files of the stopped run begin with.
const STEM: &str = ".mimesh-abcdef012345";

/// A line as journals have them: the hash of a text, and the text.
pub fn line(value: &Value) -> String {
    let text = value.to_string();
    format!("{} {text}\n", blake3::hash(text.as_bytes()).to_hex())
}

/// A project whose second run was stopped when it had moved the first of its results.
fn stopped() -> Project {
    let project = Project::new();
    run(&project);
    let old = RESULTS.map(|result| project.bytes(result));
    lean_three(&project, 0.5);
    run(&project);
    let new = RESULTS.map(|result| project.bytes(result));
    let names = RESULTS.map(|result| result.trim_start_matches("out/"));
    let mut moves = Vec::new();
    for (i, result) in RESULTS.iter().enumerate() {
        assert_ne!(old[i], new[i]);
        fs::write(project.path(result), &old[i]).expect("a file");
        let modified = fs::metadata(project.path(result)).and_then(|found| found.modified()).expect("a time");
        let modified = modified.duration_since(std::time::UNIX_EPOCH).expect("a time").as_nanos() as u64;
        moves.push(json!({
            "place": i, "bytes": new[i].len(), "blake3": blake3::hash(&new[i]).to_hex().as_str(), "replaces": true,
            "before": { "bytes": old[i].len(), "modified": modified },
        }));
        fs::write(project.path(&format!("out/{STEM}-{i}.part")), &new[i]).expect("a file");
    }
    fs::rename(project.path("out/1.obj"), project.path(&format!("out/{STEM}-0.old"))).expect("a file");
    fs::rename(project.path(&format!("out/{STEM}-0.part")), project.path("out/1.obj")).expect("a file");
    let head = json!({ "mimesh_journal": 1, "started": 0, "places": names });
    project.write(&format!("out/{STEM}.journal"), &(line(&head) + &line(&json!({ "moves": moves }))));
    project
}

fn lean_three(project: &Project, by: f64) {
    for pose in [1, 2, 10] {
        project.write(&format!("pose-{pose}.obj"), &crate::common::leaning(by + 0.01 * f64::from(pose)));
    }
}

fn warnings(report: &Value) -> String {
    report["warnings"]
        .as_array()
        .expect("warnings")
        .iter()
        .map(|text| text.as_str().expect("text").to_owned() + "\n")
        .collect()
}

#[test]
fn check_and_plan_tell_of_the_stopped_run_and_the_next_one_tells_what_it_did() {
    let project = stopped();
    let told = "a run was stopped when 1 of its 4 results were in place";
    for arguments in [&["check", "p.yaml"][..], &["plan", "p.yaml"]] {
        let output = project.mimesh(arguments);
        assert!(output.status == 0 && output.stderr.contains(told), "{}", output.stderr);
        let output = project.mimesh(&[arguments, &["--json"]].concat());
        assert!(warnings(&output.json()).contains(told), "{}", output.stdout);
    }
    let output = project.mimesh(&["run", "p.yaml"]);
    let done = format!("{told}; now all of them are");
    assert_eq!(output.stderr.matches(&done).count(), 1, "{}", output.stderr);
    assert!(!output.stderr.contains("the next run"), "{}", output.stderr);
    assert!(warnings(&json(&project.read("out/run.json"))).contains(&done));
    assert_eq!(project.names("out"), ["1.obj", "10.obj", "2.obj", "run.json"]);
    let again = project.mimesh(&["run", "p.yaml"]);
    assert!(!again.stderr.contains("stopped"), "{}", again.stderr);
}

#[test]
fn what_recovery_did_is_told_even_if_the_run_fails_then() {
    let project = stopped();
    let mimesh = project.command(&["run", "p.yaml", "--no-cache"]);
    let mut command = std::process::Command::new("sh");
    // The report is larger than any file may be, and the poses are not.
    command.args(["-c", "ulimit -f 1; exec \"$@\"", "sh"]).arg(mimesh.get_program()).args(mimesh.get_args());
    let output = command.current_dir(project.path(".")).output().expect("sh runs");
    let told = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(73), "{told}");
    assert!(told.contains("now all of them are") && told.contains("run.json: cannot write"), "{told}");
    assert_eq!(project.names("out"), ["1.obj", "10.obj", "2.obj", "run.json"]);
}

#[test]
fn a_result_that_was_edited_since_is_kept_beside() {
    // One that was moved, one that was not, and the report.
    for (edited, wanted) in [
        ("out/1.obj", "are in place again"),
        ("out/2.obj", "now all of them are"),
        ("out/run.json", "now all of them are"),
    ] {
        let project = stopped();
        let text = if edited.ends_with("json") { project.read(edited) + "\n" } else { "# by hand\n".into() };
        project.write(edited, &text);
        let output = project.mimesh(&["run", "p.yaml"]);
        assert_eq!(output.status, 0, "{}", output.stderr);
        assert_eq!(project.read(&format!("{edited}.edited")), text, "{}", output.stderr);
        let told = format!(
            "what was edited is kept as {}",
            project.path(&format!("{edited}.edited")).canonicalize().expect("a file").display()
        );
        assert!(output.stderr.contains(&told) && output.stderr.contains(wanted), "{}", output.stderr);
        let report = warnings(&json(&project.read("out/run.json")));
        assert!(report.contains(&told) && report.contains(wanted), "{report}");
        assert_eq!(project.names("out").len(), RESULTS.len() + 1);
    }
}

#[test]
fn a_second_pipeline_with_one_of_the_outputs_ends_the_stopped_run_first() {
    let project = stopped();
    project.write("second/2.obj", &project.read("pose-1.obj"));
    project.write("second.yaml", &crate::common::PIPELINE.replace("pose-*.obj", "second/*.obj"));
    let output = project.mimesh(&["run", "second.yaml"]);
    assert!(output.status == 0 && output.stderr.contains("now all of them are"), "{}", output.stderr);
    assert_eq!(project.names("out"), ["1.obj", "10.obj", "2.obj", "run.json"]);
}

#[test]
fn transfer_tells_of_the_stopped_run_too() {
    let project = stopped();
    let transfer = ["transfer", "rest.obj", "target.obj", "--poses", "pose-*.obj", "-o", "out/{pose}.obj"];
    let told = "a run was stopped when 1 of its 4 results were in place";
    let output = project.mimesh(&transfer);
    assert!(output.status == 73 && output.stderr.contains(told), "{}", output.stderr);
    let output = project.mimesh(&[&transfer[..], &["--force"]].concat());
    assert_eq!(output.status, 0, "{}", output.stderr);
    let done = format!("{told}; now all of them are");
    let report = project.names("out").into_iter().find(|name| name.ends_with("run.json") && name != "run.json");
    let report = report.unwrap_or_else(|| "run.json".into());
    assert!(output.stderr.contains(&done), "{}", output.stderr);
    assert!(warnings(&json(&project.read(&format!("out/{report}")))).contains(&done));
}
