//! What a user reads, in full, when a pipeline is wrong: files, keys, settings and outputs.
#![cfg(feature = "bundled")]

mod common;

use common::{PIPELINE, Project, assert_stderr, diagnostics};

#[test]
fn no_pipeline() {
    let project = Project::new();
    let output = project.mimesh(&["check", "q.yaml"]);
    assert_eq!(
        (output.status, output.stderr.as_str()),
        (66, "error: q.yaml: no such file\n  hint: did you mean `p.yaml`?\n")
    );
}

#[test]
fn a_missing_file() {
    let project = Project::new();
    project.edit("rest: rest.obj", "rest: rset.obj");
    assert_stderr(
        &project,
        "check",
        66,
        "
error: p.yaml:1:17: no such file: rset.obj
   |
 1 | source: { rest: rset.obj, poses: pose-*.obj }
   |                 ^^^^^^^^
   = hint: did you mean `rest.obj`?
",
    );
}

#[test]
fn a_glob_without_match() {
    let project = Project::new();
    project.edit("pose-*.obj", "pos-*.obj");
    assert_stderr(
        &project,
        "check",
        66,
        "
error: p.yaml:1:34: no file matches `pos-*.obj`
   |
 1 | source: { rest: rest.obj, poses: pos-*.obj }
   |                                  ^^^^^^^^^
   = hint: the 5 .obj files there go from pose-1.obj to target.obj
",
    );
}

#[test]
fn several_errors_at_once() {
    let project = Project::new();
    project.write(
        "p.yaml",
        "\
sorce: { rest: rest.obj, poses: pose-*.obj }
target: { rest: taget.obj }
markers: m.cons
correspondence: { type: identiti }
transfer:
  type: gradient
  placment: fixed
  sampling: 3
output: [out/all.obj, out/{pose}.glb, out/all.xyz]
",
    );
    assert_stderr(
        &project,
        "check",
        78,
        "
error: p.yaml:1:1: unknown key `sorce`
   |
 1 | sorce: { rest: rest.obj, poses: pose-*.obj }
   | ^^^^^
   = hint: did you mean `source`?
error: p.yaml:2:17: no such file: taget.obj
   |
 2 | target: { rest: taget.obj }
   |                 ^^^^^^^^^
   = hint: did you mean `target.obj`?
error: p.yaml:3:10: no such file: m.cons
   |
 3 | markers: m.cons
   |          ^^^^^^
   = hint: paths are relative to the folder of the pipeline's file
error: p.yaml:4:25: unknown correspondence `identiti`
   |
 4 | correspondence: { type: identiti }
   |                         ^^^^^^^^
   = hint: did you mean `identity`?
error: p.yaml:7:3: unknown key `placment`
   |
 7 |   placment: fixed
   |   ^^^^^^^^
   = hint: did you mean `placement`?
error: p.yaml:8:13: `sampling`: expected one of points, triangles, found 3
   |
 8 |   sampling: 3
   |             ^
error: p.yaml:9:10: a .obj file holds one pose, so its name needs `{pose}`
   |
 9 | output: [out/all.obj, out/{pose}.glb, out/all.xyz]
   |          ^^^^^^^^^^^
   = hint: e.g. `all-{pose}.obj`
error: p.yaml:9:23: a .glb file holds all poses, so its name cannot have `{pose}`
   |
 9 | output: [out/all.obj, out/{pose}.glb, out/all.xyz]
   |                       ^^^^^^^^^^^^^^
   = hint: remove `{pose}`
error: p.yaml:9:39: no format can write .xyz files
   |
 9 | output: [out/all.obj, out/{pose}.glb, out/all.xyz]
   |                                       ^^^^^^^^^^^
   = hint: formats that write: .glb, .vrm, .gltf, .mdd, .obj, .off, .coff, .noff, .cnoff, .pc2, .ply, .stl, .usda
9 mistakes
",
    );
}

#[test]
fn a_wrong_type_of_a_setting() {
    let project = Project::new();
    project.edit("{ type: identity }", "{ type: nonrigid_fit, smoothness: much, steps: -1 }");
    project.edit("output:", "markers: m.cons\noutput:");
    project.write("m.cons", "4\n0, 0\n1, 1\n2, 2\n4, 4\n");
    assert_stderr(
        &project,
        "check",
        78,
        "
error: p.yaml:3:51: `smoothness`: expected a number, found the string \"much\"
   |
 3 | correspondence: { type: nonrigid_fit, smoothness: much, steps: -1 }
   |                                                   ^^^^
error: p.yaml:3:64: `steps`: expected 0 to 100, found -1
   |
 3 | correspondence: { type: nonrigid_fit, smoothness: much, steps: -1 }
   |                                                                ^^
2 mistakes
",
    );
}

#[test]
fn a_file_that_is_no_yaml() {
    let project = Project::new();
    project.write("p.yaml", &format!("{PIPELINE}truth: [a, b\n"));
    let output = project.mimesh(&["check", "p.yaml"]);
    assert!(output.stderr.starts_with("error: p.yaml:"), "{}", output.stderr);
    assert!(output.stderr.contains(": not valid YAML: "), "{}", output.stderr);
    assert_eq!(output.status, 78);
}

#[test]
fn errors_within_lists() {
    let project = Project::new();
    project.edit("pose-*.obj", "[pose-1.obj, 2, pose-3.obj]");
    project.edit("out/{pose}.obj", "[1, out/all.obj, 2]");
    project.edit(
        "output:",
        "truth: \"{pose}.obj\"\nmetrics: [{ type: pont_error }, { tipe: x }]\nformats: [{ type: obj, turn_normals: 7 }, { type: gif }]\noutput:",
    );
    assert_stderr(
        &project,
        "check",
        78,
        "
error: p.yaml:1:47: `poses`: expected a string, found 2
   |
 1 | source: { rest: rest.obj, poses: [pose-1.obj, 2, pose-3.obj] }
   |                                               ^
error: p.yaml:1:50: no such file: pose-3.obj
   |
 1 | source: { rest: rest.obj, poses: [pose-1.obj, 2, pose-3.obj] }
   |                                                  ^^^^^^^^^^
   = hint: did you mean `pose-2.obj`?
error: p.yaml:6:19: unknown metric `pont_error`
   |
 6 | metrics: [{ type: pont_error }, { tipe: x }]
   |                   ^^^^^^^^^^
   = hint: did you mean `point_error`?
error: p.yaml:6:33: missing key `type`
   |
 6 | metrics: [{ type: pont_error }, { tipe: x }]
   |                                 ^^^^^^^^^^
   = hint: known types: area_change, closure, component_gaps, component_motion, contact_slide, edge_stretch, flipped_triangles, jitter, map_collapse, map_tears, marker_fit, point_error, rest_difference, self_intersections, source_motion, volume
error: p.yaml:7:38: `turn_normals`: expected true or false, found 7
   |
 7 | formats: [{ type: obj, turn_normals: 7 }, { type: gif }]
   |                                      ^
error: p.yaml:7:51: unknown format `gif`
   |
 7 | formats: [{ type: obj, turn_normals: 7 }, { type: gif }]
   |                                                   ^^^
   = hint: known types: fbx, glb, gltf, mdd, obj, off, pc2, ply, stl, usda
error: p.yaml:8:10: `output`: expected a string, found 1
   |
 8 | output: [1, out/all.obj, 2]
   |          ^
error: p.yaml:8:13: a .obj file holds one pose, so its name needs `{pose}`
   |
 8 | output: [1, out/all.obj, 2]
   |             ^^^^^^^^^^^
   = hint: e.g. `all-{pose}.obj`
error: p.yaml:8:26: `output`: expected a string, found 2
   |
 8 | output: [1, out/all.obj, 2]
   |                          ^
9 mistakes
",
    );
}

#[test]
fn outputs_that_collide() {
    let project = Project::new();
    project.edit("out/{pose}.obj", "[\"out/{pose}.obj\", \"new/../out/{pose}.obj\"]");
    assert_stderr(
        &project,
        "check",
        78,
        "
error: p.yaml:5:28: new/../out/1.obj would be written twice
   |
 5 | output: [\"out/{pose}.obj\", \"new/../out/{pose}.obj\"]
   |                            ^^^^^^^^^^^^^^^^^^^^^^^
   = hint: give each output its own name; poses are told apart by `{pose}`
",
    );
}

#[test]
fn a_glob_that_matches_nothing_but_the_rest_mesh() {
    let project = Project::new();
    project.edit("pose-*.obj", "rest*.obj");
    assert_stderr(
        &project,
        "run",
        66,
        "
error: p.yaml:1:34: `rest*.obj` matches the rest mesh only, which is no pose
   |
 1 | source: { rest: rest.obj, poses: rest*.obj }
   |                                  ^^^^^^^^^
   = hint: the 5 .obj files there go from pose-1.obj to target.obj
",
    );
}

#[test]
fn an_output_folder_that_is_a_file() {
    let project = Project::new();
    let output = project.mimesh(&["run", "p.yaml", "--out", "rest.obj"]);
    let expected = "error: --out rest.obj: cannot write rest.obj/1.obj: rest.obj is not a folder\n  \
                    hint: choose another folder for the results: `--out DIR`\n";
    assert_eq!((output.status, output.stderr.as_str()), (73, expected));
}

#[test]
fn placeholders_in_the_wrong_place() {
    let project = Project::new();
    project.edit("out/{pose}.obj", "[\"of/{pose}/mesh.obj\", \"{who}/{pose}.obj\", \"out/{pose}.html\"]");
    project.edit("output:", "keep_correspondence: on/map-{pose}.json\noutput:");
    let expected = [
        "p.yaml:5:22: the correspondence is one file, so its name cannot have `{pose}`",
        "p.yaml:6:10: `{pose}` in the name of a folder: poses share their folder",
        "p.yaml:6:32: unknown placeholder `{who}`",
        "p.yaml:6:52: out/{pose}.html shows all poses, so its name cannot have `{pose}`",
    ];
    assert_eq!(diagnostics(&project, &[]), expected);
    // Another folder for the results does not hide them.
    let output = project.mimesh(&["check", "p.yaml", "--out", "{elsewhere}"]);
    let found: Vec<_> = output.stderr.lines().filter_map(|line| line.strip_prefix("error: ")).collect();
    assert_eq!(found, expected);
}

#[test]
fn every_wrong_metric_at_its_own_entry() {
    let project = Project::new();
    project.edit(
        "output:",
        "metrics:\n  - { type: volum }\n  - { type: point_error }\n  - { type: volume }\n  - { type: volume }\noutput:",
    );
    assert_eq!(
        diagnostics(&project, &[]),
        [
            "p.yaml:6:13: unknown metric `volum`",
            "p.yaml:7:5: the metric `point_error` without `truth`",
            "p.yaml:9:5: the metric `volume` a second time",
        ]
    );
}
