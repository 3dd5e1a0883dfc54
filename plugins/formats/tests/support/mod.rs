//! What the tests of several formats share.
#![allow(dead_code, reason = "every test file takes what it needs")]

pub mod fbx;
pub mod gltf;

use std::path::Path;

use mimesh_core::{
    Error,
    mesh::{Mesh, MeshSequence},
    stage::{BytesInput, Format, MeshWriter, Selection},
    testkit::data::input,
    testkit::memory_file::MemoryFile,
};
use nalgebra::{Point3, Rotation3, Vector3};

/// Reads `bytes` as a file called `name`.
pub fn read(format: &dyn Format, name: &str, bytes: &[u8]) -> Result<MeshSequence, Error> {
    format.read(&BytesInput::new(name, bytes), &Selection::default())
}

/// What `format` writes for `mesh` at `positions`.
pub fn write(format: &dyn Format, mesh: &Mesh, positions: &[Point3<f64>]) -> Vec<u8> {
    let mut out = Vec::new();
    match format.writer().unwrap() {
        MeshWriter::Pose(writer) => writer.write(mesh, positions, &mut out).unwrap(),
        MeshWriter::Sequence(format) => {
            let file = MemoryFile::default();
            let mut writer = format.start(mesh, 1, Box::new(file.clone())).unwrap();
            writer.add("pose", None, positions).unwrap();
            writer.finish().unwrap();
            out = file.bytes();
        }
    }
    out
}

/// The message of an error without the folder, and its hint.
pub fn message(error: &Error) -> String {
    let text = error.to_string();
    let text = text
        .rsplit_once('/')
        .map_or(text.as_str(), |(folder, rest)| if folder.starts_with('/') { rest } else { &text });
    format!("{text}\n{}", error.hint().unwrap_or_default())
}

/// A twisted, moved copy of `positions`.
pub fn twisted(positions: &[Point3<f64>]) -> Vec<Point3<f64>> {
    let diagonal = mimesh_core::mesh::diagonal(positions);
    let twist = |p: &Point3<f64>| Rotation3::from_axis_angle(&Vector3::y_axis(), 2.0 * p.y / diagonal) * p;
    positions.iter().map(|p| twist(p) + Vector3::new(0.1, -0.2, 0.3) * diagonal).collect()
}

/// Reads the file at `path` with those that it refers to.
pub fn read_file(format: &dyn Format, path: &Path) -> MeshSequence {
    format.read(&input(path), &Selection::default()).unwrap()
}

/// The largest distance between two lists of positions.
pub fn distance(a: &[Point3<f64>], b: &[Point3<f64>]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
}

/// A grid of quads with a fold: `n` × `n` vertices.
pub fn grid(n: usize) -> Mesh {
    let place = |i: usize| {
        let (x, y) = ((i % n) as f64 / (n - 1) as f64, (i / n) as f64 / (n - 1) as f64);
        Point3::new(x, y, 0.3 * (3.0 * x * y).sin())
    };
    let mut mesh = Mesh { positions: (0..n * n).map(place).collect(), ..Mesh::default() };
    for row in 0..n - 1 {
        for column in 0..n - 1 {
            let v = (row * n + column) as u32;
            mesh.polygons.push(&[v, v + 1, v + 1 + n as u32, v + n as u32]);
        }
    }
    mesh
}
