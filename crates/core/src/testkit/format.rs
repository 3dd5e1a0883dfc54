//! The contract of formats.

use nalgebra::Point3;

use super::{
    memory_file::MemoryFile,
    support::{bent_bar, near_within, twisted},
};
use crate::{
    mesh::{Mesh, Polygons},
    stage::{BytesInput, Format, MeshWriter, Selection},
};

/// Formats may store 32-bit numbers.
const TOLERANCE: f64 = 1e-6;

/// The contract of [`Format`]: what it writes it reads back, and damage is an error that names the file.
pub fn format(name: &str, stage: &dyn Format) {
    let extensions = stage.extensions();
    assert!(!extensions.is_empty(), "{name}: no extension");
    let lower = |e: &&str| !e.is_empty() && e.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit());
    assert!(extensions.iter().all(lower), "{name}: extensions are lower case without a dot: {extensions:?}");
    let path = format!("mesh.{}", extensions[0]);

    let surface = bent_bar();
    let rest = Mesh::from_triangles(surface.positions.clone(), &surface.triangles);
    let Some(bytes) = written(name, stage, &rest, &twisted(&surface, 0.5)) else { return };
    if !stage.reads() {
        return;
    }
    let read = stage
        .read(&BytesInput::new(&path, &bytes[..]), &Selection::default())
        .unwrap_or_else(|error| panic!("{name}: {error}"));
    if !stage.keeps_vertices() {
        let corners = |mesh: &Mesh, positions: &[Point3<f64>]| -> Vec<_> {
            mesh.polygons.corners().iter().map(|&v| positions[v as usize]).collect()
        };
        let (back, expected) = (corners(&read.rest, &read.rest.positions), corners(&rest, &twisted(&surface, 0.5)));
        near_within(name, "posed corners come back", &back, &expected, TOLERANCE);
        damaged(name, stage, &path, &bytes);
        return;
    }
    let polygons = if stage.holds_faces() { rest.polygons.clone() } else { Polygons::default() };
    assert!(read.rest.polygons == polygons, "{name}: other polygons, or another order");
    let posed = match stage.writer() {
        Some(MeshWriter::Sequence(_)) => {
            if stage.holds_faces() {
                near_within(name, "rest positions come back", &read.rest.positions, &rest.positions, TOLERANCE);
            }
            read.poses.last().map(|pose| pose.positions.get().unwrap().into_owned()).unwrap_or_default()
        }
        _ => read.rest.positions,
    };
    near_within(name, "posed positions come back", &posed, &twisted(&surface, 0.5), TOLERANCE);
    damaged(name, stage, &path, &bytes);
}

fn written(name: &str, stage: &dyn Format, rest: &Mesh, posed: &[Point3<f64>]) -> Option<Vec<u8>> {
    let mut bytes = Vec::new();
    let written = match stage.writer()? {
        MeshWriter::Pose(writer) => writer.write(rest, posed, &mut bytes),
        MeshWriter::Sequence(format) => {
            let file = MemoryFile::default();
            let written = format.start(rest, 1, Box::new(file.clone())).and_then(|mut writer| {
                writer.add("posed", None, posed)?;
                writer.finish()
            });
            bytes = file.bytes();
            written
        }
    };
    written.unwrap_or_else(|error| panic!("{name}: {error}"));
    Some(bytes)
}

/// Files cut short anywhere are read as far as their format allows, or refused by name.
fn damaged(name: &str, stage: &dyn Format, path: &str, bytes: &[u8]) {
    for part in 0..16 {
        let input = BytesInput::new(path, &bytes[..bytes.len() * part / 16]);
        if let Err(error) = stage.read(&input, &Selection::default()) {
            let text = error.to_string();
            assert!(text.contains(path), "{name}: the error of a damaged file does not name it: {text}");
        } else {
            assert!(part > 0, "{name}: reads an empty file");
        }
    }
}
