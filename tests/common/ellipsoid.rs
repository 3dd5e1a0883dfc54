//! A project of two ellipsoids, for tests of markers.

use std::fmt::Write;

use mimesh::core::mesh::{Mesh, Surface};
pub use mimesh::core::testkit::meshes::ellipsoid;
use nalgebra::Point3;

use super::{Output, Project};

/// Triangles as a mesh and as a surface.
pub fn mesh(positions: &[Point3<f64>], triangles: &[[u32; 3]]) -> (Mesh, Surface) {
    let mesh = Mesh::from_triangles(positions.to_vec(), triangles);
    let surface = Surface::new(&mesh).expect("a surface");
    (mesh, surface)
}

/// The ellipsoid of [`project`], scaled by `factor`.
pub fn scaled(factor: f64) -> (Mesh, Surface) {
    let (positions, triangles) = ellipsoid(8, 12);
    mesh(&positions.iter().map(|p| p * factor).collect::<Vec<_>>(), &triangles)
}

/// The mesh as an OBJ.
pub fn obj(positions: &[Point3<f64>], triangles: &[[u32; 3]]) -> String {
    let mut text = String::new();
    for p in positions {
        let _ = writeln!(text, "v {} {} {}", p.x, p.y, p.z);
    }
    for [a, b, c] in triangles {
        let _ = writeln!(text, "f {} {} {}", a + 1, b + 1, c + 1);
    }
    text
}

/// A project with the ellipsoid as source and twice as large as target. `p.yaml` takes `markers`.
pub fn project(markers: &str) -> Project {
    let project = Project::new();
    let (positions, triangles) = ellipsoid(8, 12);
    project.write("source.obj", &obj(&positions, &triangles));
    let doubled: Vec<_> = positions.iter().map(|p| p * 2.0).collect();
    project.write("target.obj", &obj(&doubled, &triangles));
    project.write(
        "p.yaml",
        &format!(
            "source: {{ rest: source.obj, poses: source.obj }}\ntarget: {{ rest: target.obj }}\nmarkers: {markers}\n\
             correspondence: {{ type: identity }}\ntransfer: {{ type: copy_displacement }}\noutput: out/{{pose}}.obj\n"
        ),
    );
    project
}

/// The options that name the meshes of [`project`].
pub const MESHES: [&str; 4] = ["--source", "source.obj", "--target", "target.obj"];

/// Runs `mimesh markers COMMAND FILES OPTIONS`.
pub fn markers(project: &Project, command: &str, files: &[&str], options: &[&str]) -> Output {
    project.mimesh(&[&["markers", command][..], files, options].concat())
}

/// A vertex of the ellipsoid, scaled by `factor`.
pub fn position(vertex: usize, factor: f64) -> [f64; 3] {
    let p = ellipsoid(8, 12).0[vertex] * factor;
    [p.x, p.y, p.z]
}
