//! Several runs of one file and one file of several: targets, includes, variables and matrices, as a user has them.
#![cfg(feature = "bundled")]

mod common;

use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

use common::{PIPELINE, Project, cube};
use mimesh::pipeline::{Options, prepare_all};
use serde_json::{Value, json};

/// A file that declares several targets in place of the one of [`PIPELINE`].
fn with_targets(targets: &str) -> String {
    PIPELINE.replace("target: { rest: target.obj }", targets).replace("out/{pose}.obj", "out/{target}/{pose}.obj")
}

/// The first lines of what `mimesh check p.yaml` says is wrong.
fn mistakes(project: &Project, settings: &[&str]) -> Vec<String> {
    let mut arguments = vec!["check", "p.yaml"];
    settings.iter().for_each(|setting| arguments.extend(["--set", setting]));
    let said = project.mimesh(&arguments);
    said.err.lines().filter_map(|line| line.strip_prefix("error: ")).map(str::to_owned).collect()
}

fn json_of(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_else(|error| panic!("{error}: {text}"))
}

#[test]
fn every_target_takes_the_poses_and_has_a_report() {
    let project = Project::new();
    project.write("tall.obj", &cube(|[x, y, z]| [x, 5.0 * y, z]));
    project.write("p.yaml", &with_targets("targets: { wide: { rest: target.obj }, tall: { rest: tall.obj } }"));
    let said = project.mimesh(&["run", "p.yaml"]);
    assert_eq!(said.status, 0, "{}", said.err);
    for target in ["wide", "tall"] {
        assert_eq!(project.names(&format!("out/{target}")), ["1.obj", "10.obj", "2.obj", "run.json"]);
    }
    assert!(said.out.contains("2 runs done in "), "{}", said.out);
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
    let said = project.mimesh(&["run", "p.yaml", "--json"]);
    assert_eq!(said.status, 0, "{}", said.err);
    let runs = &json_of(&said.out)["runs"];
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
    let all = prepare_all(&project.path("p.yaml"), &Options::default());
    let all = all.unwrap_or_else(|failure| panic!("{failure}"));
    assert_eq!(all.len(), 8);
    // Runs 0 and 1, as 4 and 5, have the same poses; runs of one target share it.
    assert!(Arc::ptr_eq(&all[0].source, &all[1].source) && Arc::ptr_eq(&all[0].source, &all[4].source));
    assert!(Arc::ptr_eq(&all[0].target, &all[3].target) && !Arc::ptr_eq(&all[0].target, &all[4].target));
}

#[test]
fn paths_of_an_included_file_are_relative_to_it() {
    let project = Project::new();
    let base = PIPELINE
        .replace("rest.obj", "../rest.obj")
        .replace("pose-*", "../pose-*")
        .replace(" target.obj", " ../target.obj");
    project.write("common/base.yaml", &base.replace("output: out/{pose}.obj\n", ""));
    project.write("p.yaml", "include: common/base.yaml\noutput: out/{pose}.obj\n");
    let said = project.mimesh(&["run", "p.yaml"]);
    assert_eq!(said.status, 0, "{}", said.err);
    assert_eq!(project.names("out"), ["1.obj", "10.obj", "2.obj", "run.json"]);
    let inputs = json_of(&project.read("out/run.json"))["inputs"].clone();
    let pipelines: Vec<_> = inputs.as_array().unwrap().iter().take(2).map(|input| input["path"].clone()).collect();
    assert_eq!(pipelines, ["p.yaml", "common/base.yaml"]);
    // What is written here is relative to here, and a variable to where it was defined.
    project.write("p.yaml", "include: common/base.yaml\ntarget: { rest: target.obj }\noutput: out/{pose}.obj\n");
    assert_eq!(mistakes(&project, &[]), [""; 0]);
    project.write("common/base.yaml", &base.replace("../target.obj", "${mesh}"));
    project.write("p.yaml", "include: common/base.yaml\nvariables: { mesh: target.obj }\noutput: out/{pose}.obj\n");
    assert_eq!(mistakes(&project, &[]), [""; 0]);
}

#[test]
fn it_does_not_matter_which_file_includes_which() {
    let project = Project::new();
    project.write("a.yaml", PIPELINE);
    project.write("b.yaml", "correspondence: { type: nearest }\ntransfer: { type: gradient, reweightings: 3 }\n");
    project.write("c.yaml", "transfer: { sampling: triangles }\noutput: out/{pose}.ply\n");
    let settings = |files: &[(&str, &str)]| {
        for (name, text) in files {
            project.write(name, text);
        }
        let all =
            prepare_all(&project.path("p.yaml"), &Options::default()).unwrap_or_else(|failure| panic!("{failure}"));
        serde_json::to_value(&all[0].pipeline).unwrap()
    };
    let list = settings(&[("p.yaml", "include: [a.yaml, b.yaml, c.yaml]\n")]);
    let left = settings(&[("p.yaml", "include: [ab.yaml, c.yaml]\n"), ("ab.yaml", "include: [a.yaml, b.yaml]\n")]);
    let right = settings(&[("p.yaml", "include: [a.yaml, bc.yaml]\n"), ("bc.yaml", "include: [b.yaml, c.yaml]\n")]);
    assert_eq!(list["transfer"]["sampling"], "triangles");
    assert_eq!(list["transfer"]["reweightings"], 3);
    assert_eq!((&left, &right), (&list, &list));
}

#[test]
fn files_that_cannot_be_included_are_told_where_they_are_named() {
    let project = Project::new();
    project.write("p.yaml", "include: [a.yaml, nne.yaml]\n");
    project.write("a.yaml", "include: sub/b.yaml\n");
    project.write("sub/b.yaml", "# back\ninclude: ../a.yaml\n");
    project.write("none.yaml", "");
    assert_eq!(
        mistakes(&project, &[]),
        [
            "sub/b.yaml:2:10: files include each other in a circle: p.yaml includes a.yaml includes sub/b.yaml includes a.yaml",
            "p.yaml:1:19: no such file: nne.yaml",
        ]
    );
    project.write("p.yaml", "include: { a: 1 }\n");
    assert_eq!(mistakes(&project, &[]), ["p.yaml:1:10: `include`: expected a path or a list of paths, found a map"]);
    project.write("p.yaml", "include: b.yaml\n");
    project.write("b.yaml", "- 1\n");
    assert_eq!(mistakes(&project, &[]), ["b.yaml:1:1: expected a map of keys of a pipeline"]);
}

#[test]
fn mistakes_of_an_included_file_are_told_in_it() {
    let project = Project::new();
    project.write("base.yaml", &PIPELINE.replace("copy_displacement", "gradient, reweightings: many"));
    project.write("p.yaml", "include: base.yaml\ntransfer: { sampling: pionts }\n");
    assert_eq!(
        mistakes(&project, &[]),
        [
            "p.yaml:2:23: `sampling`: unknown value `pionts`",
            "base.yaml:4:43: `reweightings`: expected a whole number, 0 or more, found the text \"many\"",
        ]
    );
}

#[test]
fn variables_are_set_from_the_command_line_with_their_type() {
    let project = Project::new();
    let text = PIPELINE.replace("copy_displacement", "gradient, reweightings: ${steps}")
        + "variables: { steps: 2, out: out }\n";
    project.write("p.yaml", &text.replace("out/{pose}", "${out}/s${steps}-{pose}"));
    let said = project.mimesh(&["run", "p.yaml", "--set", "variables.steps=1", "--json"]);
    assert_eq!(said.status, 0, "{}", said.err);
    assert_eq!(json_of(&said.out)["settings"]["transfer"]["reweightings"], 1);
    assert_eq!(project.names("out"), ["run.json", "s1-1.obj", "s1-10.obj", "s1-2.obj"]);
    assert_eq!(
        mistakes(&project, &["variables.steps=few", "variables.step=1"]),
        [
            "p.yaml:4:43: `reweightings`: expected a whole number, 0 or more, found the text \"few\"",
            "--set variables.step=1: the variable `step` is used nowhere",
        ]
    );
}

#[test]
fn a_variable_that_is_used_nowhere_is_a_warning_with_what_may_be_meant() {
    let project = Project::new();
    project.write(
        "p.yaml",
        &(PIPELINE.replace("out/{pose}", "${folder}/{pose}") + "variables: { folder: out, foldr: x }\n"),
    );
    let said = project.mimesh(&["check", "p.yaml"]);
    assert_eq!(said.status, 0);
    assert_eq!(said.err, "warning: p.yaml:6:27: the variable `foldr` is used nowhere; did you mean `folder`?\n");
}

#[test]
fn the_environment_is_read_only_where_it_is_named() {
    let project = Project::new();
    project.write("p.yaml", &PIPELINE.replace("output: out", "output: ${env:MIMESH_TEST_OUT}"));
    let said = project.command(&["run", "p.yaml", "--quiet"]).env("MIMESH_TEST_OUT", "there").output().unwrap();
    assert!(said.status.success(), "{}", String::from_utf8_lossy(&said.stderr));
    assert!(project.has("there/1.obj"));
    let expected = "p.yaml:5:9: there is no variable `MIMESH_TEST_OUT` in the environment";
    assert_eq!(mistakes(&project, &[]), [expected]);
}

/// Three poses and two ways to transfer them; the second pose is of another mesh.
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
    let said = project.mimesh(&["run", "p.yaml", "--table", "results.csv"]);
    assert_eq!(said.status, 4, "{}", said.err);
    assert!(said.err.contains("error: bad.obj: poses=bad.obj,transfer=gradient: pose has 3 vertices"), "{}", said.err);
    let names = project.names("out");
    let expected = ["poses=pose-1.obj,transfer=copy_displacement.glb", "poses=pose-1.obj,transfer=gradient.glb"];
    assert_eq!(names[..2], expected);
    // Several runs in one folder have a report each.
    assert_eq!(names[2], "run-poses=pose-1.obj,transfer=copy_displacement.json");
    let table: Vec<&str> = said.out.lines().collect();
    assert_eq!(table[0].split_whitespace().collect::<Vec<_>>(), ["poses", "transfer", "verdict", "seconds", "status"]);
    let ends: Vec<_> = table[1..5].iter().map(|line| line.split_whitespace().last().unwrap()).collect();
    assert_eq!(ends, ["done", "done", "failed", "failed"]);
    assert!(table.last().unwrap().starts_with("2 of 4 runs done, 2 failed, in "), "{}", said.out);
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
    let said = project.mimesh(&["run", "p.yaml", "--quiet", "--set", "matrix.source.poses=[bad.obj]"]);
    assert_eq!(said.status, 65, "{}", said.err);
}

#[test]
fn results_are_json_and_tables_in_files_too() {
    let project = Project::new();
    sweep(&project);
    let arguments = ["run", "p.yaml", "--json", "--set", "matrix.source.poses=[pose-1.obj]", "--table", "t/results.md"];
    let said = project.mimesh(&arguments);
    assert_eq!(said.status, 0, "{}", said.err);
    let results = json_of(&said.out);
    assert_eq!((&results["status"], results["runs"].as_array().unwrap().len()), (&json!("done"), 2));
    assert_eq!(results["runs"][1]["name"], "poses=pose-1.obj,transfer=copy_displacement");
    assert_eq!(results["runs"][1]["matrix"]["transfer"], json!({ "type": "copy_displacement" }));
    assert_eq!(results["runs"][1]["report"]["status"], "done");
    let markdown = project.read("t/results.md");
    assert!(
        markdown.starts_with("| poses | transfer | verdict | seconds | status |\n| --- | --- | ---: | ---: | ---: |\n"),
        "{markdown}"
    );
    let wrong = project.mimesh(&["run", "p.yaml", "--table", "results.txt"]);
    assert_eq!(
        (wrong.status, wrong.err.lines().next()),
        (2, Some("error: --table results.txt: a table is written as .csv or .md"))
    );
    assert_eq!(project.mimesh(&["run", "p.yaml", "--table", "rest.obj/x.csv"]).status, 73);
}

#[test]
fn out_gives_every_run_a_folder_of_its_own() {
    let project = Project::new();
    sweep(&project);
    let said = project.mimesh(&["run", "p.yaml", "-q", "--out", "try", "--set", "matrix.source.poses=[pose-1.obj]"]);
    assert_eq!(said.status, 0, "{}", said.err);
    let names = ["poses=pose-1.obj,transfer=copy_displacement", "poses=pose-1.obj,transfer=gradient"];
    assert_eq!(project.names("try"), names);
    assert!(project.has(&format!("try/{}/run.json", names[0])));
}

#[test]
fn nested_stages_keep_their_default_type_in_a_matrix() {
    let project = Project::new();
    let text = PIPELINE.replace("copy_displacement", "biharmonic").replace("out/{pose}.obj", "out/{matrix}.glb")
        + "matrix: { transfer.deformer.lambda: [0.1, 5] }\n";
    project.write("p.yaml", &text);
    let said = mistakes(&project, &[]);
    // What is wrong is the missing markers, not the type of the deformer.
    assert!(said.iter().all(|line| !line.contains("`type`")), "{said:?}");
}

#[test]
fn check_tells_the_mistakes_of_all_runs_at_once_and_each_once() {
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
        mistakes(&project, &["transfer.tolerance=1", "variables.other=2", "source.pose=x"]),
        [
            "p.yaml:3:26: unknown key `trth`",
            "p.yaml:4:14: no such file: tarset.obj",
            "p.yaml:5:3: `c/d` cannot name a target: it has `/`",
            "p.yaml:6:6: `e`: expected a map of what the target is, found the text \"mesh.obj\"",
            "p.yaml:7:50: unknown correspondence `identty`",
            "p.yaml:8:35: unknown key `k`",
            "p.yaml:9:43: undefined variable `stps`",
            "p.yaml:12:30: `tolerance`: expected at least 0.000001, found -1",
            "p.yaml:12:34: `transfer.tolerance`: 0.02 stands here a second time",
            "p.yaml:13:3: unknown key `tranfer`",
            "p.yaml:14:23: `transfer.weighting`: the list of values is empty",
            "p.yaml:15:3: `targets` cannot vary",
            "p.yaml:16:3: `include` cannot vary",
            "p.yaml:17:20: `transfer.smooth`: expected a list of values, found 3",
            "p.yaml:18:9: there are several targets and combinations, so the name of what is written needs `{name}`",
            "--set transfer.tolerance=1: `transfer.tolerance` is varied by `matrix`",
            "--set variables.other=2: the variable `other` is used nowhere",
            "--set source.pose=x: unknown key `pose`",
        ]
    );
}

#[test]
fn what_is_wrong_with_some_runs_only_says_with_which() {
    let project = Project::new();
    project.write("small.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    project.write("p.yaml", &with_targets("targets: { a: { rest: target.obj }, b: { rest: small.obj } }"));
    let said = mistakes(&project, &[]);
    assert_eq!(said.len(), 1, "{said:?}");
    assert!(
        said[0].starts_with("p.yaml:3:17: correspondence (identity): ") && said[0].ends_with(" (of `b`)"),
        "{said:?}"
    );
}

#[test]
fn keys_that_do_not_go_together_are_told() {
    let project = Project::new();
    let told = |text: &str, expected: &[&str]| {
        project.write("p.yaml", text);
        assert_eq!(mistakes(&project, &[]), expected, "{text}");
    };
    let both = PIPELINE.to_owned() + "targets: { a: { rest: target.obj } }\n";
    told(&both, &["p.yaml:2:1: `target` beside `targets`"]);
    told(
        &with_targets("targets: {}"),
        &["p.yaml:2:10: `targets`: expected a map of names and meshes, found an empty one"],
    );
    told(&PIPELINE.replace("out/", "out/{target}/"), &["p.yaml:5:13: `{target}` without `targets`"]);
    told(
        &(PIPELINE.to_owned() + "matrix: [1]\n"),
        &["p.yaml:6:9: `matrix`: expected a map of keys and lists, found a list"],
    );
    told(
        &(PIPELINE.to_owned() + "variables: x\n"),
        &["p.yaml:6:12: `variables`: expected a map of names and values, found the text \"x\""],
    );
    project.write("p.yaml", &with_targets("targets: { a: { rest: target.obj } }"));
    let both = mistakes(&project, &["target.rest=rest.obj", "include=a.yaml"]);
    assert_eq!(
        both,
        [
            "--set include=a.yaml: `include` cannot be set",
            "--set target.rest=rest.obj: there are several targets, each with its own mesh",
        ]
    );
    let collide =
        with_targets("targets: { a: { rest: target.obj }, b: { rest: rest.obj, output: 'out/a/{pose}.obj' } }");
    told(&collide, &["p.yaml: out/a/1.obj would be written by two runs, `a` and `b`"]);
}

#[test]
fn keypoints_see_through_includes_and_variables() {
    let project = Project::new();
    project.write(
        "base.yaml",
        "source: { generator: { type: quadruped, resolution: ${n}, frames: 3 } }\nvariables: { n: 20 }\n",
    );
    project
        .write("p.yaml", "include: base.yaml\nkey_points: { type: greedy, max_count: 2 }\ntargets: { a: {}, b: {} }\n");
    let said = project.mimesh(&["keypoints", "p.yaml", "--output", "k.yaml", "--quiet"]);
    assert_eq!(said.status, 0, "{}", said.err);
    assert!(project.has("k.yaml"));
}

/// The pipelines of the project.
fn pipelines() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("pipelines");
    let mut files: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    let is_pipeline = |name: &str| name.ends_with(".yaml") && !name.ends_with(".markers.yaml");
    files.retain(|file| is_pipeline(&file.to_string_lossy()));
    files
}

#[test]
fn the_published_schema_accepts_every_pipeline_and_knows_mistakes() {
    let project = Project::new();
    let schema = json_of(&project.mimesh(&["schema"]).out);
    let mut schemas = boon::Schemas::new();
    let mut compiler = boon::Compiler::new();
    compiler.add_resource("mimesh.json", schema).unwrap();
    let compiled = compiler.compile("mimesh.json", &mut schemas).unwrap_or_else(|error| panic!("{error:#}"));
    let valid = |text: &str| {
        let value = mimesh::pipeline::Document::parse(Path::new("p.yaml"), text).unwrap().value;
        schemas.validate(&value, compiled).map_err(|error| format!("{error:#}"))
    };
    for file in pipelines() {
        let text = std::fs::read_to_string(&file).unwrap();
        assert!(valid(&text).is_ok(), "{}: {}", file.display(), valid(&text).unwrap_err());
    }
    let targets = "targets: { a: { rest: x.obj, transfer: { reweightings: 1 } } }";
    let good = [
        PIPELINE.to_owned(),
        with_targets(targets),
        "include: base.yaml\ntransfer: { reweightings: 1 }\n".into(),
        PIPELINE.replace("{ type: identity }", "${method}") + "variables: { method: { type: identity } }\n",
        PIPELINE.replace("copy_displacement", "gradient, tolerance: ${t}") + "matrix: { variables.t: [0.1, 0.2] }\n",
    ];
    for text in good {
        assert!(valid(&text).is_ok(), "{text}: {}", valid(&text).unwrap_err());
    }
    let bad = [
        PIPELINE.replace("target:", "tarjet:"),
        PIPELINE.replace("transfer: { type: copy_displacement }\n", ""),
        PIPELINE.replace("copy_displacement", "gradient, tolerance: much"),
        PIPELINE.replace("{ type: copy_displacement }", "{ reweightings: 1 }"),
        with_targets("targets: { a: { rst: x.obj } }"),
        with_targets("targets: { a: { rest: x.obj, transfer: { type: gradiant } } }"),
        PIPELINE.to_owned() + "matrix: { transfer.k: 5 }\n",
        PIPELINE.to_owned() + "targets: { a: { rest: x.obj } }\n",
    ];
    for text in bad {
        assert!(valid(&text).is_err(), "{text}");
    }
}

#[test]
fn a_line_for_editors_is_a_comment() {
    let project = Project::new();
    project.write("p.yaml", &format!("# yaml-language-server: $schema=mimesh.schema.json\n{PIPELINE}"));
    assert_eq!(mistakes(&project, &[]), [""; 0]);
}
