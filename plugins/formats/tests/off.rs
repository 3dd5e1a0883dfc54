//! OFF: its kinds, what comes back, and what damaged files say.

mod support;

use std::path::Path;

use mimesh_core::stage::{BytesInput, Format, MeshWriter, Selection};
use mimesh_formats::{Off, Ply};
use nalgebra::Point3;
use proptest::prelude::*;
use support::{distance, grid, message, read, twisted, write};

const PLAIN: &str = "OFF\n4 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 .5\n3 0 1 2\n3 0 2 3\n";

#[test]
fn files_may_be_written_in_any_way() {
    let expected = read(&Off::default(), "a.off", PLAIN.as_bytes()).unwrap().rest;
    assert_eq!(expected.positions[3], Point3::new(0.0, 1.0, 0.5));
    assert_eq!(expected.polygons.corners(), [0, 1, 2, 0, 2, 3]);
    let utf_16: Vec<u8> = PLAIN.encode_utf16().flat_map(u16::to_le_bytes).collect();
    let variants: Vec<Vec<u8>> = vec![
        PLAIN.replace("OFF\n", "").into(),
        PLAIN.replace("OFF\n", "OFF ").into(),
        PLAIN.replace("2 0\n", "2\n").into(),
        PLAIN.replace('\n', " # of no matter\n\n# nor this\n").into(),
        PLAIN.replace('\n', "\r\n").into(),
        PLAIN.replace('\n', "\r").into(),
        PLAIN.replace("1 1 0", "1\n1.\n 0").into(),
        PLAIN.replace("3 0 1 2", "3\n0 1\n2").into(),
        [b"# caf\xe9\n", PLAIN.as_bytes()].concat(),
        utf_16,
    ];
    for bytes in variants {
        let text = String::from_utf8_lossy(&bytes).into_owned();
        let mesh = read(&Off::default(), "a.off", &bytes).unwrap_or_else(|error| panic!("{error}: {text}")).rest;
        assert_eq!((&mesh.positions, &mesh.polygons), (&expected.positions, &expected.polygons), "{text}");
    }
}

#[test]
fn normals_colours_and_texture_coordinates_of_vertices_come_back() {
    let kinds = [
        ("NOFF", " 0 0 1"),
        ("COFF", " 255 51 0 255"),
        ("COFF", " 1.0 0.25 0.0 1"),
        ("STOFF", " 0.25 0.5"),
        ("STCNOFF", " 0 0 1 255 51 0 255 0.25 0.5"),
        ("OFF", " 255 51 0"),
    ];
    for (kind, behind) in kinds {
        let text = format!("{kind}\n3 1 0\n0 0 0{behind}\n1 0 0{behind}\n0 1 0{behind}\n3 0 1 2 255 0 0\n");
        let mesh = read(&Off::default(), "a.off", text.as_bytes()).unwrap().rest;
        assert_eq!(mesh.normals.as_ref().map(|n| n.values[2]), kind.contains('N').then_some([0.0, 0.0, 1.0]), "{kind}");
        let textures = mesh.texture_coordinates.as_ref();
        assert_eq!(textures.map(|t| t.values[2]), kind.contains("ST").then_some([0.25, 0.5]), "{kind}");
        let green = if behind.contains("0.25 0.0") { 0.25 } else { 0.2 };
        let is_colored = kind.contains('C') || kind == "OFF";
        let colors = mesh.vertex_colors.as_ref().map(|colors| colors[2]);
        assert_eq!(colors, is_colored.then_some([1.0, green, 0.0, 1.0]), "{kind}");
        let back = read(&Off::default(), "b.off", &write(&Off::default(), &mesh, &mesh.positions)).unwrap().rest;
        assert_eq!((&back.normals, &back.texture_coordinates), (&mesh.normals, &mesh.texture_coordinates));
        assert_eq!(back.vertex_colors, mesh.vertex_colors);
        // The colour of the face is red in the PLY too.
        let ply = String::from_utf8_lossy(&write(&Ply::default(), &mesh, &mesh.positions)).into_owned();
        assert!(ply.split_once("element face").unwrap().1.contains(" red\n"), "{kind}");
        let off = Off::default();
        let Some(MeshWriter::Pose(writer)) = off.writer() else { unreachable!("an OFF holds one pose") };
        assert_eq!(writer.warnings(Path::new(""), &mesh), Vec::<String>::new());
    }
}

#[test]
fn damaged_and_other_offs_say_what_is_wrong() {
    let cases = [
        (PLAIN.replace("3 0 2 3", "3 0 2 4"), "a.off:8: not an OFF: face 1 (from 0) refers to vertex 4: there are 4"),
        (PLAIN.replace("3 0 2 3\n", ""), "a.off:7: not an OFF: the file ends in face 1 (from 0)"),
        (PLAIN.replace("1 1 0", "1 x 0"), "a.off:5: not an OFF: `x` of vertex 2 (from 0) is no number"),
        (PLAIN.replace("1 1 0", "1 1 0 7"), "a.off:5: not an OFF: vertex 2 (from 0) has 1 numbers too many"),
        (PLAIN.replace("1 1 0", "1 nan 0"), "a.off:5: not an OFF: `nan` of vertex 2 (from 0) is no finite number"),
        ("OFF\n2 0 0\n0 0 0\n1 1 1\n".into(), "a.off: empty mesh: 2 vertices, 0 faces"),
        (
            "4OFF\n1 0 0\n0 0 0 0\n".into(),
            "a.off:1: the kinds `4OFF` and `nOFF` have vertices with other than three coordinates",
        ),
        ("OFF BINARY\n\0\0".into(), "a.off:1: binary OFF is not read"),
        (String::new(), "a.off:1: not an OFF: the file ends in header 0"),
    ];
    for (text, expected) in cases {
        let error = message(&read(&Off::default(), "a.off", text.as_bytes()).unwrap_err());
        assert!(error.starts_with(expected), "{error}");
    }
    let short = read(&Off::default(), "a.off", PLAIN.replace("3 0 2 3", "2 0 2").as_bytes()).unwrap();
    assert_eq!(short.warnings, ["1 faces of fewer than three corners are left out"]);
}

#[test]
fn vertices_alone_are_a_pose_of_the_same_vertices() {
    let rest = read(&Off::default(), "a.off", PLAIN.as_bytes()).unwrap().rest;
    let selection = Selection { same_vertices: true, ..Selection::default() };
    let points = BytesInput::new("b.off", "OFF\n4 0 0\n0 0 0\n1 0 0\n1 1 0\n0 1 .5\n");
    assert_eq!(Off::default().read_pose(&points, &selection, &rest).unwrap(), rest.positions);
    Off::default().read_pose(&points, &Selection::default(), &rest).unwrap_err();
}

proptest! {
    #[test]
    fn a_mesh_keeps_its_positions_to_1e_9_of_its_diagonal(scale in -12..12) {
        let mut mesh = grid(4);
        let scale = 10_f64.powi(scale);
        mesh.positions.iter_mut().for_each(|p| *p *= scale);
        let posed = twisted(&mesh.positions);
        let back = read(&Off::default(), "a.off", &write(&Off::default(), &mesh, &posed)).unwrap().rest;
        prop_assert_eq!(&back.polygons, &mesh.polygons);
        // Half a decimal of at most 1e-9 of the diagonal in each of three coordinates.
        prop_assert!(distance(&back.positions, &posed) <= 1e-9 * mesh.diagonal());
    }

    #[test]
    fn no_damage_makes_the_reader_panic(
        edits in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..6),
        cut in any::<prop::sample::Index>(),
    ) {
        let mut bytes = b"STCNOFF\n3 1 0\n0 0 0 0 0 1 255 51 0 255 0.25 0.5\n1 0 0 0 0 1 1 2 3 4 0 1\n0 1 0 0 0 1 1 2 3 4 0 1\n3 0 1 2 1 0 0\n".to_vec();
        edits.iter().for_each(|(at, byte)| { let at = at.index(bytes.len()); bytes[at] = *byte; });
        for bytes in [&bytes[..], &bytes[..cut.index(bytes.len())]] {
            if let Ok(sequence) = read(&Off::default(), "a.off", bytes) {
                sequence.rest.validate().unwrap();
            }
        }
    }
}
