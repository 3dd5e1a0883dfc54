//! Seams: boundaries that coincide at rest are one, unless they part in the poses or the pipeline says so.
#![cfg(feature = "bundled")]

mod common;

use std::fmt::Write;

use common::Project;
use mimesh::core::{
    mesh::Mesh,
    testkit::{
        data::data,
        meshes::{mouth, open_mouth},
    },
};
use nalgebra::Point3;
use serde_json::Value;

/// Poses of a mouth, closed at rest, by how far it opens; the last is closed.
const POSES: [(&str, f64); 3] = [("ajar", 0.05), ("open", 0.2), ("shut", 0.0)];

fn obj(mesh: &Mesh, positions: &[Point3<f64>]) -> String {
    let mut text = String::new();
    positions.iter().for_each(|p| _ = writeln!(text, "v {} {} {}", p.x, p.y, p.z));
    for corners in mesh.polygons.iter() {
        let corners: Vec<String> = corners.iter().map(|v| (v + 1).to_string()).collect();
        let _ = writeln!(text, "f {}", corners.join(" "));
    }
    text
}

/// The mesh twice as large.
fn twice(positions: &[Point3<f64>]) -> Vec<Point3<f64>> {
    positions.iter().map(|p| p * 2.0).collect()
}

/// A mouth of 16 columns as the source, and one of `columns`, twice as large, as the target, with its known results.
fn mouths(columns: usize, target: &str, more: &str) -> Project {
    let project = Project::new();
    let (from, to) = (mouth(16), mouth(columns));
    project.write("rest.obj", &obj(&from, &from.positions));
    project.write("target.obj", &obj(&to, &twice(&to.positions)));
    for (pose, amount) in POSES {
        project.write(&format!("pose-{pose}.obj"), &obj(&from, &open_mouth(&from, amount)));
        project.write(&format!("truth-{pose}.obj"), &obj(&to, &twice(&open_mouth(&to, amount))));
    }
    std::fs::remove_file(project.path("pose-1.obj")).expect("a pose of the common project");
    std::fs::remove_file(project.path("pose-2.obj")).expect("a pose of the common project");
    std::fs::remove_file(project.path("pose-10.obj")).expect("a pose of the common project");
    project.write(
        "p.yaml",
        &format!(
            "source: {{ rest: rest.obj, poses: pose-*.obj }}\ntarget: {{ rest: target.obj{target} }}\ntruth: truth-{{pose}}.obj\n\
             transfer: {{ type: gradient }}\n{more}output: out/{{pose}}.obj\n"
        ),
    );
    project
}

fn run(project: &Project, more: &[&str]) -> Value {
    let output = project.mimesh(&[&["run", "p.yaml", "--json"], more].concat());
    assert_eq!(output.status, 0, "{}", output.stderr);
    output.json()
}

/// A statistic of `point_error` in a pose, and what the target at rest has in its place.
fn error(report: &Value, pose: &str, statistic: &str) -> [f64; 2] {
    let poses = report["poses"].as_array().expect("poses");
    let pose = poses.iter().find(|one| one["name"] == pose).expect("the pose");
    ["metrics", "nothing"].map(|of| pose[of]["point_error"][statistic].as_f64().expect("a statistic"))
}

#[test]
fn lips_that_the_poses_part_open_on_a_target_of_the_same_polygons() {
    let project = mouths(16, "", "correspondence: { type: identity }\n");
    let report = run(&project, &[]);
    for pose in ["ajar", "open"] {
        let [max, nothing] = error(&report, pose, "max");
        // A similar target takes the poses exactly, to the tolerance of the iterated least absolute values.
        assert!(max < 1e-2 * nothing, "{pose}: {max}, doing nothing {nothing}");
    }
    assert!(report["warnings"].as_array().is_none_or(Vec::is_empty), "{}", report["warnings"]);
    // Welded by hand, the lips stay closed, and it says so.
    let closed = run(&project, &["--set", "source.opened_seams=[]"]);
    let [max, nothing] = error(&closed, "open", "max");
    assert!(max > 0.9 * nothing, "{max}, doing nothing {nothing}");
    assert!(closed["warnings"].to_string().contains("opened_seams"), "{}", closed["warnings"]);
}

#[test]
fn lips_of_another_target_open_where_the_pipeline_names_them() {
    let fit = "markers: m.cons\ncorrespondence: { type: nonrigid_fit }\n";
    let project = mouths(12, "", fit);
    // Corners, and middles of edges, of both halves: 17 × 9 and 13 × 7 vertices a half.
    let at = |columns: u32, half: u32, x: u32, y: u32| {
        let (row, rows) = (columns + 1, columns / 2 + 1);
        half * row * rows + y * (rows - 1) / 2 * row + x * columns / 4
    };
    let places =
        [(0, 0, 0), (0, 2, 0), (0, 4, 0), (0, 0, 1), (0, 4, 1), (1, 0, 1), (1, 4, 1), (1, 0, 2), (1, 2, 2), (1, 4, 2)];
    let pairs: String = places.map(|(half, x, y)| format!("{}, {}\n", at(16, half, x, y), at(12, half, x, y))).concat();
    project.write("m.cons", &format!("{}\n{pairs}", places.len()));
    let closed = run(&project, &[]);
    assert!(closed["warnings"].to_string().contains("`opened_seams` in `target`"), "{}", closed["warnings"]);
    // The lower lip, without its corners: row 6 of the lower half, from x = -0.5 to 0.5.
    let lips = "target.opened_seams=[82, 83, 84, 85, 86]";
    let open = run(&project, &["--set", lips]);
    let [before, nothing] = error(&closed, "open", "max");
    let [after, _] = error(&open, "open", "max");
    println!("largest error in percent: closed {before}, open {after}, doing nothing {nothing}");
    assert!(after < 0.05 * nothing, "closed {before}, open {after}, doing nothing {nothing}");
}

#[test]
fn a_seam_that_does_not_exist_is_reported_at_its_place() {
    let project = mouths(16, ", opened_seams: [3, [144, 161]]", "correspondence: { type: identity }\n");
    let output = project.mimesh(&["check", "p.yaml"]);
    assert_eq!(output.status, 78, "{}", output.stderr);
    assert!(output.stderr.contains("p.yaml:2:44: no seam of the target is welded at vertex 3"), "{}", output.stderr);
    assert_eq!(output.stderr.matches("error: ").count(), 1, "144 and 161 lie at one place: {}", output.stderr);
}

#[test]
fn the_decision_is_cached_and_taken_by_every_reader_of_the_source() {
    let project = mouths(
        16,
        "",
        "correspondence: { type: identity }\nkey_points: { type: given, sampler: { type: given, vertices: [0, 5, 40] } }\n",
    );
    let entries = || project.mimesh(&["cache", "--json"]).json()["kept"]["opened_seams"]["entries"].as_u64();
    assert_eq!(entries(), None);
    project.mimesh(&["check", "p.yaml"]);
    assert_eq!(entries(), Some(1));
    let first = run(&project, &[]);
    project.mimesh(&["plan", "p.yaml"]);
    project.mimesh(&["keypoints", "p.yaml", "--output", "m.yaml"]);
    let again = run(&project, &[]);
    assert_eq!(entries(), Some(1), "nobody decides again");
    let is_reused = |pose: &Value| pose["reused"] == true;
    assert!(again["poses"].as_array().expect("poses").iter().all(is_reused));
    assert!(!first["poses"].as_array().expect("poses").iter().any(is_reused));
    // Another pose is another decision, and without the cache it is the same.
    let mesh = mouth(16);
    project.write("pose-shut.obj", &obj(&mesh, &open_mouth(&mesh, 0.01)));
    run(&project, &[]);
    assert_eq!(entries(), Some(2));
    let written = project.read("out/open.obj");
    run(&project, &["--no-cache"]);
    assert_eq!(project.read("out/open.obj"), written);
}

#[test]
fn triangles_apart_by_noise_are_one_surface_where_a_tolerance_is_given() {
    let Some(reports) = data("reports") else { return };
    let project = Project::new();
    let reports = reports.display();
    project.write(
        "p.yaml",
        &format!(
            "source: {{ rest: '{reports}/base.obj', poses: '{reports}/base-??.obj' }}\n\
             target: {{ rest: '{reports}/t_soup_jitter.obj' }}\ntruth: '{reports}/truth_soup-{{pose}}.obj'\n\
             correspondence: {{ type: nearest }}\ntransfer: {{ type: gradient }}\noutput: out/{{pose}}.obj\n"
        ),
    );
    let refused = project.mimesh(&["check", "p.yaml"]);
    assert_eq!(refused.status, 65, "{}", refused.stderr);
    assert!(refused.stderr.contains("1298 components"), "{}", refused.stderr);
    assert!(refused.stderr.contains("`weld_tolerance: 1e-5` in `target`"), "{}", refused.stderr);
    let report = run(&project, &["--set", "target.weld_tolerance=1e-5"]);
    assert_eq!(report["target"]["components"], 1);
    for pose in report["poses"].as_array().expect("poses") {
        let score = |of: &str| pose[of]["point_error"]["mean"].as_f64().expect("a mean");
        assert!(score("metrics") < 0.1 * score("nothing"), "{pose}");
    }
    // Larger than an edge: refused, and the edge is named.
    let output = project.mimesh(&["check", "p.yaml", "--set", "target.weld_tolerance=0.01"]);
    assert!(output.status != 0 && output.stderr.contains("larger than the edge between vertices"), "{}", output.stderr);
}
