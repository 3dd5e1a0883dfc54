//! Which stage sits in a slot, its ranges and its defaults are known from the schema alone.
#![cfg(feature = "bundled")]

mod common;

use common::{PIPELINE, Project, assert_stderr, diagnostics};

/// [`PIPELINE`] with a transfer of many components.
fn multi_component(settings: &str) -> Project {
    let project = Project::new();
    project.write("m.cons", "4\n0, 0\n1, 1\n2, 2\n4, 4\n");
    let transfer = format!(
        "transfer:\n  type: multi_component\n{settings}proximity: {{ type: spanning_tree }}\nmarkers: m.cons\n"
    );
    project.write("p.yaml", &PIPELINE.replace("transfer: { type: copy_displacement }\n", &transfer));
    project
}

#[test]
fn a_number_in_the_place_of_a_mapping_is_not_taken_for_a_stage() {
    let project = multi_component("");
    assert_eq!(
        diagnostics(&project, &["transfer.term_weights=3"]),
        ["--set transfer.term_weights=3: `term_weights`: expected a mapping of keys, found 3"]
    );
    let renamed = project.mimesh(&["check", "p.yaml", "--set", "transfer.weights=3"]);
    assert_eq!(renamed.status, 78);
    assert!(renamed.stderr.contains("`weights` is now called `term_weights`"), "{}", renamed.stderr);
    assert!(!renamed.stderr.contains("biharmonic"), "{}", renamed.stderr);
}

#[test]
fn a_number_out_of_its_range_is_reported_at_its_own_line() {
    let project = multi_component("  term_weights:\n    gaps: -1\n");
    assert_stderr(
        &project,
        "check",
        78,
        "error: p.yaml:7:11: `gaps`: expected at least 0.000000000001, found -1\n   |\n 7 |     gaps: -1\n   |           ^^",
    );
}

#[test]
fn show_names_the_stages_and_numbers_of_nested_slots() {
    let shown = Project::new().mimesh(&["show", "transfer", "multi_component"]).stdout;
    for expected in ["initial", "term_weights.gaps", "term_weights.prior", "term_weights.smoothness"] {
        assert!(shown.contains(expected), "{expected} in {shown}");
    }
    assert!(!shown.contains("a value"), "{shown}");
}

#[test]
fn earlier_names_are_answered_with_the_present_ones() {
    let project = Project::new();
    project.edit("rest: target.obj", "sample: { type: quadruped }");
    let output = project.mimesh(&["check", "p.yaml"]);
    assert_eq!(output.status, 78);
    assert!(output.stderr.contains("`sample` is now called `generator`"), "{}", output.stderr);
}

#[test]
fn a_slot_may_declare_other_defaults_of_the_stage_in_it() {
    let project = multi_component("  initial: { type: biharmonic }\n");
    let plan = |settings: &[&str]| project.mimesh(&[&["plan", "p.yaml"], settings].concat()).stdout;
    // The default of `biharmonic` itself is `bounded_biharmonic`; in this slot both notations are the same run.
    assert_eq!(project.mimesh(&["run", "p.yaml"]).status, 0);
    let written = plan(&["--set", "transfer.initial.weights.type=biharmonic"]);
    assert!(written.matches("reuse:").count() == 4 && !written.contains("run:"), "{written}");
    let other = plan(&["--set", "transfer.initial.weights.type=bounded_biharmonic"]);
    assert!(other.contains("initial.weights.type is \"bounded_biharmonic\", was \"biharmonic\""), "{other}");
    let shown = project.mimesh(&["show", "transfer", "multi_component"]).stdout;
    assert!(shown.contains("the default of biharmonic here is"), "{shown}");
}

#[test]
fn a_file_with_the_name_of_a_setting_is_no_input() {
    let project = multi_component("  placement: motion\n");
    assert_eq!(project.mimesh(&["run", "p.yaml"]).status, 0);
    project.write("motion", "x\n");
    let plan = project.mimesh(&["plan", "p.yaml"]).stdout;
    assert!(plan.matches("reuse:").count() == 4 && !plan.contains("run:"), "{plan}");
}
