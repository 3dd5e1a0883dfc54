//! Results that are kept from run to run: taken only where nothing they depend on has changed, whatever happened before.
#![cfg(feature = "bundled")]

mod common;

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
    process::{Command, Stdio},
    time::Duration,
};

use common::Project;
use mimesh::core::testkit::random::Random;
use serde_json::Value;

/// A gallop with files a pose and one of all.
const GALLOP: &str = "\
source: { generator: { type: quadruped, proportions: horse, gait: gallop, resolution: 20 } }
target: { generator: { type: quadruped, proportions: camel, gait: gallop, resolution: 24, seed: 1 } }
correspondence: { type: nonrigid_fit }
transfer: { type: gradient }
output: [ out/camel-{pose}.obj, out/camel.glb ]
";

fn gallop() -> Project {
    let project = Project::new();
    project.write("p.yaml", GALLOP);
    project
}

fn run(project: &Project, more: &[&str]) -> Value {
    let said = project.mimesh(&[&["run", "p.yaml", "--json"], more].concat());
    assert_eq!(said.status, 0, "{}", said.err);
    serde_json::from_str(&said.out).expect("a report")
}

/// The results, by name, without the report, which tells times.
fn results(project: &Project, folder: &str) -> BTreeMap<String, Vec<u8>> {
    let names = project.names(folder).into_iter().filter(|name| name != "run.json");
    names.map(|name| (name.clone(), fs::read(project.path(folder).join(&name)).expect("a result"))).collect()
}

/// For each stage whether its result was kept, and how many poses were.
fn reused(report: &Value) -> (Vec<(String, bool)>, usize) {
    let is_reused = |value: &Value| value["reused"] == true;
    let stages = report["stages"].as_array().expect("stages").iter().filter(|stage| stage.get("type").is_some());
    let stages = stages.map(|stage| (stage["stage"].as_str().expect("a name").to_owned(), is_reused(stage))).collect();
    (stages, report["poses"].as_array().expect("poses").iter().filter(|pose| is_reused(pose)).count())
}

fn stages(of: &[(&str, bool)]) -> Vec<(String, bool)> {
    of.iter().map(|(stage, reused)| (stage.to_string(), *reused)).collect()
}

/// The files of all entries that are kept.
fn entries(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).into_iter().flatten() {
        let path = entry.expect("an entry").path();
        if path.is_dir() { found.extend(entries(&path)) } else { found.push(path) }
    }
    found.sort();
    found
}

#[test]
fn the_same_run_again_does_no_work_and_gives_the_same_bytes() {
    let project = gallop();
    let first = run(&project, &[]);
    assert_eq!(reused(&first), (stages(&[("correspondence", false), ("transfer", false)]), 0));
    let results_of_first = results(&project, "out");
    let plan = project.mimesh(&["plan", "p.yaml"]);
    assert!(plan.out.matches("reuse:").count() == 3 && !plan.out.contains("run"), "{}", plan.out);

    let second = run(&project, &["--threads", "1"]);
    assert_eq!(reused(&second), (stages(&[("correspondence", true), ("transfer", true)]), 12));
    assert_eq!(results(&project, "out"), results_of_first);
    // What stages said is kept with their results.
    let figures =
        |report: &Value| report["stages"].as_array().unwrap().iter().map(|s| s["figures"].clone()).collect::<Vec<_>>();
    assert_eq!(figures(&first), figures(&second));
    assert_eq!(first["metrics"], second["metrics"]);
    let said = project.mimesh(&["run", "p.yaml"]);
    assert!(said.out.contains("transfer (gradient): kept from an earlier run"), "{}", said.out);
    assert!(said.out.contains("12 of 12 kept"), "{}", said.out);

    let without = run(&project, &["--no-cache", "--out", "again"]);
    assert_eq!(reused(&without), (stages(&[("correspondence", false), ("transfer", false)]), 0));
    assert_eq!(results(&project, "again"), results_of_first);
}

#[test]
fn a_change_does_again_only_what_depends_on_it() {
    let project = gallop();
    run(&project, &[]);
    let planned = |more: &[&str]| project.mimesh(&[&["plan", "p.yaml"], more].concat()).out;

    let transfer = ["--set", "transfer.reweightings=1"];
    let plan = planned(&transfer);
    assert!(plan.contains("reuse: kept") && plan.contains("reweightings is 1, was 5"), "{plan}");
    assert_eq!(reused(&run(&project, &transfer)), (stages(&[("correspondence", true), ("transfer", false)]), 0));
    // Both are kept side by side.
    assert_eq!(reused(&run(&project, &[])).1, 12);
    assert_eq!(reused(&run(&project, &transfer)).1, 12);

    let correspondence = ["--set", "correspondence.steps=5"];
    assert!(planned(&correspondence).contains("steps is 5, was 10"), "{}", planned(&correspondence));
    let report = run(&project, &correspondence);
    assert_eq!(reused(&report), (stages(&[("correspondence", false), ("transfer", false)]), 0));

    // Another target changes all, other formats and files to write nothing.
    assert_eq!(reused(&run(&project, &["--set", "target.generator.seed=2"])).1, 0);
    assert_eq!(reused(&run(&project, &["--set", "output=[only/{pose}.ply]"])).1, 12);
}

#[test]
fn files_count_by_their_contents_and_not_by_name_or_time() {
    let project = Project::new();
    run(&project, &[]);
    let touched = fs::File::options().append(true).open(project.path("pose-2.obj")).expect("a pose");
    touched.set_modified(std::time::SystemTime::UNIX_EPOCH).expect("a time");
    assert_eq!(reused(&run(&project, &[])).1, 3);

    project.write("pose-2.obj", &common::leaning(0.7));
    let report = run(&project, &[]);
    // `copy_displacement` learns from no pose, so that the others stand.
    assert_eq!(reused(&report).1, 2);
    let plan = project.mimesh(&["plan", "p.yaml"]).out;
    assert!(plan.contains("poses") && plan.contains("reuse"), "{plan}");
    // Renamed, it is the same pose under another name.
    fs::rename(project.path("pose-2.obj"), project.path("pose-3.obj")).expect("another name");
    assert_eq!(reused(&run(&project, &[])).1, 3);
    assert!(project.has("out/3.obj"));
}

#[test]
fn a_file_that_a_stage_reads_counts_too() {
    let project = Project::new();
    project.edit("output:", "keep_correspondence: map.json\noutput:");
    run(&project, &[]);
    project.edit("keep_correspondence: map.json\n", "");
    project.edit("type: identity", "type: from_file, path: map.json");
    run(&project, &[]);
    assert_eq!(reused(&run(&project, &[])).1, 3);
    let map = project.read("map.json");
    project.write("map.json", &format!("{map}\n"));
    assert_eq!(reused(&run(&project, &[])), (stages(&[("correspondence", false), ("transfer", false)]), 0));
}

#[test]
fn damaged_entries_are_told_and_computed_again() {
    let project = gallop();
    run(&project, &[]);
    let expected = results(&project, "out");
    let all = entries(project.cache());
    assert!(all.len() > 12, "{all:?}");
    let mut random = Random::new(1);
    for (i, path) in all.iter().enumerate() {
        let mut bytes = fs::read(path).expect("an entry");
        let at = random.index(bytes.len());
        match i % 3 {
            0 => bytes[at] ^= 1,
            1 => bytes.truncate(at),
            _ => bytes.clear(),
        }
        fs::write(path, bytes).expect("an entry");
    }
    let report = run(&project, &[]);
    assert_eq!(reused(&report), (stages(&[("correspondence", false), ("transfer", false)]), 0));
    assert!(report["warnings"].to_string().contains("damaged"), "{}", report["warnings"]);
    assert_eq!(results(&project, "out"), expected);
    assert_eq!(reused(&run(&project, &[])).1, 12);
}

#[test]
fn a_run_goes_on_where_it_was_killed_and_ends_in_the_same_bytes() {
    let project = gallop();
    run(&project, &["--no-cache", "--out", "expected"]);
    let expected = results(&project, "expected");
    let mut random = Random::new(2);
    let mut kept = 0;
    for kill in 0..12 {
        let mut child = Command::new(assert_cmd::cargo::cargo_bin!("mimesh"))
            .current_dir(project.path(""))
            .env("MIMESH_CACHE", project.cache())
            .args(["run", "p.yaml", "--quiet"])
            .stdout(Stdio::null())
            .spawn()
            .expect("the command runs");
        // Some kills come before the first pose, some after the end; the law holds for all of them.
        std::thread::sleep(Duration::from_secs_f64(random.between(0.0, 1.5)));
        let _ = child.kill();
        child.wait().expect("an end");
        for (name, bytes) in results(&project, "out") {
            if !name.starts_with('.') {
                assert_eq!(Some(&bytes), expected.get(&name), "{name} is whole or not there, after kill {kill}");
            }
        }
        let now = entries(project.cache()).len();
        assert!(now >= kept, "nothing that was done is lost");
        kept = now;
    }
    run(&project, &[]);
    assert_eq!(results(&project, "out"), expected, "and nothing that killed runs have left aside");
}

#[test]
fn two_runs_at_once_share_a_cache() {
    let project = gallop();
    run(&project, &["--no-cache", "--out", "expected"]);
    let expected = results(&project, "expected");
    std::thread::scope(|scope| {
        for folder in ["a", "b", "c"] {
            let (project, expected) = (&project, &expected);
            scope.spawn(move || {
                run(project, &["--out", folder]);
                assert_eq!(results(project, folder), *expected);
            });
        }
    });
    assert_eq!(reused(&run(&project, &[])).1, 12);
}

#[test]
fn a_cache_that_cannot_be_written_is_told_and_no_more() {
    let project = gallop();
    project.write("file", "no folder");
    let report = run(&project, &["--cache", "file"]);
    let warnings = report["warnings"].to_string();
    assert!(warnings.matches("results are not kept").count() == 1 && warnings.contains("--no-cache"), "{warnings}");
    assert_eq!(results(&project, "out").len(), 13);
}

#[test]
fn the_cache_is_shown_bounded_and_cleared() {
    let project = gallop();
    run(&project, &[]);
    let shown = project.mimesh(&["cache"]).out;
    assert!(shown.contains("pose") && shown.contains("12 results"), "{shown}");
    let bytes = || -> u64 {
        let json: Value = serde_json::from_str(&project.mimesh(&["cache", "--json"]).out).expect("JSON");
        json["bytes"].as_u64().expect("bytes")
    };
    assert!(bytes() > 1 << 19, "{}", bytes());
    run(&project, &["--set", "transfer.reweightings=1", "--cache-limit", "1"]);
    assert!(bytes() <= 1 << 20, "{}", bytes());
    assert!(project.mimesh(&["cache", "--clear"]).out.contains("removed"));
    assert_eq!(bytes(), 0);
    assert_eq!(reused(&run(&project, &[])).1, 0);
}

#[test]
fn frames_of_one_motion_are_kept_together() {
    let project = gallop();
    let motion = "type: multi_component, sequence: true";
    project.edit("type: gradient", motion);
    project.edit("correspondence:", "proximity: { type: spanning_tree }\ncorrespondence:");
    let first = run(&project, &[]);
    let expected = results(&project, "out");
    assert_eq!(reused(&run(&project, &[])).1, 12);
    assert_eq!(results(&project, "out"), expected);
    assert_eq!(reused(&first).1, 0);
    // One frame is lost: all of them run, for each begins where the one before ended.
    let frame = entries(&project.cache().join("v1/frame"));
    fs::remove_file(&frame[5]).expect("a frame");
    assert!(project.mimesh(&["plan", "p.yaml"]).out.contains("run 12 of 12"));
    let report = run(&project, &[]);
    assert_eq!(reused(&report), (stages(&[("proximity", true), ("correspondence", true), ("transfer", false)]), 0));
    assert_eq!(results(&project, "out"), expected);
}

#[test]
fn what_metrics_said_is_kept_until_a_pose_the_truth_or_a_metric_changes() {
    let project = Project::new();
    for (pose, by) in [(1, 0.1), (2, 0.2), (10, 1.0)] {
        project.write(&format!("truth-{pose}.obj"), &common::leaning(by));
    }
    project.edit("output:", "truth: truth-{pose}.obj\noutput:");
    let kept = |project: &Project| entries(project.cache()).len();
    let judged = |report: &Value| -> Vec<Value> {
        let of = |pose: &Value| serde_json::json!([pose["metrics"], pose["nothing"], pose["verdict"], pose["figures"]]);
        report["poses"].as_array().expect("poses").iter().map(of).collect()
    };
    let first = run(&project, &[]);
    assert!(first["poses"][1]["metrics"]["point_error"]["mean"].as_f64() > Some(0.0));
    let entries_of_first = kept(&project);
    let second = run(&project, &[]);
    assert_eq!(judged(&first), judged(&second), "what is kept comes back to the last bit");
    assert_eq!((&first["metrics"], kept(&project)), (&second["metrics"], entries_of_first), "nothing was measured");

    // Limits are no part of what is measured.
    let said = project.mimesh(&["run", "p.yaml", "--json", "--set", "gates.point_error=0.001"]);
    assert_eq!(said.status, 3, "{}", said.err);
    assert_eq!(kept(&project), entries_of_first);

    project.write("truth-2.obj", &common::leaning(0.7));
    let third = run(&project, &[]);
    assert_eq!((&judged(&third)[0], &judged(&third)[2]), (&judged(&first)[0], &judged(&first)[2]));
    assert_ne!(judged(&third)[1], judged(&first)[1], "another truth");
    let entries_of_third = kept(&project);
    run(&project, &["--set", "metrics=[{ type: self_intersections }]"]);
    assert_eq!(kept(&project), entries_of_third + 3, "another metric");
    let page = run(&project, &["--set", "output=[\"out/{pose}.obj\", out/r.html]"]);
    assert_eq!(judged(&page), judged(&third), "pictures change no figure");
}
