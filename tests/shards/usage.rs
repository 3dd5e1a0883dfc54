//! What cannot be split, and how that is told.

use crate::{GALLOP, common::Project, mimesh, project};

/// A pipeline with files of one pose each alone.
const FILES: &str = crate::common::PIPELINE;

#[test]
fn frames_and_shards_that_cannot_be_read_are_usage_errors_with_an_example() {
    let project = Project::new();
    for wrong in ["", "a", "3-1", "-1", "1-", "0-2:0", "1;2"] {
        let refused = mimesh(&project, "run", &["--frames", wrong], 2);
        assert!(refused.stderr.contains("expected frames from 0 as `7`, `0-24`"), "{wrong}: {}", refused.stderr);
    }
    for wrong in ["", "1", "4/4", "-1/4", "0/0", "a/b"] {
        let refused = mimesh(&project, "run", &["--shard", wrong], 2);
        assert!(refused.stderr.contains("e.g. `0/4` to `3/4`"), "{wrong}: {}", refused.stderr);
    }
    let both = mimesh(&project, "run", &["--frames", "1", "--shard", "0/2"], 2);
    assert!(both.stderr.contains("cannot be used with"), "{}", both.stderr);
    assert!(!project.has("out"));
}

#[test]
fn frames_beyond_the_last_name_how_many_there_are() {
    let project = Project::new();
    let refused = mimesh(&project, "run", &["--frames", "1-3"], 2);
    let expected = "error: p.yaml: frame 3 of 3 poses\n  hint: frames count from 0, so that the last is 2\n";
    assert_eq!(refused.stderr, expected);
    assert!(!project.has("out"));
}

#[test]
fn shards_without_poses_end_well_and_say_so() {
    let project = Project::new();
    for shard in 0..5 {
        let named = format!("{shard}/5");
        let output = mimesh(&project, "run", &["--shard", &named], 0);
        let says = output.stdout.contains(&format!("shard {named}, which has none of 3 poses"));
        assert_eq!(says, shard >= 3, "{}", output.stdout);
    }
    let empty = mimesh(&project, "run", &["--shard", "4/5", "--json"], 0).json();
    assert_eq!(empty["part"], serde_json::json!({ "frames": "", "poses": 0, "of": 3, "shard": "4/5" }));
    assert_eq!((&empty["status"], empty["poses"].as_array().map(Vec::len)), (&"done".into(), Some(0)));
    mimesh(&project, "merge", &[], 0);
    assert_eq!(project.names("out"), ["1.obj", "10.obj", "2.obj", "run.json"]);
}

#[test]
fn without_the_cache_a_part_may_write_files_of_one_pose_and_no_more() {
    let files = project(FILES);
    mimesh(&files, "run", &["--frames", "0", "--no-cache"], 0);
    assert_eq!(files.names("out"), ["1.obj"]);
    let cached = mimesh(&files, "run", &["--frames", "0-1", "--warm", "2", "--set", "transfer.type=gradient"], 0);
    let left =
        "`mimesh merge p.yaml --warm 2 --set transfer.type=gradient` writes out/run.json when all poses are computed";
    assert!(cached.stderr.contains(left), "{}", cached.stderr);
    let all = project(GALLOP);
    let refused = mimesh(&all, "run", &["--shard", "0/2", "--no-cache"], 2);
    assert!(refused.stderr.contains("shard 0/2 with --no-cache: `mimesh merge` takes poses from the cache"));
    assert!(refused.stderr.contains("out/camel.glb could never be written"), "{}", refused.stderr);
}

#[test]
fn a_cache_that_cannot_hold_all_poses_is_refused_before_anything_is_computed() {
    let project = project(GALLOP);
    let refused = mimesh(&project, "run", &["--shard", "0/2", "--cache-limit", "0"], 2);
    assert!(refused.stderr.contains("the first would be gone before the last are there"), "{}", refused.stderr);
    let flag = refused.stderr.split("`--cache-limit ").nth(1).and_then(|rest| rest.split('`').next());
    mimesh(&project, "run", &["--shard", "0/2", "--cache-limit", flag.expect("a limit")], 0);
}

#[test]
fn warm_frames_are_for_parts() {
    let refused = mimesh(&Project::new(), "run", &["--warm", "2"], 2);
    assert!(refused.stderr.contains("give a part by `--frames A-B` or `--shard I/N`"), "{}", refused.stderr);
    // Where poses stand alone they change nothing.
    let project = Project::new();
    mimesh(&project, "run", &["--frames", "2", "--warm", "2"], 0);
    mimesh(&project, "run", &["--frames", "0-1", "--warm", "2"], 0);
    mimesh(&project, "merge", &[], 0);
}
