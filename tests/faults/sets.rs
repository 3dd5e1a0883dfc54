//! An old and a new set of results, told apart byte by byte.

use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
};

use crate::common::{self, Output, PIPELINE, Project, leaning};

/// Poses of the tests.
pub const POSES: usize = 12;

/// The files of a set by their folders and names.
pub type Set = BTreeMap<String, Vec<u8>>;

/// A pipeline with results in two folders.
pub fn project() -> Project {
    let project = Project::new();
    for pose in project.names(".").iter().filter(|name| name.starts_with("pose-")) {
        fs::remove_file(project.path(pose)).expect("a pose");
    }
    project.write("p.yaml", &PIPELINE.replace("out/{pose}.obj", "[out/{pose}.obj, more/{pose}.ply, out/all.glb]"));
    lean(&project, 0.1);
    project
}

/// Makes the poses others, by which the next run makes another set.
pub fn lean(project: &Project, by: f64) {
    for pose in 0..POSES {
        project.write(&format!("pose-{pose:02}.obj"), &leaning(by + 0.01 * pose as f64));
    }
}

/// All files of the folders of results but the report, which holds times.
pub fn set(project: &Project) -> Set {
    let of = |folder: &str| {
        let names = if project.path(folder).is_dir() { project.names(folder) } else { vec![] };
        let files = names.into_iter().map(|name| format!("{folder}/{name}")).collect::<Vec<_>>();
        files
            .into_iter()
            .filter(|name| name != "out/run.json")
            .map(|name| (name.clone(), project.bytes(&name)))
            .collect::<Vec<_>>()
    };
    ["out", "more"].into_iter().flat_map(of).collect()
}

/// The results of a set, without temporary files.
pub fn results(set: &Set) -> Set {
    set.iter()
        .filter(|(name, _)| !name.contains("/.mimesh-"))
        .map(|(name, bytes)| (name.clone(), bytes.clone()))
        .collect()
}

#[track_caller]
pub fn run(project: &Project) -> Output {
    let output = project.mimesh(&["run", "p.yaml", "--no-cache", "--quiet"]);
    assert_eq!(output.status, 0, "{}", output.stderr);
    output
}

/// Checks that the report holds the size and the hash of every result.
#[track_caller]
pub fn assert_report_is_of(project: &Project, set: &Set) {
    let report = common::json(&String::from_utf8(project.bytes("out/run.json")).expect("text"));
    let outputs = report["outputs"].as_array().expect("outputs");
    assert_eq!(outputs.len(), set.len());
    for output in outputs {
        let path = output["path"].as_str().expect("a path");
        let (_, bytes) = set.iter().find(|(name, _)| path.ends_with(name.as_str())).expect("a result");
        assert_eq!(output["blake3"], blake3::hash(bytes).to_hex().as_str(), "{path}");
        assert_eq!(output["bytes"], bytes.len());
    }
}

/// Checks that both sets have the same files with the same bytes, and names those that differ.
#[track_caller]
pub fn assert_same(found: &Set, wanted: &Set, when: &str) {
    let names: BTreeSet<&String> = found.keys().chain(wanted.keys()).collect();
    let differ: Vec<_> = names.into_iter().filter(|name| found.get(*name) != wanted.get(*name)).collect();
    assert!(differ.is_empty(), "{when}: {differ:?} differ");
}

/// The old and the new set; the old one is in place, and the poses are those of the new one.
pub fn old_and_new(project: &Project) -> (Set, Set) {
    lean(project, 0.5);
    run(project);
    let new = set(project);
    lean(project, 0.1);
    run(project);
    let old = set(project);
    assert!(
        old.len() == 2 * POSES + 1 && old.keys().eq(new.keys()) && old.values().zip(new.values()).all(|(a, b)| a != b)
    );
    lean(project, 0.5);
    (old, new)
}

/// Puts the old set in place again.
pub fn put_back(project: &Project, old: &Set) {
    lean(project, 0.1);
    run(project);
    assert_same(&set(project), old, "the run that puts the old set back");
    lean(project, 0.5);
}
