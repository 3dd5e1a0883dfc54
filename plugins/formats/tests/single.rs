//! A number beyond those that a format holds is refused by name, at rest and in a pose; it never becomes an infinity.

mod support;

use mimesh_core::{
    mesh::{CornerAttribute, Mesh},
    plugin::instances,
    stage::{Format, MeshWriter, WriteError},
    testkit::memory_file::MemoryFile,
};
use mimesh_formats as _;
use nalgebra::Point3;
use support::{grid, message};

/// Formats whose numbers are 64 bits wide or text.
const WIDE: [&str; 3] = ["obj", "off", "ply"];

/// What is said of writing `mesh` at `positions`.
fn refusal(format: &dyn Format, mesh: &Mesh, positions: &[Point3<f64>]) -> Option<String> {
    let written: Result<(), WriteError> = match format.writer()? {
        MeshWriter::Pose(writer) => writer.write(mesh, positions, &mut Vec::new()),
        MeshWriter::Sequence(writer) => writer
            .start(mesh, 1, Box::<MemoryFile>::default())
            .and_then(|mut file| file.add("pose", None, positions).and_then(|()| file.finish())),
    };
    match written {
        Ok(()) => None,
        Err(WriteError::Mesh(error)) => Some(message(&error)),
        Err(WriteError::Io(error)) => panic!("{error}"),
    }
}

#[test]
fn coordinates_beyond_32_bits_are_refused_where_there_are_no_others() {
    let mesh = grid(3);
    for (name, format) in instances::<dyn Format>() {
        if format.writer().is_none() || WIDE.contains(&name) {
            continue;
        }
        assert_eq!(refusal(&*format, &mesh, &mesh.positions), None, "{name}");
        let mut far = mesh.positions.clone();
        far[4].y = -1e39;
        let of_pose = refusal(&*format, &mesh, &far).unwrap_or_else(|| panic!("{name} takes a pose with 1e39"));
        assert!(of_pose.contains("beyond the numbers of") || of_pose.contains("32-bit"), "{name}: {of_pose}");
    }
}

#[test]
fn texture_coordinates_beyond_32_bits_are_refused_where_there_are_no_others() {
    let mut mesh = grid(3);
    let indices = vec![Some(0); mesh.polygons.corner_count()];
    mesh.texture_coordinates = Some(CornerAttribute { values: vec![[0.5, 1e39]], indices });
    let keeps: Vec<_> = instances::<dyn Format>()
        .into_iter()
        .filter_map(|(name, format)| Some((name, refusal(&*format, &mesh, &mesh.positions)?)))
        .collect();
    let names: Vec<_> = keeps.iter().map(|(name, _)| *name).collect();
    assert_eq!(names, ["glb", "gltf", "ply", "usda"], "{keeps:?}");
    assert!(keeps.iter().all(|(_, said)| said.contains("a texture coordinate is 1e39")), "{keeps:?}");
}
