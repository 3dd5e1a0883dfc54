//! Poses that are missing, and poses that fail.

use std::fs;

use crate::{
    GALLOP, assert_same,
    common::{Project, cache_entries},
    mimesh, project,
};

/// Poses 1, 2 and 10, as files a pose and as one of all.
const POSES: &str = "\
source: { rest: rest.obj, poses: pose-*.obj }
target: { rest: target.obj }
correspondence: { type: identity }
transfer: { type: copy_displacement }
output: [ 'out/{pose}.obj', out/all.glb ]
";

#[test]
fn a_merge_names_what_is_missing_with_the_command_that_computes_it_and_writes_nothing() {
    let split = project(GALLOP);
    mimesh(&split, "run", &["--frames", "0-2,6-7", "--set", "transfer.reweightings=2"], 0);
    let before = split.names("out");
    let refused = mimesh(&split, "merge", &["--set", "transfer.reweightings=2"], 75);
    let expected = "error: p.yaml: 7 of 12 poses not computed: 3-5,8-11\n  hint: compute them first: \
                    `mimesh run p.yaml --frames 3-5,8-11 --set transfer.reweightings=2`\n";
    assert_eq!((refused.stdout.as_str(), refused.stderr.as_str()), ("", expected));
    assert_eq!(split.names("out"), before);
    // Of other settings nothing is there.
    assert!(mimesh(&split, "merge", &[], 75).stderr.contains("12 of 12 poses not computed: 0-11\n"));
    // The command that is named does it.
    mimesh(&split, "run", &["--frames", "3-5,8-11", "--set", "transfer.reweightings=2"], 0);
    mimesh(&split, "merge", &["--set", "transfer.reweightings=2"], 0);
    assert!(split.has("out/camel.glb"));
}

#[test]
fn a_merge_needs_the_cache() {
    let refused = mimesh(&project(POSES), "merge", &["--no-cache"], 2);
    assert!(refused.stderr.contains("--no-cache: `mimesh merge` works with what is cached"), "{}", refused.stderr);
}

#[test]
fn a_pose_that_fails_in_its_part_fails_in_the_merge_as_in_a_whole_run() {
    let bad = |project: &Project| project.write("pose-2.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let whole = project(POSES);
    bad(&whole);
    let of_whole = mimesh(&whole, "run", &["--quiet"], 4);
    let split = project(POSES);
    bad(&split);
    // The only pose of its part.
    let part = mimesh(&split, "run", &["--frames", "1", "--quiet"], 4);
    assert_eq!(part.stderr, of_whole.stderr);
    assert_eq!(mimesh(&split, "run", &["--frames", "1", "--json"], 4).json()["status"], "partly");
    mimesh(&split, "merge", &[], 75);
    mimesh(&split, "run", &["--frames", "0,2"], 0);
    let merged = mimesh(&split, "merge", &["--quiet"], 4);
    assert_eq!(merged.stderr, of_whole.stderr, "the same is told");
    assert_same(&split, &whole);
    // Mended, it is another pose.
    split.write("pose-2.obj", &crate::common::leaning(0.2));
    mimesh(&split, "merge", &[], 75);
    mimesh(&split, "run", &["--frames", "1"], 0);
    mimesh(&split, "merge", &[], 0);
}

#[test]
fn where_all_poses_fail_the_merge_ends_as_a_whole_run_does() {
    let bad = |project: &Project| {
        for pose in ["pose-1.obj", "pose-2.obj", "pose-10.obj"] {
            // As many vertices as the rest, so that only reading finds the fault.
            project.write(pose, &crate::common::leaning(0.1).replace("v 0 0 0\n", "v 0 0 nan\n"));
        }
    };
    let (whole, split) = (project(POSES), project(POSES));
    bad(&whole);
    bad(&split);
    let of_whole = mimesh(&whole, "run", &["--quiet"], 65);
    mimesh(&split, "run", &["--shard", "0/1"], 4);
    let merged = mimesh(&split, "merge", &["--quiet"], 65);
    assert_eq!(merged.stderr, of_whole.stderr);
    assert!(!split.has("out/all.glb"));
}

#[test]
fn a_damaged_result_is_computed_again_and_never_merged() {
    let split = project(POSES);
    mimesh(&split, "run", &["--shard", "0/1"], 0);
    let path = cache_entries(&split.cache().join("v1/pose")).into_iter().next().expect("a pose");
    let mut bytes = fs::read(&path).expect("an entry");
    *bytes.last_mut().expect("bytes") ^= 1;
    fs::write(&path, bytes).expect("a damaged entry");
    let refused = mimesh(&split, "merge", &[], 75);
    assert!(refused.stderr.contains("its cached result was damaged, and is removed"), "{}", refused.stderr);
    assert!(!split.has("out/all.glb"));
    assert!(mimesh(&split, "merge", &[], 75).stderr.contains("1 of 3 poses not computed"));
    mimesh(&split, "run", &["--shard", "0/1"], 0);
    mimesh(&split, "merge", &[], 0);
    let whole = project(POSES);
    mimesh(&whole, "run", &[], 0);
    assert_same(&split, &whole);
}
