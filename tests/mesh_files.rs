//! Mesh files that are not what they seem, poses of other faces, and what is told of results.
#![cfg(feature = "bundled")]

mod common;

use common::{PIPELINE, Project, leaning};

/// An OBJ as PLY.
fn ply(obj: &str) -> String {
    let lines = |keyword: &str| -> Vec<String> {
        obj.lines().filter_map(|line| line.strip_prefix(keyword)).map(str::to_owned).collect()
    };
    let (vertices, faces) = (lines("v "), lines("f "));
    let mut text = format!("ply\nformat ascii 1.0\nelement vertex {}\n", vertices.len());
    text += "property float x\nproperty float y\nproperty float z\n";
    text += &format!("element face {}\nproperty list uchar int vertex_indices\nend_header\n", faces.len());
    vertices.iter().for_each(|line| text += &format!("{line}\n"));
    for face in faces {
        let corners: Vec<_> = face.split(' ').map(|corner| (corner.parse::<u32>().unwrap() - 1).to_string()).collect();
        text += &format!("{} {}\n", corners.len(), corners.join(" "));
    }
    text
}

fn project(pipeline: &str) -> Project {
    let project = Project::new();
    project.write("rest.obj", &leaning(0.0));
    project.write("target.obj", &leaning(0.0));
    project.write("pose-1.obj", &leaning(0.5));
    project.write("pose-2.obj", &leaning(1.0));
    project.write("p.yaml", pipeline);
    project
}

#[test]
fn a_file_under_a_wrong_extension_is_read_by_its_contents_and_told_once() {
    let project = project(PIPELINE);
    let plain = project.mimesh(&["run", "p.yaml"]);
    assert_eq!(plain.status, 0, "{}", plain.stderr);
    let expected = project.read("out/2.obj");
    for file in ["pose-1.obj", "pose-2.obj", "rest.obj"] {
        let text = project.read(file);
        project.write(file, &ply(&text));
    }
    let output = project.mimesh(&["run", "p.yaml"]);
    assert_eq!(output.status, 0, "{}", output.stderr);
    let told = "by its contents the file is a PLY, not an OBJ: it is read as such";
    assert_eq!(output.stderr.matches(told).count(), 1, "{}", output.stderr);
    assert_eq!(project.read("out/2.obj"), expected);
    // An extension that no format has is an error that knows better.
    project.write("rest.dat", &ply(&leaning(0.0)));
    project.write("p.yaml", &PIPELINE.replace("rest: rest.obj", "rest: rest.dat"));
    let output = project.mimesh(&["check", "p.yaml"]);
    assert_ne!(output.status, 0);
    assert!(output.stderr.contains("by its contents it is a PLY: rename it to .ply"), "{}", output.stderr);
}

#[test]
fn poses_of_other_faces_are_taken_on_request() {
    let project = project(PIPELINE);
    let plain = project.mimesh(&["run", "p.yaml"]);
    assert_eq!(plain.status, 0, "{}", plain.stderr);
    let expected = [project.read("out/1.obj"), project.read("out/2.obj")];
    // The first with its faces turned, the second with none.
    let turned = leaning(0.5).replace("f 1 3 4 2", "f 3 4 2 1");
    project.write("pose-1.obj", &turned);
    let vertices: String =
        leaning(1.0).lines().filter(|line| line.starts_with('v')).map(|l| format!("{l}\n")).collect();
    project.write("pose-2.obj", &vertices);
    let refused = project.mimesh(&["run", "p.yaml"]);
    assert_ne!(refused.status, 0);
    assert!(refused.stderr.contains("same_vertices: true"), "{}", refused.stderr);
    for poses in
        ["{ files: 'pose-*.obj', same_vertices: true }", "{ same_vertices: true, files: [pose-1.obj, pose-2.obj] }"]
    {
        project.write("q.yaml", &PIPELINE.replace("pose-*.obj", poses));
        let output = project.mimesh(&["run", "q.yaml"]);
        assert_eq!(output.status, 0, "{}", output.stderr);
        let names = if poses.starts_with("{ files") {
            ["out/1.obj", "out/2.obj"]
        } else {
            ["out/pose-1.obj", "out/pose-2.obj"]
        };
        assert_eq!(names.map(|name| project.read(name)), expected);
    }
    project.write("q.yaml", &PIPELINE.replace("pose-*.obj", "{ files: 'pose-*.obj', same_vertex: true }"));
    let output = project.mimesh(&["check", "q.yaml"]);
    assert!(output.stderr.contains("same_vertices"), "{}", output.stderr);
}

#[test]
fn what_results_leave_out_is_told_once() {
    let project = project(&PIPELINE.replace("output: out/{pose}.obj", "output: ['out/{pose}.stl', 'out/{pose}.obj']"));
    project.write("target.obj", &format!("mtllib skin.mtl\ng head\n{}", leaning(0.0)));
    project.write("skin.mtl", "newmtl skin\n");
    let output = project.mimesh(&["run", "p.yaml"]);
    assert_eq!(output.status, 0, "{}", output.stderr);
    let told = "left out of STL: polygons of more than three corners, groups";
    assert_eq!(output.stderr.matches(told).count(), 1, "{}", output.stderr);
    assert_eq!(output.stderr.matches("../skin.mtl").count(), 1, "{}", output.stderr);
    for pose in ["1", "2"] {
        assert!(project.read(&format!("out/{pose}.obj")).starts_with("mtllib ../skin.mtl\n"));
    }
}
