//! Parts and their merge give the bytes of a whole run.

use std::process::{Child, Stdio};

use serde_json::Value;

use crate::{
    FRAMES, GALLOP, assert_same,
    common::{Project, cache_entries, wait_for},
    mimesh, project, report, results,
};

fn whole(pipeline: &str) -> Project {
    let whole = project(pipeline);
    mimesh(&whole, "run", &[], 0);
    whole
}

#[test]
fn any_number_of_shards_in_any_order_gives_the_bytes_of_a_whole_run() {
    let whole = whole(GALLOP);
    assert_eq!(results(&whole).len(), FRAMES + 3);
    for shards in [1, 2, 3, 7] {
        let split = project(GALLOP);
        // Neither forwards nor backwards.
        let mut order: Vec<usize> = (0..shards).collect();
        order.sort_by_key(|shard| (shard * 5) % 7);
        for shard in order {
            let one = mimesh(&split, "run", &["--shard", &format!("{shard}/{shards}"), "--json"], 0).json();
            let poses = one["poses"].as_array().expect("poses");
            assert_eq!(poses.len(), one["part"]["poses"].as_u64().expect("a number") as usize);
            assert!((poses.len() as i64 - (FRAMES / shards) as i64).abs() <= 1, "{poses:?}");
            assert!(poses.iter().all(|pose| pose.get("reused").is_none()), "each pose is computed once");
        }
        assert_eq!(results(&split).len(), FRAMES, "files of one pose each, and no other");
        assert!(!split.has("out/run.json"));
        let merged = mimesh(&split, "merge", &["--json"], 0).json();
        assert!(merged["poses"].as_array().expect("poses").iter().all(|pose| pose["reused"] == true));
        assert_same(&split, &whole);
    }
}

#[test]
fn a_part_writes_the_files_of_its_poses_as_a_whole_run_has_them() {
    let whole = whole(GALLOP);
    let split = project(GALLOP);
    let output = mimesh(&split, "run", &["--frames", "1-3,5,7-11:2"], 0);
    let told = "`mimesh merge p.yaml` writes out/camel.glb and 3 more when all poses are computed";
    assert!(output.stderr.contains(told), "{}", output.stderr);
    assert!(output.stdout.contains("frames 1-3,5,7,9,11 of 12 poses"), "{}", output.stdout);
    let expected = results(&whole);
    let names = split.names("out");
    let all: Vec<&String> = expected.keys().filter(|name| name.ends_with(".obj")).collect();
    let frames = [1, 2, 3, 5, 7, 9, 11];
    assert_eq!(names, frames.map(|frame| all[frame].clone()), "names tell the place in the whole");
    for name in &names {
        assert!(split.bytes(&format!("out/{name}")) == expected[name], "{name}");
    }
    // The poses that are there are not computed again, and the rest completes the run.
    let rest = mimesh(&split, "run", &["--frames", "0-11", "--json"], 0).json();
    let reused = rest["poses"].as_array().expect("poses").iter().filter(|pose| pose["reused"] == true).count();
    assert_eq!(reused, frames.len());
    mimesh(&split, "merge", &[], 0);
    assert_same(&split, &whole);
}

#[test]
fn the_report_of_a_part_has_its_poses_with_their_measurements() {
    let whole = whole(GALLOP);
    let split = project(GALLOP);
    let part = mimesh(&split, "run", &["--frames", "4-7", "--json"], 0).json();
    assert_eq!(part["part"], serde_json::json!({ "frames": "4-7", "poses": 4, "of": 12 }));
    assert_eq!(part["outputs"].as_array().expect("files").len(), 4);
    let of = |report: &Value, i: usize| report["poses"][i].clone();
    let expected = report(&whole);
    for (i, frame) in (4..8).enumerate() {
        let (found, expected) = (of(&part, i), of(&expected, frame));
        assert_eq!(found["name"], expected["name"]);
        for metric in ["edge_stretch", "volume"] {
            assert_eq!(found["metrics"][metric], expected["metrics"][metric], "{metric} of {frame}");
        }
        // A frame is measured with the two before it, which the first two of a part lack.
        assert_eq!(found["metrics"]["jitter"] == expected["metrics"]["jitter"], frame >= 6, "jitter of {frame}");
    }
}

/// Starts a part.
fn start(project: &Project, part: &[&str]) -> Child {
    let mut command = project.command(&[&["run", "p.yaml", "--quiet"], part].concat());
    command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().expect("the command runs")
}

#[test]
fn shards_at_once_in_one_cache_give_the_bytes_of_a_whole_run() {
    let whole = whole(GALLOP);
    let split = project(GALLOP);
    let both = ["0/2", "1/2"].map(|shard| start(&split, &["--shard", shard]));
    for child in both {
        let output = child.wait_with_output().expect("an end");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    }
    mimesh(&split, "merge", &[], 0);
    assert_same(&split, &whole);
}

#[test]
fn a_shard_that_was_killed_goes_on_where_it_was() {
    let pipeline = GALLOP.replace("gait: gallop, resolution: 20", "gait: gallop, resolution: 20, frames: 48");
    let whole = whole(&pipeline);
    let split = project(&pipeline);
    let poses = split.cache().join("v1/pose");
    let mut child = start(&split, &["--shard", "0/2"]);
    wait_for("a cached pose", || !cache_entries(&poses).is_empty());
    child.kill().expect("a process to kill");
    child.wait().expect("an end");
    mimesh(&split, "merge", &[], 75);
    let again = mimesh(&split, "run", &["--shard", "0/2", "--json"], 0).json();
    let reused = again["poses"].as_array().expect("poses").iter().filter(|pose| pose["reused"] == true).count();
    assert!(reused > 0, "what was done is taken from the cache");
    mimesh(&split, "run", &["--shard", "1/2"], 0);
    mimesh(&split, "merge", &[], 0);
    assert_same(&split, &whole);
}

#[test]
fn pages_and_sheets_show_what_those_of_a_whole_run_show() {
    let pipeline = GALLOP.replace("out/camel.pc2", "out/report.html, out/sheet.png");
    let (whole, split) = (whole(&pipeline), project(&pipeline));
    for shard in ["1/2", "0/2"] {
        mimesh(&split, "run", &["--shard", shard], 0);
    }
    assert!(!split.has("out/report.html") && !split.has("out/sheet.png"));
    mimesh(&split, "merge", &[], 0);
    assert_same(&split, &whole);
    // Times apart, which stand in text, pages have the same pictures and curves.
    let pictures = |project: &Project| -> Vec<String> {
        let page = project.read("out/report.html");
        page.split("base64,").skip(1).map(|rest| rest.split(['"', ')']).next().expect("data").to_owned()).collect()
    };
    assert!(!pictures(&whole).is_empty());
    assert!(pictures(&split) == pictures(&whole), "other pictures");
}

#[test]
fn shapes_that_stand_alone_are_merged_too() {
    let pipeline = "\
source: { rest: rest.obj, poses: pose-*.obj }
target: { rest: target.obj }
correspondence: { type: identity }
transfer: { type: copy_displacement }
output: [ 'out/{pose}.obj', out/all.glb ]
";
    let (whole, split) = (whole(pipeline), project(pipeline));
    // Poses are sorted as people count: 1, 2, 10.
    mimesh(&split, "run", &["--frames", "2"], 0);
    assert_eq!(split.names("out"), ["10.obj"]);
    mimesh(&split, "run", &["--frames", "0,1"], 0);
    let merged = mimesh(&split, "merge", &["--json"], 0).json();
    let names: Vec<_> = merged["poses"].as_array().expect("poses").iter().map(|pose| pose["name"].clone()).collect();
    assert_eq!(names, ["1", "2", "10"]);
    assert_same(&split, &whole);
}

#[test]
fn a_broken_gate_is_the_merges_to_tell() {
    let pipeline = format!("{GALLOP}gates: {{ point_error: 0.000001 }}\n");
    let whole = project(&pipeline);
    mimesh(&whole, "run", &[], 3);
    let split = project(&pipeline);
    for shard in ["0/2", "1/2"] {
        mimesh(&split, "run", &["--shard", shard], 0);
    }
    mimesh(&split, "merge", &[], 3);
    assert_same(&split, &whole);
}
