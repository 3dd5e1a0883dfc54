//! Frames of one motion, which depend on those before.

use nalgebra::{Point3, distance};
use serde_json::Value;

use crate::{FRAMES, GALLOP, assert_same, common::Project, mimesh, project, results};

/// A gallop whose frames follow one another.
fn motion() -> String {
    let text = GALLOP.replace("type: gradient", "type: multi_component, sequence: true");
    format!("proximity: {{ type: spanning_tree }}\n{text}")
}

#[test]
fn a_part_of_a_motion_is_refused_before_anything_is_computed() {
    let split = project(&motion());
    for part in [["--frames", "3-5"], ["--frames", "0-5"], ["--shard", "1/2"]] {
        let refused = mimesh(&split, "run", &part, 2);
        assert!(refused.stderr.contains("frames of one motion depend on those before"), "{}", refused.stderr);
        assert!(refused.stderr.contains("hint: run it whole, or begin each part so many frames earlier"));
        assert!(refused.stderr.contains("`--warm N`"), "{}", refused.stderr);
    }
    assert!(!split.cache().join("v1/correspondence").exists() && !split.has("out"));
    let planned = mimesh(&split, "plan", &["--shards", "2"], 2);
    assert!(planned.stderr.contains("`--warm N`"), "{}", planned.stderr);
}

#[test]
fn a_motion_as_one_part_is_exact() {
    let (whole, split) = (project(&motion()), project(&motion()));
    mimesh(&whole, "run", &[], 0);
    mimesh(&split, "run", &["--shard", "0/1"], 0);
    assert!(!split.has("out/camel.glb"));
    mimesh(&split, "merge", &[], 0);
    assert_same(&split, &whole);
}

/// The vertices of an OBJ.
fn vertices(project: &Project, name: &str) -> Vec<Point3<f64>> {
    let text = project.read(name);
    let number = |word: &str| -> f64 { word.parse().expect("a number") };
    let point = |line: &str| Point3::from_slice(&line.split_whitespace().map(number).collect::<Vec<_>>());
    text.lines().filter_map(|line| line.strip_prefix("v ")).map(point).collect()
}

fn largest_distance(a: &[Point3<f64>], b: &[Point3<f64>]) -> f64 {
    a.iter().zip(b).map(|(a, b)| distance(a, b)).fold(0.0, f64::max)
}

/// The warning of a merge about seams.
fn seams(report: &Value) -> Option<String> {
    let warnings = report["warnings"].as_array().expect("warnings").iter().filter_map(Value::as_str);
    warnings.map(str::to_owned).find(|warning| warning.contains("where parts meet"))
}

#[test]
fn warm_parts_are_near_the_whole_and_the_merge_tells_how_near() {
    // While a foot stands, the target is moved as a whole; a part that begins when it stands already takes another place for it.
    let planted = motion().replace("sequence: true", "plants: [ { vertices: [0], frames: [2, 9] } ]");
    let (whole, split) = (project(&planted), project(&planted));
    mimesh(&whole, "run", &[], 0);
    for shard in ["2/3", "0/3", "1/3"] {
        let part = mimesh(&split, "run", &["--shard", shard, "--warm", "2", "--json"], 0).json();
        assert_eq!(part["part"]["warm"], 2);
        assert_eq!(part["poses"].as_array().map(Vec::len), Some(FRAMES / 3));
    }
    // Only the first part is exact, so that without the flag the others are missing.
    let refused = mimesh(&split, "merge", &[], 75);
    assert!(refused.stderr.contains("8 of 12 poses not computed: 4-11"), "{}", refused.stderr);
    assert!(refused.stderr.contains("`mimesh run p.yaml --frames 0-11`"), "{}", refused.stderr);
    assert!(refused.stderr.contains("if its parts were computed after warm frames"), "{}", refused.stderr);
    // Nor is another number of warm frames the same.
    assert!(mimesh(&split, "merge", &["--warm", "3"], 75).stderr.contains("8 of 12 poses not computed"));

    let merged = mimesh(&split, "merge", &["--warm", "2", "--json"], 0).json();
    let told = seams(&merged).expect("a warning");
    assert!(told.contains("computed in 3 parts, each after 2 warm frames"), "{told}");
    let percent = told.split("up to ").nth(1).and_then(|rest| rest.split(" %").next()).expect("a number");
    let percent: f64 = percent.parse().expect("a number");
    let names: Vec<String> = results(&whole).into_keys().filter(|name| name.ends_with(".obj")).collect();
    let diagonal = merged["target"]["diagonal"].as_f64().expect("a number");
    let off = names.iter().map(|name| {
        let name = format!("out/{name}");
        100.0 * largest_distance(&vertices(&split, &name), &vertices(&whole, &name)) / diagonal
    });
    let off: Vec<f64> = off.collect();
    assert_eq!(off[..4], [0.0; 4], "the first part begins with the first frame");
    let worst = off.iter().copied().fold(0.0, f64::max);
    println!("{percent} % told at seams, {worst} % from the whole run at most");
    // The second part sees the foot's first frame, and the third does not. Its frames are all moved alike, as the last warm one shows.
    assert_eq!(off[4..8], [0.0; 4]);
    assert!(worst > 0.1, "{off:?}");
    // What is told has four digits, and files have some more.
    assert!((percent - worst).abs() < 1e-3 * worst, "{told}: {off:?}");

    // A whole run takes none of these results.
    let again = mimesh(&split, "run", &["--json"], 0).json();
    assert!(again["poses"].as_array().expect("poses").iter().all(|pose| pose.get("reused").is_none()));
    assert_same(&split, &whole);
    assert_eq!(seams(&again), None);
    // Exact frames are there now, and are taken.
    assert_eq!(seams(&mimesh(&split, "merge", &["--warm", "2", "--json"], 0).json()), None);
}

#[test]
fn parts_that_begin_with_the_first_frame_by_their_warm_frames_are_exact() {
    let (whole, split) = (project(&motion()), project(&motion()));
    mimesh(&whole, "run", &[], 0);
    for shard in ["1/2", "0/2"] {
        mimesh(&split, "run", &["--shard", shard, "--warm", "100"], 0);
    }
    mimesh(&split, "merge", &[], 0);
    assert_same(&split, &whole);
}

#[test]
fn a_warm_part_again_is_taken_from_the_cache() {
    let split = project(&motion());
    mimesh(&split, "run", &["--frames", "5-7", "--warm", "2"], 0);
    let first = results(&split);
    let again = mimesh(&split, "run", &["--frames", "5-7", "--warm", "2", "--json"], 0).json();
    assert!(again["poses"].as_array().expect("poses").iter().all(|pose| pose["reused"] == true));
    assert_eq!(results(&split), first);
    let missing = mimesh(&split, "merge", &["--warm", "2"], 75);
    assert!(missing.stderr.contains("`mimesh run p.yaml --frames 0-4,8-11 --warm 2`"), "{}", missing.stderr);
}
