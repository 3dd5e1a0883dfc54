//! What a user reads when something is wrong, in full.
#![cfg(feature = "bundled")]

mod common;

use common::{PIPELINE, Project, cube};

/// Checks what `mimesh COMMAND p.yaml` says on stderr, and its exit status.
fn says(project: &Project, command: &str, status: i32, expected: &str) {
    let said = project.mimesh(&[command, "p.yaml"]);
    assert_eq!(said.err.trim_end(), expected.trim(), "\n{}", said.err);
    assert_eq!(said.status, status);
}

#[test]
fn no_pipeline() {
    let project = Project::new();
    let said = project.mimesh(&["check", "q.yaml"]);
    assert_eq!((said.status, said.err.as_str()), (66, "error: q.yaml: no such file\n  hint: did you mean `p.yaml`?\n"));
}

#[test]
fn a_missing_file() {
    let project = Project::new();
    project.edit("rest: rest.obj", "rest: rset.obj");
    says(
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
    says(
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
fn a_pose_with_another_number_of_vertices() {
    let project = Project::new();
    for pose in ["1", "2", "10"] {
        project.write(&format!("pose-{pose}.obj"), &(cube(|p| p) + "v 0 0 0\n"));
    }
    project.edit("pose-*.obj", "pose-1.obj");
    says(
        &project,
        "run",
        65,
        "
correspondence (identity)
transfer (copy_displacement)
poses (0 of 1)
error: pose-1.obj: pose has 9 vertices, the rest mesh 8
  hint: a pose has the vertices and polygons of the rest mesh in the same order; export both with one setting
",
    );
}

#[test]
fn a_pose_with_another_face_list() {
    let project = Project::new();
    project.write("pose-2.obj", &cube(|p| p).replace("f 1 2 6 5", "f 2 6 5 1"));
    let said = project.mimesh(&["check", "p.yaml", "--poses"]);
    assert_eq!(
        said.err,
        "error: pose-2.obj: polygon 2 (from 0) differs: pose has vertices [1, 5, 4, 0], the rest mesh [0, 1, 5, 4]\n  \
         hint: a pose has the vertices and polygons of the rest mesh in the same order; export both with one setting\n"
    );
    assert_eq!(said.status, 65);
}

#[test]
fn coordinates_that_are_not_finite() {
    let project = Project::new();
    project.write("rest.obj", &cube(|p| p).replace("v 1 0 0", "v 1 nan 0"));
    project.write("target.obj", &cube(|p| p).replace("v 0 2 0", "v 0 inf 0"));
    says(
        &project,
        "check",
        65,
        "
error: rest.obj:2: vertex 2 has coordinate `nan`: expected a finite number
  hint: repair the file or export it again without NaN and infinity
error: target.obj:3: vertex 3 has coordinate `inf`: expected a finite number
  hint: repair the file or export it again without NaN and infinity
2 mistakes
",
    );
}

#[test]
fn a_face_index_out_of_range() {
    let project = Project::new();
    project.write("target.obj", &cube(|p| p).replace("f 5 6 8 7", "f 5 6 9 7"));
    says(
        &project,
        "check",
        65,
        "
error: target.obj:10: vertex index 9 is out of range: the file has 8 vertices
  hint: the file is damaged or cut short: export it again
",
    );
}

#[test]
fn an_empty_mesh() {
    let project = Project::new();
    project.write("target.obj", "v 0 0 0\n");
    says(
        &project,
        "check",
        65,
        "
error: target.obj: empty mesh: 1 vertices, 0 faces
  hint: give a mesh with at least one face; point clouds and curves cannot take a deformation
",
    );
}

#[test]
fn markers_out_of_range_and_coincident() {
    let project = Project::new();
    project.edit("output:", "markers: m.cons\noutput:");
    project.write("m.cons", "4\n0, 0\n8, 1\n2, 2\n3, 2\n");
    says(
        &project,
        "check",
        65,
        "
error: m.cons:3: marker 2: the source has no vertex 8: expected 0 to 7
  hint: vertices and triangles count from 0; were source and target swapped, or has the mesh changed since?
error: m.cons:5: marker 4 lies on the same point of the target as marker 3 (line 4)
  hint: remove one of the two; a point can have one partner only
2 mistakes
",
    );
}

#[test]
fn too_few_markers() {
    let project = Project::new();
    project.edit("identity", "nonrigid_fit");
    project.edit("output:", "markers: m.cons\noutput:");
    project.write("m.cons", "2\n0, 0\n1, 1\n");
    says(&project, "check", 78, "
error: p.yaml:5:10: nonrigid_fit needs at least 3 markers, there are 2
   |
 5 | markers: m.cons
   |          ^^^^^^
   = hint: a marker is a point of the source and the same point of the target: `markers: pairs.cons` (a count, then `source, target` vertices from 0)
");
}

#[test]
fn a_marker_without_a_side() {
    let project = Project::new();
    project.edit("output:", "markers: m.yaml\noutput:");
    project.write("m.yaml", "markers:\n  - { name: left ear, source: 3 }\n");
    says(
        &project,
        "check",
        65,
        "
error: m.yaml:2:5: marker left ear has no target
   |
 2 |   - { name: left ear, source: 3 }
   |     ^^^^^^^^^^^^^^^^^^^^^^^^^^^^
   = hint: write the vertex of the target at the same place, e.g. `{ source: 750, target: 3386 }`
",
    );
}

#[test]
fn markers_of_a_mesh_that_has_changed_are_a_warning() {
    let project = Project::new();
    project.edit("output:", "markers: m.yaml\noutput:");
    project.write("m.yaml", "source: { mesh: rest.obj, vertices: 8, blake3: \"00\" }\ntarget: { mesh: target.obj, vertices: 9 }\nmarkers: []\n");
    says(
        &project,
        "check",
        0,
        "
warning: m.yaml: the source (rest.obj) has changed since the markers were made; the numbers may not fit any more: `mimesh markers reattach` carries them over
warning: m.yaml: made on a target of 9 vertices (target.obj), which now has 8; the numbers may not fit any more: `mimesh markers reattach` carries them over
",
    );
}

#[test]
fn several_mistakes_at_once() {
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
    says(
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
   = hint: formats that write: .glb, .gltf, .obj, .ply
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
    says(
        &project,
        "check",
        78,
        "
error: p.yaml:3:51: `smoothness`: expected a number, found the text \"much\"
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
fn yaml_that_is_none() {
    let project = Project::new();
    project.write("p.yaml", &format!("{PIPELINE}truth: [a, b\n"));
    let said = project.mimesh(&["check", "p.yaml"]);
    assert!(said.err.starts_with("error: p.yaml:"), "{}", said.err);
    assert!(said.err.contains(": not valid YAML: "), "{}", said.err);
    assert_eq!(said.status, 78);
}

#[test]
fn a_target_of_several_components() {
    let project = Project::new();
    // A box with a vertex in the middle of a side, and two plain ones beside it.
    let body = cube(|p| p).replace("f 5 6 8 7", "v 0.5 1 3\nf 5 6 9\nf 6 8 9\nf 8 7 9\nf 7 5 9");
    let eye = |name: &str, first: u32| {
        let moved = cube(|[x, y, z]| [x + f64::from(first), y, z]);
        let line = |line: &str| match line.strip_prefix("f ") {
            Some(corners) => {
                let corners = corners.split(' ').map(|v| (v.parse::<u32>().unwrap() + first).to_string());
                format!("f {}\n", corners.collect::<Vec<_>>().join(" "))
            }
            None => format!("{line}\n"),
        };
        format!("o {name}\n{}", moved.lines().map(line).collect::<String>())
    };
    project.write("target.obj", &format!("o body\n{body}{}{}", eye("left_eye", 9), eye("right_eye", 17)));
    project.edit("identity", "nonrigid_fit");
    project.edit("copy_displacement", "gradient");
    project.edit("output:", "markers: m.cons\noutput:");
    project.write("m.cons", "4\n0, 0\n1, 1\n2, 2\n4, 4\n");
    says(
        &project,
        "check",
        65,
        "
error: p.yaml:3:17: correspondence (nonrigid_fit): 2 of the target's 3 components have no marker: left_eye (8 vertices, from vertex 9), right_eye (8 vertices, from vertex 17)
   |
 3 | correspondence: { type: nonrigid_fit }
   |                 ^^^^^^^^^^^^^^^^^^^^^
   = hint: link them with `proximity: { type: spanning_tree }` and move them with `transfer: { type: multi_component }`, give each a marker, or remove loose parts
error: p.yaml:4:11: transfer (gradient): the target has 3 components, and gradients say nothing of how they lie to each other; beside the largest: left_eye (8 vertices, from vertex 9), right_eye (8 vertices, from vertex 17)
   |
 4 | transfer: { type: gradient }
   |           ^^^^^^^^^^^^^^^^^
   = hint: use `proximity: { type: spanning_tree }` and `transfer: { type: multi_component }`, or join or remove the loose parts
2 mistakes
",
    );
}

#[test]
fn markers_on_one_line() {
    let project = Project::new();
    project.edit("identity", "nonrigid_fit");
    project.edit("output:", "markers: m.yaml\noutput:");
    // Triangle 1 is that of the corners 0, 3 and 1.
    project.write(
        "m.yaml",
        "markers:\n  - { source: 0, target: 0 }\n  - { source: 1, target: 3 }\n  \
         - { source: { triangle: 1, barycentric: [0.5, 0, 0.5] }, target: 4 }\n",
    );
    says(
        &project,
        "check",
        65,
        "
error: p.yaml:3:17: correspondence (nonrigid_fit): the 3 markers lie on one line on the source: expected points that span the shape
   |
 3 | correspondence: { type: nonrigid_fit }
   |                 ^^^^^^^^^^^^^^^^^^^^^
   = hint: add markers away from that line
",
    );
}

#[test]
fn later_mistakes_in_lists() {
    let project = Project::new();
    project.edit("pose-*.obj", "[pose-1.obj, 2, pose-3.obj]");
    project.edit("out/{pose}.obj", "[1, out/all.obj, 2]");
    project.edit(
        "output:",
        "truth: \"{pose}.obj\"\nmetrics: [{ type: pont_error }, { tipe: x }]\nformats: [{ type: obj, turn_normals: 7 }, { type: gif }]\noutput:",
    );
    says(
        &project,
        "check",
        78,
        "
error: p.yaml:1:47: `poses`: expected a text, found 2
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
   = hint: known types: area_change, closure, component_gaps, component_motion, contact_slide, edge_stretch, flipped_triangles, jitter, map_tears, marker_fit, point_error, self_intersections, volume
error: p.yaml:7:38: `turn_normals`: expected true or false, found 7
   |
 7 | formats: [{ type: obj, turn_normals: 7 }, { type: gif }]
   |                                      ^
error: p.yaml:7:51: unknown format `gif`
   |
 7 | formats: [{ type: obj, turn_normals: 7 }, { type: gif }]
   |                                                   ^^^
   = hint: known types: glb, gltf, obj, ply, stl
error: p.yaml:8:10: `output`: expected a text, found 1
   |
 8 | output: [1, out/all.obj, 2]
   |          ^
error: p.yaml:8:13: a .obj file holds one pose, so its name needs `{pose}`
   |
 8 | output: [1, out/all.obj, 2]
   |             ^^^^^^^^^^^
   = hint: e.g. `all-{pose}.obj`
error: p.yaml:8:26: `output`: expected a text, found 2
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
    says(
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
    says(
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
fn a_folder_for_results_that_is_none() {
    let project = Project::new();
    let said = project.mimesh(&["run", "p.yaml", "--out", "rest.obj"]);
    let expected = "error: --out rest.obj: cannot write rest.obj/1.obj: rest.obj is not a folder\n  \
                    hint: choose another folder for `--out`\n";
    assert_eq!((said.status, said.err.as_str()), (73, expected));
}

#[test]
fn a_target_without_area() {
    let project = Project::new();
    project.write("target.obj", &cube(|[x, ..]| [x, 2.0 * x, 0.0]));
    says(
        &project,
        "check",
        65,
        "
error: target.obj: the mesh has no area: all vertices lie on a line
  hint: export the mesh again with its shape
",
    );
}

#[test]
fn a_target_inside_out_is_a_warning() {
    let project = Project::new();
    project.write("target.obj", &cube(|[x, y, z]| [-x, y, z]));
    says(
        &project,
        "check",
        0,
        "
warning: the target (target.obj) is inside out: its faces point inwards, those of the other mesh outwards; reverse its faces if few partners are found
",
    );
}
