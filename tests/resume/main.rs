//! Results cached from run to run: taken only where nothing they depend on has changed, and whole whatever happened before.
#![cfg(feature = "bundled")]

#[path = "../common/mod.rs"]
mod common;
mod folders;
mod inputs;
mod kills;
mod reuse;

use std::collections::BTreeMap;

use common::Project;
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
    let output = project.mimesh(&[&["run", "p.yaml", "--json"], more].concat());
    assert_eq!(output.status, 0, "{}", output.stderr);
    output.json()
}

/// The bytes of the results by name. The report is left out, for it holds times.
fn results(project: &Project, folder: &str) -> BTreeMap<String, Vec<u8>> {
    let names = project.names(folder).into_iter().filter(|name| name != "run.json");
    names.map(|name| (name.clone(), project.bytes(&format!("{folder}/{name}")))).collect()
}

/// For each stage whether its result came from the cache, and how many poses did.
fn reused(report: &Value) -> (Vec<(String, bool)>, usize) {
    let is_reused = |value: &Value| value["reused"] == true;
    let stages = report["stages"].as_array().expect("stages").iter().filter(|stage| stage.get("type").is_some());
    let stages = stages.map(|stage| (stage["stage"].as_str().expect("a name").to_owned(), is_reused(stage))).collect();
    (stages, report["poses"].as_array().expect("poses").iter().filter(|pose| is_reused(pose)).count())
}

fn stages(of: &[(&str, bool)]) -> Vec<(String, bool)> {
    of.iter().map(|(stage, reused)| (stage.to_string(), *reused)).collect()
}

/// The step of a stage in `mimesh plan p.yaml`: what is done with it, and why.
#[track_caller]
fn planned(project: &Project, stage: &str, more: &[&str]) -> (String, String) {
    let plan = project.mimesh(&[&["plan", "p.yaml", "--json"], more].concat()).json();
    let step = plan["steps"].as_array().expect("steps").iter().find(|step| step["stage"] == stage);
    let text = |key: &str| step.expect(stage)[key].as_str().expect(key).to_owned();
    (text("action"), text("why"))
}
