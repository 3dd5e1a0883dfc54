//! `--profile`: the table and the trace of a run, and that nothing else changes.
#![cfg(feature = "bundled")]

mod common;

use std::collections::BTreeMap;

use common::{Project, json};
use serde_json::Value;

/// A walk of two made animals, with every kind of step: markers are found, parts linked, poses measured and drawn.
const ANIMALS: &str = "\
source: { generator: { type: quadruped, resolution: 20, frames: 5 } }
target: { generator: { type: quadruped, proportions: camel, resolution: 22, frames: 5, seed: 1, made_of: plates, pieces: 20 } }
output: [ \"out/{pose}.obj\", out/all.glb, out/report.html ]
";

/// A span of a trace.
#[derive(Debug)]
struct Slice {
    name: String,
    thread: u64,
    start: f64,
    end: f64,
}

/// The spans of a trace, in the order of the file.
fn slices(trace: &Value) -> Vec<Slice> {
    let events = trace["traceEvents"].as_array().expect("events");
    let slice = |event: &Value| {
        let number = |key: &str| event[key].as_f64().unwrap_or_else(|| panic!("{key} in {event}"));
        let (name, thread) =
            (event["name"].as_str().expect("a name").to_owned(), event["tid"].as_u64().expect("a thread"));
        Slice { name, thread, start: number("ts"), end: number("ts") + number("dur") }
    };
    events.iter().filter(|event| event["ph"] == "X").map(slice).collect()
}

/// The rows of the table in `text`: depth, label and what follows.
fn rows(text: &str) -> Vec<(usize, String, Vec<String>)> {
    let table = text.split("\nprofile (").nth(1).unwrap_or_else(|| panic!("no profile in {text}"));
    let row = |line: &str| {
        // A label may have single blanks, columns are two or more apart.
        let cells: Vec<String> =
            line.trim().split("  ").map(str::trim).filter(|cell| !cell.is_empty()).map(str::to_owned).collect();
        let depth = (line.len() - line.trim_start().len()) / 2 - 1;
        (depth, cells[0].clone(), cells[1..].to_vec())
    };
    table.lines().skip(2).take_while(|line| !line.starts_with("  trace: ")).map(row).collect()
}

fn seconds(cell: &str) -> f64 {
    let words: Vec<f64> = cell.split(' ').filter_map(|word| word.parse().ok()).collect();
    if cell.contains("min") { 60.0 * words[0] + words[1] } else { words[0] }
}

#[test]
fn the_table_has_the_stages_of_the_pipeline_and_agrees_with_the_time_of_the_run() {
    let project = Project::new();
    project.write("p.yaml", ANIMALS);
    let output = project.mimesh(&["run", "p.yaml", "--profile", "--no-cache"]);
    assert_eq!(output.status, 0, "{}", output.stderr);
    let rows = rows(&output.stdout);
    let report = json(&project.read("out/run.json"));
    let find = |label: &str| rows.iter().find(|row| row.1 == label).unwrap_or_else(|| panic!("{label} in {rows:#?}"));
    // Every stage that the report has, named alike, once and with the same time.
    for stage in report["stages"].as_array().unwrap() {
        let name = stage["type"].as_str().map_or_else(String::new, |name| format!(" ({name})"));
        let label = format!("{}{name}", stage["stage"].as_str().unwrap());
        let (_, _, cells) = find(&label);
        assert_eq!(cells[0], "1", "{label}");
        // A machine under load may halt between the two clocks. The report takes the proximity out of the reading, and ends before the last files are written.
        let difference = seconds(&cells[1]) - stage["seconds"].as_f64().unwrap();
        let is_framed = ["reading", "writing"].contains(&&*label);
        let most = 0.1 + 0.25 * stage["seconds"].as_f64().unwrap();
        assert!(difference > -most && (is_framed || difference < most), "{label}: {cells:?} and {stage}");
    }
    // All poses are counted at each of their steps.
    let poses = report["poses"].as_array().unwrap().len();
    for label in ["pose", "read", "measure", "write", "collect", "result"] {
        let count: usize = rows.iter().filter(|row| row.1 == label).map(|row| row.2[0].parse::<usize>().unwrap()).sum();
        assert_eq!(count, poses, "{label} in {rows:#?}");
    }
    // The stages of a run go one after the other: together they are nearly all of it, and not more.
    let whole = seconds(&find("all").2[1]);
    let direct: f64 = rows.iter().filter(|row| row.0 == 1).map(|row| seconds(&row.2[1])).sum();
    assert!((0.8 * whole..=whole + 0.02 * rows.len() as f64).contains(&direct), "{direct} of {whole} in {rows:#?}");
    let run = rows.iter().position(|row| row.1 == "run").expect("the run");
    let below = rows[run + 1..].iter().take_while(|row| row.0 > 1).filter(|row| row.0 == 2);
    let below: f64 = below.map(|row| seconds(&row.2[1])).sum();
    let of_run = seconds(&rows[run].2[1]);
    assert!((0.8 * of_run..=of_run + 0.1).contains(&below), "{below} of {of_run} in {rows:#?}");
}

#[test]
fn the_trace_is_json_whose_spans_nest_on_each_thread() {
    let project = Project::new();
    project.write("p.yaml", ANIMALS);
    for threads in ["1", "3"] {
        let output = project.mimesh(&["run", "p.yaml", "--profile=trace.json", "--no-cache", "--threads", threads]);
        assert_eq!(output.status, 0, "{}", output.stderr);
        assert!(output.stdout.contains("trace: trace.json"), "{}", output.stdout);
        let trace = json(&project.read("trace.json"));
        let names = trace["traceEvents"].as_array().unwrap().iter().filter(|event| event["name"] == "thread_name");
        let names: Vec<&str> = names.map(|event| event["args"]["name"].as_str().unwrap()).collect();
        assert!(names.contains(&"main") && names.iter().any(|name| name.starts_with("worker ")), "{names:?}");
        let mut open: BTreeMap<u64, Vec<Slice>> = BTreeMap::new();
        let mut count = 0;
        for slice in slices(&trace) {
            count += 1;
            let above = open.entry(slice.thread).or_default();
            // To the nanosecond, in microseconds.
            while above.last().is_some_and(|last| last.end <= slice.start + 1e-3) {
                above.pop();
            }
            if let Some(last) = above.last() {
                assert!(slice.start >= last.start - 1e-3 && slice.end <= last.end + 1e-3, "{slice:?} and {last:?}");
            }
            above.push(slice);
        }
        assert!(count > 100, "{count} spans");
    }
}

#[test]
fn results_are_the_same_with_a_profile() {
    let project = Project::new();
    project.write("p.yaml", ANIMALS);
    assert_eq!(project.mimesh(&["run", "p.yaml", "--no-cache", "--out", "without"]).status, 0);
    let output = project.mimesh(&["run", "p.yaml", "--no-cache", "--out", "with", "--profile"]);
    assert_eq!(output.status, 0, "{}", output.stderr);
    let mut names = project.names("without");
    for name in names.iter().filter(|name| name.ends_with(".obj") || name.ends_with(".glb")) {
        assert!(project.bytes(&format!("without/{name}")) == project.bytes(&format!("with/{name}")), "{name} differs");
    }
    names.push("profile.json".into());
    names.sort();
    let mut with = project.names("with");
    with.sort();
    assert_eq!(with, names);
}

#[test]
fn only_a_trace_of_an_earlier_run_is_replaced() {
    let project = Project::new();
    for _ in 0..2 {
        assert_eq!(project.mimesh(&["run", "p.yaml", "--profile=trace.json", "--quiet"]).status, 0);
    }
    project.write("notes.json", "{}");
    let output = project.mimesh(&["run", "p.yaml", "--profile=notes.json"]);
    assert_eq!(
        (output.status, output.stderr.as_str()),
        (
            73,
            "error: --profile notes.json: is there already, and is no trace of mimesh\n  hint: only traces of earlier runs are \
             replaced; choose another name\n"
        )
    );
    assert_eq!(project.read("notes.json"), "{}");
    project.write("out/profile.json", "[]");
    assert_eq!(project.mimesh(&["run", "p.yaml", "--profile"]).status, 73);
    assert_eq!(project.mimesh(&["run", "p.yaml", "--profile=trace.txt"]).status, 2);
    assert_eq!(project.mimesh(&["run", "p.yaml", "--profile=out/run.json"]).status, 73);
    // A value must be joined to the option, or a pipeline after it would be overwritten.
    assert_eq!(project.mimesh(&["run", "--profile", "p.yaml", "--quiet", "--out", "other"]).status, 0);
    assert!(project.has("other/profile.json"));
}

#[test]
fn stdout_has_json_only_and_a_run_that_fails_leaves_a_trace() {
    let project = Project::new();
    let output = project.mimesh(&["run", "p.yaml", "--json", "--profile=trace.json"]);
    assert_eq!(output.status, 0);
    assert_eq!(output.json(), json(&project.read("out/run.json")));
    assert!(output.stderr.contains("profile (times"), "{}", output.stderr);
    let quiet = project.mimesh(&["run", "p.yaml", "--quiet", "--profile=trace.json"]);
    assert_eq!((quiet.stderr.as_str(), quiet.stdout.as_str()), ("", ""));
    // As many vertices as the rest has, which is all that is looked at before.
    for pose in ["pose-1.obj", "pose-2.obj", "pose-10.obj"] {
        project.write(pose, &"v 0 0 none\n".repeat(8));
    }
    assert_eq!(project.mimesh(&["run", "p.yaml", "--profile=failed.json"]).status, 65);
    assert!(slices(&json(&project.read("failed.json"))).iter().any(|slice| slice.name == "read"));
}

#[test]
fn several_runs_share_a_trace_beside_them() {
    let project = Project::new();
    project.write("p.yaml", &common::with_targets("targets: { a: { rest: target.obj }, b: { rest: target.obj } }"));
    let output = project.mimesh(&["run", "p.yaml", "--profile"]);
    assert_eq!(output.status, 0, "{}", output.stderr);
    let labels: Vec<String> = rows(&output.stdout).into_iter().filter(|row| row.0 == 1).map(|row| row.1).collect();
    assert_eq!(labels, ["reading", "run (a)", "run (b)"]);
    assert!(project.has("out/profile.json"));
}
