//! Several runs of one pipeline: targets, matrices, and their tables.
#![cfg(feature = "bundled")]

mod common;

use std::sync::Arc;

use common::{PIPELINE, Project, cube, diagnostics, json, with_targets};
use mimesh::pipeline::{Options, prepare_all};

#[test]
fn every_target_takes_the_poses_and_has_a_report() {
    let project = Project::new();
    project.write("tall.obj", &cube(|[x, y, z]| [x, 5.0 * y, z]));
    project.write("p.yaml", &with_targets("targets: { wide: { rest: target.obj }, tall: { rest: tall.obj } }"));
    let output = project.mimesh(&["run", "p.yaml"]);
    assert_eq!(output.status, 0, "{}", output.stderr);
    for target in ["wide", "tall"] {
        assert_eq!(project.names(&format!("out/{target}")), ["1.obj", "10.obj", "2.obj", "run.json"]);
    }
    assert!(output.stdout.contains("2 runs done in "), "{}", output.stdout);
    // Each target gives what it gives alone.
    let alone = project.read("out/tall/2.obj");
    project.write("p.yaml", &PIPELINE.replace("target.obj", "tall.obj"));
    assert_eq!(project.mimesh(&["run", "p.yaml"]).status, 0);
    assert_eq!(project.read("out/2.obj"), alone);
}

#[test]
fn a_target_may_differ_in_any_slot() {
    let project = Project::new();
    let targets = "targets:\n  a: { rest: target.obj, truth: 'pose-{pose}.obj' }\n  \
        b: { rest: target.obj, transfer: { type: gradient, reweightings: 0 }, output: 'b/{pose}.obj' }";
    project.write("p.yaml", &with_targets(targets));
    let output = project.mimesh(&["run", "p.yaml", "--json"]);
    assert_eq!(output.status, 0, "{}", output.stderr);
    let runs = &json(&output.stdout)["runs"];
    assert_eq!(runs[0]["report"]["settings"]["transfer"]["type"], "copy_displacement");
    assert_eq!(runs[1]["report"]["settings"]["transfer"]["type"], "gradient");
    assert!(runs[0]["metrics"]["point_error"].is_object() && runs[1]["metrics"].get("point_error").is_none());
    assert!(project.has("out/a/1.obj") && project.has("b/1.obj"));
}

#[test]
fn source_and_targets_are_read_once_for_all_runs() {
    let project = Project::new();
    let matrix = "matrix: { source.poses: [pose-1.obj, pose-2.obj], transfer.type: [copy_displacement, gradient] }\n";
    let text = with_targets("targets: { a: { rest: target.obj }, b: { rest: rest.obj } }") + matrix;
    project.write("p.yaml", &text.replace("{target}", "{name}"));
    let all = prepare_all(&project.path("p.yaml"), &Options::default(), None);
    let all = all.unwrap_or_else(|failure| panic!("{failure}"));
    assert_eq!(all.len(), 8);
    // Runs 0 and 1, as 4 and 5, have the same poses; runs of one target share it.
    assert!(Arc::ptr_eq(&all[0].source, &all[1].source) && Arc::ptr_eq(&all[0].source, &all[4].source));
    assert!(Arc::ptr_eq(&all[0].target, &all[3].target) && !Arc::ptr_eq(&all[0].target, &all[4].target));
}

/// Two poses, the second of another mesh, and two ways to transfer them.
fn sweep(project: &Project) {
    project.write("bad.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let text = PIPELINE.replace("out/{pose}.obj", "out/{matrix}.glb")
        + "matrix:\n  source.poses: [pose-1.obj, bad.obj]\n  transfer: [{ type: gradient }, { type: copy_displacement }]\n";
    project.write("p.yaml", &text);
}

#[test]
fn a_run_that_fails_does_not_stop_the_others() {
    let project = Project::new();
    sweep(&project);
    let output = project.mimesh(&["run", "p.yaml", "--table", "results.csv"]);
    assert_eq!(output.status, 4, "{}", output.stderr);
    assert!(
        output.stderr.contains("error: bad.obj: poses=bad.obj,transfer=gradient: pose has 3 vertices"),
        "{}",
        output.stderr
    );
    let names = project.names("out");
    let expected = ["poses=pose-1.obj,transfer=copy_displacement.glb", "poses=pose-1.obj,transfer=gradient.glb"];
    assert_eq!(names[..2], expected);
    // Several runs in one folder have a report each.
    assert_eq!(names[2], "run-poses=pose-1.obj,transfer=copy_displacement.json");
    let table: Vec<&str> = output.stdout.lines().collect();
    assert_eq!(table[0].split_whitespace().collect::<Vec<_>>(), ["poses", "transfer", "verdict", "seconds", "status"]);
    let ends: Vec<_> = table[1..5].iter().map(|line| line.split_whitespace().last().unwrap()).collect();
    assert_eq!(ends, ["done", "done", "failed", "failed"]);
    assert!(table.last().unwrap().starts_with("2 of 4 runs done, 2 failed, in "), "{}", output.stdout);
    let csv = project.read("results.csv");
    assert!(
        csv.starts_with("source.poses,transfer,area_change.beyond,")
            && csv.contains("verdict,seconds,status\npose-1.obj,\"{\"\"type\"\":\"\"gradient\"\"}\","),
        "{csv}"
    );
}

#[test]
fn if_every_run_fails_the_status_is_that_of_the_failures() {
    let project = Project::new();
    sweep(&project);
    let output = project.mimesh(&["run", "p.yaml", "--quiet", "--set", "matrix.source.poses=[bad.obj]"]);
    assert_eq!(output.status, 65, "{}", output.stderr);
}

#[test]
fn results_are_json_and_tables_in_files_too() {
    let project = Project::new();
    sweep(&project);
    let arguments = ["run", "p.yaml", "--json", "--set", "matrix.source.poses=[pose-1.obj]", "--table", "t/results.md"];
    let output = project.mimesh(&arguments);
    assert_eq!(output.status, 0, "{}", output.stderr);
    let results = json(&output.stdout);
    assert_eq!((&results["status"], results["runs"].as_array().unwrap().len()), (&serde_json::json!("done"), 2));
    assert_eq!(results["runs"][1]["name"], "poses=pose-1.obj,transfer=copy_displacement");
    assert_eq!(results["runs"][1]["matrix"]["transfer"], serde_json::json!({ "type": "copy_displacement" }));
    assert_eq!(results["runs"][1]["report"]["status"], "done");
    let markdown = project.read("t/results.md");
    assert!(
        markdown.starts_with("| poses | transfer | verdict | seconds | status |\n| --- | --- | ---: | ---: | ---: |\n"),
        "{markdown}"
    );
    let wrong = project.mimesh(&["run", "p.yaml", "--table", "results.txt"]);
    assert_eq!(
        (wrong.status, wrong.stderr.lines().next()),
        (2, Some("error: --table results.txt: a table is written as .csv or .md"))
    );
    assert_eq!(project.mimesh(&["run", "p.yaml", "--table", "rest.obj/x.csv"]).status, 73);
}

#[test]
fn out_gives_every_run_a_folder_of_its_own() {
    let project = Project::new();
    sweep(&project);
    let output = project.mimesh(&["run", "p.yaml", "-q", "--out", "try", "--set", "matrix.source.poses=[pose-1.obj]"]);
    assert_eq!(output.status, 0, "{}", output.stderr);
    let names = ["poses=pose-1.obj,transfer=copy_displacement", "poses=pose-1.obj,transfer=gradient"];
    assert_eq!(project.names("try"), names);
    assert!(project.has(&format!("try/{}/run.json", names[0])));
}

#[test]
fn nested_stages_keep_their_default_type_in_a_matrix() {
    let project = Project::new();
    let text = PIPELINE.replace("copy_displacement", "biharmonic").replace("out/{pose}.obj", "out/{matrix}.glb")
        + "matrix: { transfer.deformer.lambda: [0.1, 5] }\nmarkers: ~\n";
    project.write("p.yaml", &text);
    // Only the markers are missing, not the type of the deformer.
    let expected = ["p.yaml:4:11: transfer (biharmonic): biharmonic transfer needs at least 3 markers, there are 0"];
    assert_eq!(diagnostics(&project, &[]), expected);
}

#[test]
fn check_reports_the_diagnostics_of_all_runs_together_and_each_once() {
    let project = Project::new();
    project.write(
        "p.yaml",
        "source: { rest: rest.obj, poses: pose-*.obj }
targets:
  a: { rest: target.obj, trth: x.obj }
  b: { rest: tarset.obj }
  c/d: { rest: target.obj }
  e: mesh.obj
  f: { rest: target.obj, correspondence: { type: identty } }
correspondence: { type: identity, k: 1 }
transfer: { type: gradient, reweightings: ${stps} }
variables: { steps: 1 }
matrix:
  transfer.tolerance: [0.02, -1, 0.02]
  tranfer.sampling: [points]
  transfer.weighting: []
  targets.a.rest: [x.obj]
  include: [y]
  transfer.smooth: 3
output: out/{pose}.obj
",
    );
    assert_eq!(
        diagnostics(&project, &["transfer.tolerance=1", "variables.other=2", "source.pose=x"]),
        [
            "p.yaml:3:26: unknown key `trth`",
            "p.yaml:4:14: no such file: tarset.obj",
            "p.yaml:5:3: `c/d` cannot name a target: it has `/`",
            "p.yaml:6:6: `e`: expected a mapping with a mesh, found the string \"mesh.obj\"",
            "p.yaml:7:50: unknown correspondence `identty`",
            "p.yaml:8:35: unknown key `k`",
            "p.yaml:9:43: undefined variable `stps`",
            "p.yaml:12:30: `tolerance`: expected at least 0.000001, found -1",
            "p.yaml:12:34: `transfer.tolerance`: 0.02 stands here a second time",
            "p.yaml:13:3: unknown key `tranfer`",
            "p.yaml:14:23: `transfer.weighting`: the sequence of values is empty",
            "p.yaml:15:3: `targets` cannot vary",
            "p.yaml:16:3: `include` cannot vary",
            "p.yaml:17:20: `transfer.smooth`: expected a sequence of values, found 3",
            "p.yaml:18:9: there are several targets and combinations, so the name of what is written needs `{name}`",
            "--set transfer.tolerance=1: `transfer.tolerance` is varied by `matrix`",
            "--set variables.other=2: the variable `other` is used nowhere",
            "--set source.pose=x: unknown key `pose`",
        ]
    );
}

#[test]
fn a_diagnostic_of_some_runs_names_them() {
    let project = Project::new();
    project.write("small.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    project.write("p.yaml", &with_targets("targets: { a: { rest: target.obj }, b: { rest: small.obj } }"));
    let found = diagnostics(&project, &[]);
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(
        found[0].starts_with("p.yaml:3:17: correspondence (identity): ") && found[0].ends_with(" (of `b`)"),
        "{found:?}"
    );
}

#[test]
fn keys_that_exclude_each_other_are_reported() {
    let project = Project::new();
    let assert_diagnostics = |text: &str, expected: &[&str]| {
        project.write("p.yaml", text);
        assert_eq!(diagnostics(&project, &[]), expected, "{text}");
    };
    let both = PIPELINE.to_owned() + "targets: { a: { rest: target.obj } }\n";
    assert_diagnostics(&both, &["p.yaml:2:1: `target` beside `targets`"]);
    assert_diagnostics(
        &with_targets("targets: {}"),
        &["p.yaml:2:10: `targets`: expected a mapping of names and meshes, found an empty one"],
    );
    assert_diagnostics(&PIPELINE.replace("out/", "out/{target}/"), &["p.yaml:5:13: `{target}` without `targets`"]);
    assert_diagnostics(
        &(PIPELINE.to_owned() + "matrix: [1]\n"),
        &["p.yaml:6:9: `matrix`: expected a mapping of keys and sequences, found a sequence"],
    );
    assert_diagnostics(
        &(PIPELINE.to_owned() + "variables: x\n"),
        &["p.yaml:6:12: `variables`: expected a mapping of names and values, found the string \"x\""],
    );
    project.write("p.yaml", &with_targets("targets: { a: { rest: target.obj } }"));
    let both = diagnostics(&project, &["target.rest=rest.obj", "include=a.yaml"]);
    assert_eq!(
        both,
        [
            "--set include=a.yaml: `include` cannot be set",
            "--set target.rest=rest.obj: there are several targets, each with its own mesh",
        ]
    );
    assert_diagnostics(
        &(PIPELINE.replace("out/", "out/{matrix}/")
            + "matrix: { transfer.type: [copy_displacement], transfer: [{ type: gradient }, { type: copy_displacement }] }\n"),
        &["p.yaml:6:47: `transfer.type` and `transfer` replace each other's values"],
    );
    for key in ["target.rest", "target", "target.generator.seed"] {
        let text = with_targets("targets: { a: { rest: target.obj }, b: { rest: rest.obj } }");
        let text = text.replace("{target}/", "{name}/") + &format!("matrix: {{ {key}: [target.obj] }}\n");
        project.write("p.yaml", &text);
        let expected = format!("p.yaml:6:11: `{key}` beside `targets`, each of which has its own mesh");
        assert!(diagnostics(&project, &[]).contains(&expected), "{:?}", diagnostics(&project, &[]));
    }
    // Over an included `target` stands a null.
    project.write("base.yaml", PIPELINE);
    let over = "include: base.yaml\ntarget: ~\ntargets: { a: { rest: target.obj } }\noutput: out/{target}/{pose}.obj\n";
    assert_diagnostics(over, &[]);
    let collide =
        with_targets("targets: { a: { rest: target.obj }, b: { rest: rest.obj, output: 'out/a/{pose}.obj' } }");
    assert_diagnostics(&collide, &["p.yaml: out/a/1.obj would be written by two runs, `a` and `b`"]);
}
