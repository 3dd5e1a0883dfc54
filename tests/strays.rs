//! Vertices that no face uses set no scale: with and without them everything is the same to the last bit.
#![cfg(feature = "bundled")]

mod common;

use std::fmt::Write;

use common::{
    Project,
    ellipsoid::{ellipsoid, obj},
};
use mimesh::core::testkit::data::data;
use nalgebra::{Point3, Rotation3, Vector3};
use serde_json::Value;

/// Markers by vertex and by position, pictures, errors, gates and metrics that look at the size of meshes.
const PIPELINE: &str = "\
source: { rest: rest.obj, poses: pose-*.obj }
target: { rest: target.obj }
truth: truth-{pose}.obj
markers: { source: source.csv, target: target.csv }
correspondence: { type: nonrigid_fit }
metrics: [ { type: edge_stretch }, { type: self_intersections }, { type: jitter }, { type: volume } ]
gates: { point_error: 50 }
output: [ out/{pose}.obj, out/sheet.png ]
";

/// The OBJ `text` with a stray vertex before and one behind its own.
fn with_strays(text: &str) -> String {
    let (vertices, faces): (Vec<&str>, Vec<&str>) = text.lines().partition(|line| line.starts_with("v "));
    let mut with = format!("v 1000 1000 1000\n{}\nv -5000 0 0\n", vertices.join("\n"));
    for face in faces {
        let corners = face.split(' ').skip(1).map(|corner| corner.parse::<usize>().expect("a corner") + 1);
        let _ = writeln!(with, "f {}", corners.map(|corner| corner.to_string()).collect::<Vec<_>>().join(" "));
    }
    with
}

/// Two ellipsoids of different triangles, bent, with points by position.
fn write(project: &Project, transfer: &str, change: fn(&str) -> String) {
    let bent = |points: &[Point3<f64>], bend: f64| -> Vec<Point3<f64>> {
        points.iter().map(|p| Rotation3::from_axis_angle(&Vector3::x_axis(), bend * p.z) * p).collect()
    };
    let (source, target) = (ellipsoid(8, 12), ellipsoid(9, 14));
    project.write("rest.obj", &change(&obj(&source.0, &source.1)));
    project.write("target.obj", &change(&obj(&target.0, &target.1)));
    std::fs::remove_file(project.path("pose-10.obj")).expect("a pose of the common project");
    for (pose, bend) in [("1", 0.1), ("2", 0.2), ("3", 0.25)] {
        project.write(&format!("pose-{pose}.obj"), &change(&obj(&bent(&source.0, bend), &source.1)));
        project.write(&format!("truth-{pose}.obj"), &change(&obj(&bent(&target.0, bend), &target.1)));
    }
    let points: String = (0..8)
        .map(|corner| [1.0, 2.0, 4.0].map(|bit: f64| if corner & bit as usize > 0 { 1.0 } else { -1.0 }))
        .enumerate()
        .map(|(i, [x, y, z])| (i, Vector3::new(x, y, z) / 3f64.sqrt()))
        .map(|(i, d)| format!("p{i},{},{},{}\n", 0.97 * d.x, 2.0 * 0.97 * d.y, 3.0 * 0.97 * d.z))
        .collect();
    ["source.csv", "target.csv"].iter().for_each(|name| project.write(name, &format!("name,x,y,z\n{points}")));
    project.write("p.yaml", &format!("{PIPELINE}transfer: {transfer}\n"));
}

fn run(project: &Project) -> Value {
    let output = project.mimesh(&["run", "p.yaml", "--json"]);
    assert_eq!(output.status, 0, "{}", output.stderr);
    output.json()
}

/// The `v` lines of a file.
fn vertices(text: &str) -> Vec<&str> {
    text.lines().filter(|line| line.starts_with("v ")).collect()
}

#[test]
fn no_figure_no_map_and_no_vertex_depends_on_strays() {
    for transfer in ["{ type: gradient }", "{ type: biharmonic }", "{ type: multi_component }"] {
        let (plain, strays) = (Project::new(), Project::new());
        let proximity = if transfer.contains("multi") { "proximity: { type: spanning_tree }\n" } else { "" };
        write(&plain, &format!("{transfer}\n{proximity}keep_correspondence: out/map.json"), str::to_owned);
        write(&strays, &format!("{transfer}\n{proximity}keep_correspondence: out/map.json"), with_strays);
        let (expected, found) = (run(&plain), run(&strays));
        for (a, b) in expected["poses"].as_array().unwrap().iter().zip(found["poses"].as_array().unwrap()) {
            let mut b = b.clone();
            for metric in ["map_collapse", "rest_difference"] {
                if let Some(worst) = b.pointer_mut(&format!("/metrics/{metric}/worst")) {
                    // A vertex as the file counts, in which a stray comes first.
                    *worst = (worst.as_u64().expect("a vertex") - 1).into();
                }
            }
            for key in ["metrics", "figures", "verdict", "nothing"] {
                assert_eq!(a[key], b[key], "{transfer}: {key}");
            }
        }
        for key in ["diagonal", "components"] {
            assert_eq!(expected["target"][key], found["target"][key], "{transfer}: {key}");
        }
        assert_eq!(plain.bytes("out/sheet.png"), strays.bytes("out/sheet.png"), "{transfer}: pictures");
        if !transfer.contains("biharmonic") {
            assert_eq!(plain.read("out/map.json"), strays.read("out/map.json"), "{transfer}: the correspondence");
        }
        for pose in ["1", "2", "3"] {
            let name = format!("out/{pose}.obj");
            let (plain, strays) = (plain.read(&name), strays.read(&name));
            let strays = vertices(&strays);
            assert_eq!(vertices(&plain), strays[1..strays.len() - 1], "{transfer}: {name}");
        }
    }
}

#[test]
fn points_far_off_the_faces_are_refused_whatever_strays_there_are() {
    let project = Project::new();
    write(&project, "{ type: gradient }", with_strays);
    // 39 units off, half a percent of the way to the strays.
    project.write("target.csv", &project.read("target.csv").replace("p0,-0.", "p0,-39."));
    let output = project.mimesh(&["check", "p.yaml"]);
    assert_eq!(output.status, 65, "{}", output.stderr);
    assert!(output.stderr.contains("of the diagonal off the target: expected 5 % at most"), "{}", output.stderr);
    project.write("m.cons", "8\n0, 0\n1, 1\n2, 2\n3, 3\n4, 4\n5, 5\n6, 6\n7, 7\n");
    project.edit("markers: { source: source.csv, target: target.csv }", "markers: m.cons");
    let output = project.mimesh(&["check", "p.yaml"]);
    assert!(output.stderr.contains("vertex 0 of the source belongs to no polygon"), "{}", output.stderr);
}

#[test]
fn errors_are_relative_to_the_faces() {
    let Some(reports) = data("reports") else { return };
    let project = Project::new();
    let file = |name: &str| reports.join(name).display().to_string();
    let score = [file("unref_bad-02.obj"), file("unref_truth-02.obj")];
    let output = project.mimesh(&["score", "--rest", &file("obj_unref.obj"), &score[0], &score[1], "--json"]);
    let mean = output.json()["poses"][0]["score"]["mean"].as_f64().expect("a mean");
    // The known answer has four digits.
    assert!((mean - 7.773).abs() < 5e-4, "{mean}");
    let inspected = project.mimesh(&["inspect", &file("obj_unref.obj"), "--json"]).json();
    assert!(inspected["statistics"]["diagonal"].as_f64().expect("a length") < 10.0, "{inspected}");
}
