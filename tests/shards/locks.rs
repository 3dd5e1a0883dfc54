//! `mimesh prepare`: once for all parts, and by one process at a time.

use std::{
    fs,
    process::{Child, Command, Stdio},
};

use serde_json::Value;

use crate::{
    FRAMES, GALLOP,
    common::{Project, wait_for},
    mimesh, project,
};

fn reused(report: &Value) -> Vec<(String, bool)> {
    let stages = report["stages"].as_array().expect("stages").iter().filter(|stage| stage.get("type").is_some());
    stages.map(|stage| (stage["stage"].as_str().expect("a name").to_owned(), stage["reused"] == true)).collect()
}

fn stages(of: [(&str, bool); 2]) -> Vec<(String, bool)> {
    of.map(|(stage, reused)| (stage.to_owned(), reused)).into()
}

#[test]
fn what_is_prepared_is_there_for_all_parts_and_is_not_done_again() {
    let project = project(GALLOP);
    let first = mimesh(&project, "prepare", &["--json"], 0).json();
    assert_eq!(reused(&first), stages([("correspondence", false), ("transfer", false)]));
    assert_eq!(first["poses"], serde_json::json!({ "cached": 0, "of": FRAMES }));
    assert!(!project.has("out"), "nothing is written");
    let again = mimesh(&project, "prepare", &["--json"], 0).json();
    assert_eq!(reused(&again), stages([("correspondence", true), ("transfer", true)]));
    let part = mimesh(&project, "run", &["--shard", "0/2", "--json"], 0).json();
    assert_eq!(reused(&part), stages([("correspondence", true), ("transfer", false)]), "each part binds");
    let text = mimesh(&project, "prepare", &[], 0).stdout;
    assert!(text.contains("correspondence (nonrigid_fit)") && text.contains("6 of 12 poses cached"), "{text}");
    assert_eq!(mimesh(&project, "prepare", &["--quiet"], 0).stdout, "");
    mimesh(&project, "prepare", &["--no-cache"], 2);
}

/// A project where a process prepares the correspondence and stands still while it holds the lock.
fn held() -> (Project, Child) {
    let project = project(&GALLOP.replace("resolution: 22", "resolution: 60").replace("steps: 4", "steps: 100"));
    let mut command = project.command(&["prepare", "p.yaml", "--quiet"]);
    let child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("the command runs");
    wait_for("a lock", || is_locked(&project));
    let stopped = Command::new("kill").args(["-STOP", &child.id().to_string()]).status().expect("a signal");
    assert!(stopped.success());
    (project, child)
}

/// Whether there is a lock on the correspondence, as its file tells once it is written.
fn is_locked(project: &Project) -> bool {
    let folder = project.cache().join("v1/locks");
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let is_written = |entry: fs::DirEntry| entry.metadata().is_ok_and(|metadata| metadata.len() > 0);
    entries.filter(|entry| entry.file_name().to_string_lossy().starts_with("correspondence")).any(is_written)
}

#[cfg(unix)]
#[test]
fn who_needs_what_another_computes_ends_at_once_and_a_killed_process_holds_nothing() {
    let (project, mut first) = held();
    for (command, more) in [("prepare", &[][..]), ("run", &["--shard", "0/2"]), ("run", &["--frames", "3"])] {
        let refused = mimesh(&project, command, more, 75);
        let who = format!("correspondence (nonrigid_fit): process {}", first.id());
        assert!(refused.stderr.contains(&who), "{command}: {}", refused.stderr);
        assert!(refused.stderr.contains("hint: run this again when it is done"), "{}", refused.stderr);
        assert!(!project.has("out"));
    }
    // What others compute is no matter of theirs.
    mimesh(&project, "prepare", &["--set", "correspondence.steps=2"], 0);
    // The system releases the lock, and its file is left.
    first.kill().expect("a process to kill");
    first.wait().expect("an end");
    assert!(is_locked(&project));
    let taken = mimesh(&project, "prepare", &["--json"], 0).json();
    assert_eq!(reused(&taken), stages([("correspondence", false), ("transfer", false)]));
    assert!(!is_locked(&project), "who held it last removes the file");
    mimesh(&project, "run", &["--frames", "3"], 0);
}
