//! What a user reads, in full, when a mesh or its markers are wrong.
#![cfg(feature = "bundled")]

mod common;

use common::{Project, assert_stderr, cube};

#[test]
fn a_pose_with_another_number_of_vertices() {
    let project = Project::new();
    for pose in ["1", "2", "10"] {
        project.write(&format!("pose-{pose}.obj"), &(cube(|p| p) + "v 0 0 0\n"));
    }
    project.edit("pose-*.obj", "pose-1.obj");
    assert_stderr(
        &project,
        "run",
        65,
        "
error: pose-1.obj: pose has 9 vertices, the rest mesh 8
  hint: a pose has the vertices and polygons of the rest mesh in the same order; export both with one setting
",
    );
}

#[test]
fn a_pose_with_another_face_list() {
    let project = Project::new();
    project.write("pose-2.obj", &cube(|p| p).replace("f 1 2 6 5", "f 2 6 5 1"));
    let output = project.mimesh(&["check", "p.yaml", "--poses"]);
    assert_eq!(
        output.stderr,
        "error: pose-2.obj: polygon 2 (from 0) differs: pose has vertices [1, 5, 4, 0], the rest mesh [0, 1, 5, 4]\n  \
         hint: a pose has the vertices and polygons of the rest mesh in the same order; export both with one setting, \
         or write `poses: { files: …, same_vertices: true }` if its vertices are in that order\n"
    );
    assert_eq!(output.status, 65);
}

#[test]
fn coordinates_that_are_not_finite() {
    let project = Project::new();
    project.write("rest.obj", &cube(|p| p).replace("v 1 0 0", "v 1 nan 0"));
    project.write("target.obj", &cube(|p| p).replace("v 0 2 0", "v 0 inf 0"));
    assert_stderr(
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
    assert_stderr(
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
    assert_stderr(
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
fn a_target_without_area() {
    let project = Project::new();
    project.write("target.obj", &cube(|[x, ..]| [x, 2.0 * x, 0.0]));
    assert_stderr(
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
    assert_stderr(
        &project,
        "check",
        0,
        "
warning: the target (target.obj) is inside out against the source (rest.obj): its faces point inwards, those of the source outwards; stages see both outwards, and results keep the faces of the file
",
    );
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
    assert_stderr(
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
fn markers_out_of_range_and_coincident() {
    let project = Project::new();
    project.edit("output:", "markers: m.cons\noutput:");
    project.write("m.cons", "4\n0, 0\n8, 1\n2, 2\n3, 2\n");
    assert_stderr(
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
    assert_stderr(&project, "check", 78, "
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
    assert_stderr(
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
    assert_stderr(
        &project,
        "check",
        0,
        "
warning: m.yaml: the source (rest.obj) has changed since the markers were made; the numbers may not fit any more: reattach the markers to carry them over
warning: m.yaml: made on a target of 9 vertices (target.obj), which now has 8; the numbers may not fit any more: reattach the markers to carry them over
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
    assert_stderr(
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
fn files_of_other_programs_are_named_with_a_way_to_convert_them() {
    let project = Project::new();
    let ways = [
        ("blend", "Blender"),
        ("abc", ".pc2 or .mdd"),
        ("usd", "Blender"),
        ("usda", "Blender"),
        ("usdc", "Blender"),
        ("usdz", "Blender"),
        ("max", "3ds Max"),
        ("ma", "Maya"),
        ("MB", "Maya"),
        ("c4d", "Cinema 4D"),
        ("dae", "assimp export"),
        ("3ds", "assimp export"),
        ("x3d", "assimp export"),
        ("wrl", "assimp export"),
        ("step", "FreeCAD"),
        ("bvh", "without a mesh"),
        ("vtk", "meshio convert"),
    ];
    for (extension, way) in ways {
        let file = format!("a.{extension}");
        project.write(&file, "");
        let output = project.mimesh(&["inspect", &file]);
        assert_eq!(output.status, 65, "{}", output.stderr);
        let lower = extension.to_lowercase();
        let message = format!("error: {file}: no format can read .{lower} files");
        assert!(output.stderr.starts_with(&message), "{}", output.stderr);
        assert!(output.stderr.contains(way) && output.stderr.contains("formats that read: "), "{}", output.stderr);
    }
}

#[test]
fn a_point_cache_is_no_mesh_but_gives_one_poses() {
    let project = Project::new();
    // One sample of the cube's eight vertices at the origin, as PC2.
    let mut cache = b"POINTCACHE2\0".to_vec();
    cache.extend([1_i32, 8].map(i32::to_le_bytes).concat());
    cache.extend([0_f32, 1.0].map(f32::to_le_bytes).concat());
    cache.extend(1_i32.to_le_bytes());
    cache.extend([0; 8 * 12]);
    std::fs::write(project.path("a.pc2"), cache).unwrap();
    let page = project.mimesh(&["inspect", "a.pc2"]);
    assert!(page.status == 0 && page.stdout.contains("poses       1: a\n"), "{}", page.stdout);
    let output = project.mimesh(&["transfer", "a.pc2", "target.obj", "-o", "x.glb"]);
    assert_eq!(output.status, 65);
    assert_eq!(
        output.stderr.trim_end(),
        "error: a.pc2: empty mesh: 8 vertices, 0 polygons\n  hint: give a mesh with at least one triangle; point clouds and curves cannot take a deformation, and a point cache has poses alone"
    );
}
