//! What a run takes from the cache, and what it does again.

use std::{fs, path::PathBuf, time::Instant};

use serde_json::Value;

use crate::{
    common::{self, Project, cache_entries},
    gallop, planned, results, reused, run, stages,
};

#[test]
fn the_same_run_again_does_no_work_and_gives_the_same_bytes() {
    let project = gallop();
    let first = run(&project, &[]);
    assert_eq!(reused(&first), (stages(&[("correspondence", false), ("transfer", false)]), 0));
    let results_of_first = results(&project, "out");
    let plan = project.mimesh(&["plan", "p.yaml"]);
    assert!(plan.stdout.matches("reuse:").count() == 3 && !plan.stdout.contains("run"), "{}", plan.stdout);

    let second = run(&project, &["--threads", "1"]);
    assert_eq!(reused(&second), (stages(&[("correspondence", true), ("transfer", true)]), 12));
    assert_eq!(results(&project, "out"), results_of_first);
    // What stages report is cached with their results.
    let figures =
        |report: &Value| report["stages"].as_array().unwrap().iter().map(|s| s["figures"].clone()).collect::<Vec<_>>();
    assert_eq!(figures(&first), figures(&second));
    assert_eq!(first["metrics"], second["metrics"]);
    let output = project.mimesh(&["run", "p.yaml"]);
    assert!(output.stdout.contains("transfer (gradient): cached by an earlier run"), "{}", output.stdout);
    assert!(output.stdout.contains("12 of 12 cached"), "{}", output.stdout);

    let without = run(&project, &["--no-cache", "--out", "again"]);
    assert_eq!(reused(&without), (stages(&[("correspondence", false), ("transfer", false)]), 0));
    assert_eq!(results(&project, "again"), results_of_first);
}

#[test]
fn a_change_does_again_only_what_depends_on_it() {
    let project = gallop();
    run(&project, &[]);
    let planned = |more: &[&str]| project.mimesh(&[&["plan", "p.yaml"], more].concat()).stdout;

    let transfer = ["--set", "transfer.reweightings=1"];
    let plan = planned(&transfer);
    assert!(plan.contains("reuse: cached") && plan.contains("reweightings is 1, was 5"), "{plan}");
    assert_eq!(reused(&run(&project, &transfer)), (stages(&[("correspondence", true), ("transfer", false)]), 0));
    // Both are cached side by side.
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
fn a_plan_says_what_the_run_will_do_whatever_is_left_of_the_cache() {
    let project = Project::new();
    run(&project, &[]);
    let remove = |kind: &str| fs::remove_dir_all(project.cache().join("v1").join(kind)).expect("cached results");
    let cached = "cached for this transfer and these poses".to_owned();

    // Poses stand alone and are all there, so that only what the transfer reported has to be found again.
    remove("transfer");
    assert_eq!(planned(&project, "poses", &[]), ("reuse".into(), cached.clone()));
    assert_eq!(planned(&project, "transfer", &[]), ("run".into(), "its result is no longer cached".into()));
    assert_eq!(reused(&run(&project, &[])).1, 3);

    // With all poses and their measurements nothing needs the map.
    remove("correspondence");
    assert_eq!(planned(&project, "correspondence", &[]), ("skip".into(), "all poses are cached".into()));
    assert_eq!(reused(&run(&project, &[])), (stages(&[("transfer", true)]), 3));
    assert!(cache_entries(&project.cache().join("v1/correspondence")).is_empty(), "it was skipped as planned");

    // Pictures show more than measurements hold, so that poses are measured again; and a file of the map needs the map.
    for more in [["--set", "output=[out/{pose}.obj, out/r.html]"], ["--set", "keep_correspondence=map.json"]] {
        assert_eq!(planned(&project, "correspondence", &more).0, "run", "{more:?}");
        assert_eq!(planned(&project, "poses", &more), ("reuse".into(), cached.clone()));
        let report = run(&project, &more);
        assert_eq!(reused(&report), (stages(&[("correspondence", false), ("transfer", true)]), 3), "{more:?}");
        remove("correspondence");
    }
}

#[test]
fn the_seconds_of_a_run_are_those_of_one_clock() {
    let project = Project::new();
    project.edit("correspondence:", "proximity: { type: spanning_tree }\ncorrespondence:");
    let started = Instant::now();
    let report = run(&project, &["--no-cache"]);
    let elapsed = started.elapsed().as_secs_f64();
    let seconds = report["seconds"].as_f64().expect("seconds");
    let stages = report["stages"].as_array().expect("stages").iter();
    let sum: f64 = stages.map(|stage| stage["seconds"].as_f64().expect("seconds")).sum();
    // Clocks of stages lie within the whole, apart from the rounding of sums.
    assert!(sum <= seconds + 1e-9 && seconds <= elapsed, "{sum} of {seconds}, {elapsed} outside");
}

#[test]
fn frames_of_one_motion_are_cached_together() {
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
    let frame = cache_entries(&project.cache().join("v1/frame"));
    fs::remove_file(&frame[5]).expect("a frame");
    assert!(project.mimesh(&["plan", "p.yaml"]).stdout.contains("run 12 of 12"));
    let report = run(&project, &[]);
    assert_eq!(reused(&report), (stages(&[("proximity", true), ("correspondence", true), ("transfer", false)]), 0));
    assert_eq!(results(&project, "out"), expected);
}

/// The inodes of the entries of a kind in the cache of a project: an entry that is written again has another one.
#[cfg(unix)]
fn inodes(project: &Project, kind: &str) -> Vec<(PathBuf, u64)> {
    use std::os::unix::fs::MetadataExt;
    let inode = |path: PathBuf| fs::metadata(&path).map(|metadata| (path, metadata.ino())).expect("an entry");
    cache_entries(&project.cache().join("v1").join(kind)).into_iter().map(inode).collect()
}

#[test]
fn metrics_are_cached_until_a_pose_the_truth_or_a_metric_changes() {
    let project = Project::new();
    for (pose, by) in [(1, 0.1), (2, 0.2), (10, 1.0)] {
        project.write(&format!("truth-{pose}.obj"), &common::leaning(by));
    }
    project.edit("output:", "truth: truth-{pose}.obj\noutput:");
    let cached = |project: &Project| cache_entries(project.cache()).len();
    let judged = |report: &Value| -> Vec<Value> {
        let of = |pose: &Value| serde_json::json!([pose["metrics"], pose["nothing"], pose["verdict"], pose["figures"]]);
        report["poses"].as_array().expect("poses").iter().map(of).collect()
    };
    let first = run(&project, &[]);
    assert!(first["poses"][1]["metrics"]["point_error"]["mean"].as_f64() > Some(0.0));
    let entries_of_first = cached(&project);
    #[cfg(unix)]
    let written_by_first = inodes(&project, "metrics");
    let second = run(&project, &[]);
    assert_eq!(judged(&first), judged(&second), "cached metrics come back to the last bit");
    assert_eq!((&first["metrics"], cached(&project)), (&second["metrics"], entries_of_first));
    #[cfg(unix)]
    {
        assert_eq!(written_by_first.len(), 3);
        assert_eq!(inodes(&project, "metrics"), written_by_first, "nothing was measured");
    }

    // Limits are no part of what is measured.
    let output = project.mimesh(&["run", "p.yaml", "--json", "--set", "gates.point_error=0.001"]);
    assert_eq!(output.status, 3, "{}", output.stderr);
    assert_eq!(cached(&project), entries_of_first);

    project.write("truth-2.obj", &common::leaning(0.7));
    let third = run(&project, &[]);
    assert_eq!((&judged(&third)[0], &judged(&third)[2]), (&judged(&first)[0], &judged(&first)[2]));
    assert_ne!(judged(&third)[1], judged(&first)[1], "another truth");
    let entries_of_third = cached(&project);
    run(&project, &["--set", "metrics=[{ type: self_intersections }]"]);
    assert_eq!(cached(&project), entries_of_third + 3, "another metric");
    let page = run(&project, &["--set", "output=[\"out/{pose}.obj\", out/r.html]"]);
    assert_eq!(judged(&page), judged(&third), "pictures change no figure");
}
