//! Runs that are split over processes: parts into one cache, and a merge that writes what a whole run writes.
#![cfg(feature = "bundled")]

#[path = "../common/mod.rs"]
mod common;
mod locks;
mod missing;
mod motions;
mod plans;
mod room;
mod several;
mod split;
mod syntax;
mod usage;

use std::collections::BTreeMap;

use common::{Output, Project};
use serde_json::Value;

/// A gallop of twelve frames, with files a pose and files of all poses.
const GALLOP: &str = "\
source: { generator: { type: quadruped, proportions: horse, gait: gallop, resolution: 20 } }
target: { generator: { type: quadruped, proportions: camel, gait: gallop, resolution: 22, seed: 1 } }
correspondence: { type: nonrigid_fit, steps: 4 }
transfer: { type: gradient }
metrics: [ { type: edge_stretch }, { type: jitter }, { type: volume } ]
keep_correspondence: out/map.json
output: [ 'out/camel-{pose}.obj', out/camel.glb, out/camel.pc2 ]
";

/// The number of frames of [`GALLOP`].
const FRAMES: usize = 12;

/// A project with this pipeline.
fn project(pipeline: &str) -> Project {
    let project = Project::new();
    project.write("p.yaml", pipeline);
    project
}

/// Runs `mimesh COMMAND p.yaml MORE`, which ends with `status`.
#[track_caller]
fn mimesh(project: &Project, command: &str, more: &[&str], status: i32) -> Output {
    let output = project.mimesh(&[&[command, "p.yaml"], more].concat());
    assert_eq!(output.status, status, "{command} {more:?}: {}{}", output.stdout, output.stderr);
    output
}

/// The bytes of the results by name. Reports and pages are left out, for they hold times.
fn results(project: &Project) -> BTreeMap<String, Vec<u8>> {
    let has_times = |name: &String| name.ends_with(".json") && name.starts_with("run") || name.ends_with(".html");
    let names = project.names("out").into_iter().filter(|name| !has_times(name));
    names.map(|name| (name.clone(), project.bytes(&format!("out/{name}")))).collect()
}

/// The report in `out/run.json` without times, what the process used, and what came from the cache.
fn report(project: &Project) -> Value {
    timeless(common::json(&project.read("out/run.json")))
}

fn timeless(value: Value) -> Value {
    const TIMES: [&str; 5] = ["seconds", "cpu_seconds", "process", "reused", "threads"];
    match value {
        Value::Object(entries) => {
            let entries = entries.into_iter().filter(|(key, _)| !TIMES.contains(&key.as_str()));
            // A page shows times, so that its bytes vary.
            let is_page = |entries: &serde_json::Map<String, Value>| {
                entries.get("path").and_then(Value::as_str).is_some_and(|path| path.ends_with(".html"))
            };
            let mut entries: serde_json::Map<_, _> = entries.map(|(key, value)| (key, timeless(value))).collect();
            if is_page(&entries) {
                entries.remove("bytes");
                entries.remove("blake3");
            }
            Value::Object(entries)
        }
        Value::Array(items) => Value::Array(items.into_iter().map(timeless).collect()),
        other => other,
    }
}

/// Checks that `split` has the files and the report of `whole`.
#[track_caller]
fn assert_same(split: &Project, whole: &Project) {
    let (found, expected) = (results(split), results(whole));
    assert_eq!(found.keys().collect::<Vec<_>>(), expected.keys().collect::<Vec<_>>());
    for (name, bytes) in &expected {
        assert!(found[name] == *bytes, "{name} has other bytes");
    }
    assert_eq!(report(split), report(whole));
}
