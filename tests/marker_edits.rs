//! Markers mirrored and carried to edited meshes, as a user does it.

mod common;

use common::ellipsoid::{MESHES, ellipsoid, markers, obj, project};
use mimesh::{core::mesh::MeshPoint, markers as files};
use nalgebra::Point3;

#[test]
fn mirror_completes_a_symmetric_mesh_exactly_and_only_once() {
    let project = project("m.yaml");
    let (positions, _) = ellipsoid(8, 12);
    let partner = |v: usize| {
        let image = Point3::new(-positions[v].x, positions[v].y, positions[v].z);
        positions.iter().position(|p| *p == image).expect("a mirror image")
    };
    project.write(
        "m.yaml",
        &format!(
            "markers:\n  - {{ name: ear_L, source: 5, target: 5 }}\n  - {{ name: chin, source: 0, target: 0 }}\n  - {{ source: 40, target: 40 }}\n  \
             - {{ source: 70, target: 70 }}\n  - {{ source: {0}, target: {0} }}\n",
            partner(70)
        ),
    );
    let output = markers(&project, "mirror", &["m.yaml", "whole.yaml"], &MESHES);
    assert_eq!(output.status, 0, "{}", output.stderr);
    assert!(
        output.stdout.starts_with(
            "2 added, 2 have a partner, 1 lie on the plane, 0 left alone; 7 markers now\n  ear_L -> ear_R: 0.000 %"
        ),
        "{}",
        output.stdout
    );
    let whole = files::read_markers(&project.path("whole.yaml")).expect("markers");
    let added: Vec<_> = whole.pairs[5..].iter().map(|entry| (entry.name.clone(), entry.source, entry.target)).collect();
    let vertex = |v: usize| Some(MeshPoint::Vertex(partner(v) as u32));
    assert_eq!(added, [(Some("ear_R".into()), vertex(5), vertex(5)), (None, vertex(40), vertex(40))]);
    let output = markers(&project, "mirror", &["whole.yaml", "again.yaml"], &MESHES);
    assert!(output.stdout.starts_with("0 added, 6 have a partner, 1 lie on the plane"), "{}", output.stdout);
    assert_eq!(project.read("again.yaml"), project.read("whole.yaml"));
    // A plane elsewhere finds nothing on the other side.
    let output = markers(&project, "mirror", &["m.yaml", "off.yaml"], &[&MESHES[..], &["--source-offset=-2"]].concat());
    assert!(output.stdout.contains("ear_L: left alone, its mirror image lies"), "{}", output.stdout);
}

#[test]
fn markers_find_their_vertices_on_a_renumbered_mesh() {
    let project = project("m.yaml");
    project.write("m.cons", "3\n5, 5\n40, 40\n70, 70\n");
    assert_eq!(markers(&project, "convert", &["m.cons", "m.yaml"], &MESHES).status, 0);
    let same = markers(&project, "reattach", &["m.yaml", "same.yaml"], &MESHES);
    assert_eq!(same.status, 0, "{}", same.stderr);
    assert!(same.stdout.starts_with("source: unchanged\ntarget: unchanged\n"), "{}", same.stdout);
    assert_eq!(project.read("same.yaml"), project.read("m.yaml"));

    let (positions, triangles) = ellipsoid(8, 12);
    let last = positions.len() as u32 - 1;
    let backwards: Vec<_> = positions.iter().rev().map(|p| p * 2.0).collect();
    let renumbered: Vec<_> = triangles.iter().map(|t| t.map(|v| last - v)).collect();
    project.write("old.obj", &project.read("target.obj"));
    project.write("target.obj", &obj(&backwards, &renumbered));
    project.edit("identity", "nonrigid_fit");
    project.edit("copy_displacement", "gradient");
    let output = project.mimesh(&["check", "p.yaml"]);
    assert_eq!(
        output.stderr,
        "warning: m.yaml: the target (target.obj) has changed since the markers were made; 3 of 3 points no longer lie where \
         they were put: reattach the markers to carry them over\n"
    );
    let expected = format!("3\n5, {}\n40, {}\n70, {}\n", last - 5, last - 40, last - 70);
    let output = markers(&project, "reattach", &["m.yaml", "new.cons"], &["--pipeline", "p.yaml"]);
    assert_eq!(output.status, 0, "{}", output.stderr);
    assert!(
        output.stdout.contains("target: 3 points, the farthest moved by 0.000 % of the diagonal (3), 0 doubtful"),
        "{}",
        output.stdout
    );
    assert_eq!(project.read("new.cons"), expected);
    // A file without positions needs the old mesh.
    let output = markers(&project, "reattach", &["m.cons", "other.cons"], &MESHES);
    assert_eq!(output.status, 2);
    assert!(
        output.stderr.contains("the markers do not give the positions that their points of the source had"),
        "{}",
        output.stderr
    );
    let options = [&MESHES[..], &["--old-target", "old.obj"]].concat();
    assert_eq!(markers(&project, "reattach", &["m.cons", "other.cons"], &options).status, 0);
    assert_eq!(project.read("other.cons"), expected);
}

#[test]
fn points_that_move_are_doubtful_and_lost_points_an_error() {
    let project = project("m.yaml");
    project.write("m.cons", "3\n5, 5\n0, 0\n40, 40\n");
    assert_eq!(markers(&project, "convert", &["m.cons", "m.yaml"], &MESHES).status, 0);
    let (mut positions, triangles) = ellipsoid(8, 12);
    // The tip is cut down by 2 % of the diagonal of about 7.5.
    positions[0].z -= 0.15;
    positions.iter_mut().for_each(|p| *p *= 2.0);
    project.write("target.obj", &obj(&positions, &triangles));
    let output = markers(&project, "reattach", &["m.yaml", "new.yaml"], &MESHES);
    assert_eq!(output.status, 0, "{}", output.stderr);
    assert!(output.stdout.contains("source: unchanged\n"), "{}", output.stdout);
    assert!(output.stdout.contains("1 doubtful\n  2: moved by 2.1 % of the diagonal\n"), "{}", output.stdout);
    positions.iter_mut().for_each(|p| *p *= 100.0);
    project.write("target.obj", &obj(&positions, &triangles));
    let output = markers(&project, "reattach", &["m.yaml", "lost.yaml"], &MESHES);
    assert_eq!(output.status, 65);
    assert!(output.stderr.contains("they would fit times 100:"), "{}", output.stderr);
    assert!(!project.has("lost.yaml"));
}
