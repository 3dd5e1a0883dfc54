//! One pipeline of several files, and variables in it.
#![cfg(feature = "bundled")]

mod common;

use common::{PIPELINE, Project, diagnostics, json};
use mimesh::pipeline::{Options, prepare_all};

#[test]
fn paths_of_an_included_file_are_relative_to_it() {
    let project = Project::new();
    let base = PIPELINE
        .replace("rest.obj", "../rest.obj")
        .replace("pose-*", "../pose-*")
        .replace(" target.obj", " ../target.obj");
    project.write("common/base.yaml", &base.replace("output: out/{pose}.obj\n", ""));
    project.write("p.yaml", "include: common/base.yaml\noutput: out/{pose}.obj\n");
    let output = project.mimesh(&["run", "p.yaml"]);
    assert_eq!(output.status, 0, "{}", output.stderr);
    assert_eq!(project.names("out"), ["1.obj", "10.obj", "2.obj", "run.json"]);
    let inputs = json(&project.read("out/run.json"))["inputs"].clone();
    let pipelines: Vec<_> = inputs.as_array().unwrap().iter().take(2).map(|input| input["path"].clone()).collect();
    assert_eq!(pipelines, ["p.yaml", "common/base.yaml"]);
    // A path in this file is relative to it, and one in a variable to where the variable is defined.
    project.write("p.yaml", "include: common/base.yaml\ntarget: { rest: target.obj }\noutput: out/{pose}.obj\n");
    assert_eq!(diagnostics(&project, &[]), [""; 0]);
    project.write("common/base.yaml", &base.replace("../target.obj", "${mesh}"));
    project.write("p.yaml", "include: common/base.yaml\nvariables: { mesh: target.obj }\noutput: out/{pose}.obj\n");
    assert_eq!(diagnostics(&project, &[]), [""; 0]);
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
        let all = prepare_all(&project.path("p.yaml"), &Options::default(), None)
            .unwrap_or_else(|failure| panic!("{failure}"));
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
fn files_that_cannot_be_included_are_reported_where_they_are_named() {
    let project = Project::new();
    project.write("p.yaml", "include: [a.yaml, nne.yaml]\n");
    project.write("a.yaml", "include: sub/b.yaml\n");
    project.write("sub/b.yaml", "# back\ninclude: ../a.yaml\n");
    project.write("none.yaml", "");
    assert_eq!(
        diagnostics(&project, &[]),
        [
            "sub/b.yaml:2:10: files include each other in a circle: p.yaml includes a.yaml includes sub/b.yaml includes a.yaml",
            "p.yaml:1:19: no such file: nne.yaml",
        ]
    );
    project.write("p.yaml", "include: { a: 1 }\n");
    assert_eq!(
        diagnostics(&project, &[]),
        ["p.yaml:1:10: `include`: expected a path or a sequence of paths, found a mapping"]
    );
    project.write("p.yaml", "include: b.yaml\n");
    project.write("b.yaml", "- 1\n");
    assert_eq!(diagnostics(&project, &[]), ["b.yaml:1:1: expected a mapping of keys"]);
}

#[test]
fn diagnostics_of_an_included_file_name_that_file() {
    let project = Project::new();
    project.write("base.yaml", &PIPELINE.replace("copy_displacement", "gradient, reweightings: many"));
    project.write("p.yaml", "include: base.yaml\ntransfer: { sampling: pionts }\n");
    assert_eq!(
        diagnostics(&project, &[]),
        [
            "p.yaml:2:23: `sampling`: unknown value `pionts`",
            "base.yaml:4:43: `reweightings`: expected a whole number, 0 or more, found the string \"many\"",
        ]
    );
}

#[test]
fn variables_are_set_from_the_command_line_with_their_type() {
    let project = Project::new();
    let text = PIPELINE.replace("copy_displacement", "gradient, reweightings: ${steps}")
        + "variables: { steps: 2, out: out }\n";
    project.write("p.yaml", &text.replace("out/{pose}", "${out}/s${steps}-{pose}"));
    let output = project.mimesh(&["run", "p.yaml", "--set", "variables.steps=1", "--json"]);
    assert_eq!(output.status, 0, "{}", output.stderr);
    assert_eq!(json(&output.stdout)["settings"]["transfer"]["reweightings"], 1);
    assert_eq!(project.names("out"), ["run.json", "s1-1.obj", "s1-10.obj", "s1-2.obj"]);
    assert_eq!(
        diagnostics(&project, &["variables.steps=few", "variables.step=1"]),
        [
            "p.yaml:4:43: `reweightings`: expected a whole number, 0 or more, found the string \"few\"",
            "--set variables.step=1: the variable `step` is used nowhere",
        ]
    );
}

#[test]
fn an_unused_variable_is_a_warning_with_the_nearest_used_one() {
    let project = Project::new();
    project.write(
        "p.yaml",
        &(PIPELINE.replace("out/{pose}", "${folder}/{pose}") + "variables: { folder: out, foldr: x }\n"),
    );
    let output = project.mimesh(&["check", "p.yaml"]);
    assert_eq!(output.status, 0);
    assert_eq!(output.stderr, "warning: p.yaml:6:27: the variable `foldr` is used nowhere; did you mean `folder`?\n");
}

#[test]
fn the_environment_is_read_only_where_it_is_named() {
    let project = Project::new();
    project.write("p.yaml", &PIPELINE.replace("output: out", "output: ${env:MIMESH_TEST_OUT}"));
    let output = project.command(&["run", "p.yaml", "--quiet"]).env("MIMESH_TEST_OUT", "there").output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(project.has("there/1.obj"));
    let expected = "p.yaml:5:9: there is no variable `MIMESH_TEST_OUT` in the environment";
    assert_eq!(diagnostics(&project, &[]), [expected]);
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
    let output = project.mimesh(&["keypoints", "p.yaml", "--output", "k.yaml", "--quiet"]);
    assert_eq!(output.status, 0, "{}", output.stderr);
    assert!(project.has("k.yaml"));
}
