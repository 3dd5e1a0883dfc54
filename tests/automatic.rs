//! What a pipeline leaves open is chosen by the meshes, told, and comes out as if it had been named.
#![cfg(feature = "bundled")]

mod common;

use common::{PIPELINE, Project, animals, arm, diagnostics};
use serde_json::{Value, json};

/// The choices of a report, `slot chosen`.
fn chosen(report: &Value) -> Vec<String> {
    let all = report["choices"].as_array().cloned().unwrap_or_default();
    let text = |choice: &Value, key: &str| choice[key].as_str().expect("a text").to_owned();
    all.iter().map(|choice| format!("{} {}", text(choice, "stage"), text(choice, "chosen"))).collect()
}

/// The choices for `pipeline` without a run.
#[track_caller]
fn checked(project: &Project, pipeline: &str) -> Vec<String> {
    project.write("p.yaml", pipeline);
    let output = project.mimesh(&["check", "p.yaml", "--json"]);
    assert_eq!(output.status, 0, "{}{}", output.stdout, output.stderr);
    chosen(&output.json())
}

/// A pipeline of two made animals with `more` lines.
fn animals_with(target: &str, more: &str) -> String {
    format!(
        "source: {{ generator: {{ type: quadruped, frames: 1, resolution: 30 }} }}\n\
         target: {{ generator: {{ type: quadruped, frames: 1, resolution: 30{target} }} }}\noutput: out/x.glb\n{more}"
    )
}

/// The stages that a run reports, `stage (type)`.
fn stages(report: &Value) -> Vec<String> {
    let all = report["stages"].as_array().expect("stages");
    let text = |stage: &Value, key: &str| stage[key].as_str().unwrap_or_default().to_owned();
    all.iter().map(|stage| format!("{} ({})", text(stage, "stage"), text(stage, "type"))).collect()
}

#[test]
fn source_target_and_output_make_a_pipeline() {
    let project = Project::new();
    arm::write(&project);
    project.write("p.yaml", "source: { rest: arm.gltf }\ntarget: { rest: arm.gltf }\noutput: out/arm.glb\n");
    let output = project.mimesh(&["run", "p.yaml"]);
    assert!([0, 3].contains(&output.status), "{}", output.stderr);
    assert!(output.stdout.contains("chosen by the meshes\n  source.poses    clip Bend: "), "{}", output.stdout);
    let report = common::json(&project.read("out/run.json"));
    assert_eq!(chosen(&report), ["source.poses clip Bend", "correspondence identity", "transfer gradient"]);
    assert_eq!(report["settings"]["source"]["poses"], json!({ "clip": ["Bend"] }));
    // Named, the stages give the same bytes, and nothing was chosen.
    let named = "source: { rest: arm.gltf, poses: { clip: Bend } }\ntarget: { rest: arm.gltf }\n\
                 correspondence: { type: identity }\ntransfer: { type: gradient }\noutput: named/arm.glb\n";
    project.write("p.yaml", named);
    project.mimesh(&["run", "p.yaml", "--no-cache"]);
    assert!(project.bytes("out/arm.glb") == project.bytes("named/arm.glb"), "the results differ");
    let report = common::json(&project.read("named/run.json"));
    assert!(report.get("choices").is_none(), "{}", report["choices"]);
}

#[test]
fn the_correspondence_is_chosen_by_the_meshes() {
    let project = Project::new();
    let correspondence = |target: &str| {
        let all = checked(&project, &animals_with(target, ""));
        all.into_iter().find_map(|choice| choice.strip_prefix("correspondence ").map(str::to_owned)).expect("a choice")
    };
    assert_eq!(correspondence(""), "identity", "the same mesh");
    assert_eq!(correspondence(", size: 100"), "identity", "the same mesh in another unit");
    assert_eq!(correspondence(", seed: 1"), "nearest", "other triangles on the same horse");
    assert_eq!(correspondence(", proportions: camel"), "nonrigid_fit", "another animal");
    assert_eq!(correspondence(", seed: 1, size: 100"), "nonrigid_fit", "elsewhere, as far as anyone knows");
}

#[test]
fn a_target_of_parts_gets_links_and_a_method_for_parts() {
    let project = Project::new();
    let plates = ", proportions: camel, made_of: plates, pieces: 20";
    assert_eq!(
        checked(&project, &animals_with(plates, "markers: { type: extremities }\n")),
        ["proximity spanning_tree", "correspondence nonrigid_fit", "transfer multi_component"]
    );
    // Named stages get what they need as well, and no more.
    let named = "correspondence: { type: nonrigid_fit }\ntransfer: { type: multi_component }\n";
    assert_eq!(checked(&project, &animals_with(plates, named)), ["markers names", "proximity spanning_tree"]);
    assert_eq!(checked(&project, &animals_with(", proportions: camel", named)), ["markers names"]);
}

#[test]
fn markers_are_equal_names_where_they_do_else_found_by_shape() {
    let project = Project::new();
    let camel = ", proportions: camel";
    assert_eq!(
        checked(&project, &animals_with(camel, "markers: auto\n")),
        ["markers names", "correspondence nonrigid_fit", "transfer gradient"]
    );
    animals::write(&project, "horse", json!({ "frames": 1 }));
    animals::write(&project, "camel", json!({ "proportions": "camel", "seed": 1 }));
    let files = "source: { rest: horse.obj, poses: 'horse-?.obj' }\ntarget: { rest: camel.obj }\noutput: out/x.glb\n";
    assert_eq!(
        checked(&project, &files.replace("horse-?", "horse-*")),
        ["markers extremities", "correspondence nonrigid_fit", "transfer gradient"]
    );
}

#[test]
fn nothing_is_an_answer_too() {
    let project = Project::new();
    let camel = ", proportions: camel";
    project.write("p.yaml", &animals_with(camel, "markers: ~\n"));
    let found = diagnostics(&project, &[]);
    assert!(found[0].ends_with("nonrigid_fit needs at least 3 markers, there are none"), "{found:?}");
    project.write("p.yaml", &animals_with(camel, "transfer: ~\n"));
    assert_eq!(diagnostics(&project, &[]), ["p.yaml:4:11: a run needs a transfer, found none"]);
    let loose = animals_with(", made_of: boxes", "transfer: { type: multi_component }\nproximity: ~\n");
    project.write("p.yaml", &loose);
    let found = diagnostics(&project, &[]);
    assert!(found.iter().any(|one| one.contains("nothing says how they lie to each other")), "{found:?}");
}

#[test]
fn a_transfer_by_handles_fits_nothing() {
    let project = Project::new();
    let handles = "transfer: { type: biharmonic, weights: { type: biharmonic } }\n";
    let pipeline = animals_with(", proportions: camel", handles);
    assert_eq!(checked(&project, &pipeline), ["markers names"]);
    let plan = project.mimesh(&["plan", "p.yaml"]);
    assert!(!plan.stdout.contains("correspondence"), "{}", plan.stdout);
    assert!(plan.stdout.contains("chosen by the meshes\n  markers  names: "), "{}", plan.stdout);
    let output = project.mimesh(&["run", "p.yaml", "--json"]);
    assert_eq!(output.status, 0, "{}", output.stderr);
    let ran = stages(&output.json());
    assert!(!ran.iter().any(|stage| stage.starts_with("correspondence")), "{ran:?}");
    // A metric of the map that the pipeline names asks for one.
    let asked = pipeline + "metrics: [{ type: map_tears }]\n";
    assert_eq!(checked(&project, &asked), ["markers names", "correspondence nonrigid_fit"]);
    assert!(project.mimesh(&["plan", "p.yaml"]).stdout.contains("correspondence (nonrigid_fit)  run"));
}

#[test]
fn handles_without_markers_get_landmarks() {
    let project = Project::new();
    animals::write(&project, "horse", json!({ "frames": 1 }));
    animals::write(&project, "camel", json!({ "proportions": "camel", "seed": 1 }));
    let pipeline = "source: { rest: horse.obj, poses: 'horse-*.obj' }\ntarget: { rest: camel.obj }\noutput: out/x.glb\n\
                    transfer: { type: biharmonic, weights: { type: biharmonic } }\n";
    assert_eq!(checked(&project, pipeline), ["markers extremities"]);
    let output = project.mimesh(&["run", "p.yaml", "--json"]);
    assert_eq!(output.status, 0, "{}", output.stderr);
    assert!(output.json()["markers"].as_u64() >= Some(4), "{}", output.json()["markers"]);
}

#[test]
fn check_and_plan_tell_choices_and_compute_none_of_them() {
    let project = Project::new();
    let pipeline = animals_with(", proportions: camel", "markers: { type: extremities }\n");
    project.write("p.yaml", &pipeline);
    let check = project.mimesh(&["check", "p.yaml"]);
    let expected = "chosen by the meshes\n  correspondence  nonrigid_fit: the meshes differ in triangles and in shape\n  \
                    transfer        gradient: the target is one connected surface\n";
    assert!(check.stdout.ends_with(expected), "{}", check.stdout);
    let plan = project.mimesh(&["plan", "p.yaml"]);
    assert!(
        plan.stdout.contains("landmarks (extremities)        run: ") && plan.stdout.ends_with(expected),
        "{}",
        plan.stdout
    );
    let plan = project.mimesh(&["plan", "p.yaml", "--json"]).json();
    assert_eq!(chosen(&plan), ["correspondence nonrigid_fit", "transfer gradient"]);
}

#[test]
fn choices_of_several_runs_are_told_run_by_run() {
    let project = Project::new();
    let targets = "targets: { same: { rest: rest.obj }, other: { rest: target.obj, transfer: { type: gradient } } }";
    let text = common::with_targets(targets).replace("transfer: { type: copy_displacement }\n", "");
    project.write("p.yaml", &text);
    let output = project.mimesh(&["check", "p.yaml"]);
    assert!(output.stdout.contains("same: chosen by the meshes\n  transfer  gradient"), "{}", output.stdout);
    assert!(!output.stdout.contains("other: chosen"), "{}", output.stdout);
    assert_eq!(project.mimesh(&["run", "p.yaml", "--save", "full.yaml"]).status, 2, "one file holds one run");
    assert!(!project.has("full.yaml"));
}

#[test]
fn a_file_with_all_choices_runs_to_the_same_bytes() {
    let project = Project::new();
    arm::write(&project);
    let text = "source: { rest: arm.gltf }\ntarget: { rest: arm.gltf }\noutput: [ 'out/{pose}.obj', out/arm.glb ]\n";
    project.write("in/p.yaml", &text.replace("arm.gltf", "../arm.gltf"));
    let output = project.mimesh(&["run", "in/p.yaml", "--save", "saved/full.yaml"]);
    assert!([0, 3].contains(&output.status), "{}", output.stderr);
    let saved = project.read("saved/full.yaml");
    for expected in ["rest: ../arm.gltf, poses: { clip: Bend }", "{ type: identity }", "\"../in/out/{pose}.obj\""] {
        assert!(saved.contains(expected), "{expected} in {saved}");
    }
    let again = project.mimesh(&["run", "saved/full.yaml", "--no-cache", "--out", "again", "--json"]);
    assert_eq!(chosen(&again.json()), [""; 0], "nothing is left to choose");
    let names = project.names("again");
    assert!(names.len() > 20, "{names:?}");
    for name in names.iter().filter(|name| *name != "run.json") {
        assert!(project.bytes(&format!("again/{name}")) == project.bytes(&format!("in/out/{name}")), "{name} differs");
    }
    let taken = project.mimesh(&["run", "in/p.yaml", "--save", "saved/full.yaml"]);
    assert_eq!(taken.status, 73);
    assert!(taken.stderr.contains("--save saved/full.yaml: exists already"), "{}", taken.stderr);
}

#[test]
fn words_that_mean_nothing_are_refused() {
    let project = Project::new();
    project.write("p.yaml", &PIPELINE.replace("{ type: identity }", "automatic"));
    let found = diagnostics(&project, &[]);
    assert!(
        found[0].starts_with("p.yaml:3:17: `correspondence`: expected a mapping that begins with `type`"),
        "{found:?}"
    );
}
