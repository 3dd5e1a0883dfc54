//! PLY and STL: what comes back, what real files hold, and what damaged files say.

mod support;

use mimesh_core::{
    mesh::{CornerAttribute, Mesh},
    stage::Format,
    testkit::data::data,
};
use mimesh_formats::{Encoding, Ply, Precision, Stl};
use nalgebra::{Point3, Vector3};
use proptest::prelude::*;
use support::{distance, grid, message, read, read_file, twisted, write};

const ENCODINGS: [Encoding; 3] = [Encoding::Ascii, Encoding::BinaryLittleEndian, Encoding::BinaryBigEndian];

#[test]
fn every_encoding_comes_back_to_its_precision() {
    let mut mesh = grid(5);
    mesh.polygons.push(&[0, 4, 24]);
    let posed = twisted(&mesh.positions);
    for encoding in ENCODINGS {
        // Half a unit in the last place of coordinates up to 2; a double is exact, as text to 5e-10 of the diagonal.
        for (precision, bound) in [(Precision::Float, 2.0 * f64::from(f32::EPSILON)), (Precision::Double, 1e-9)] {
            let ply = Ply { encoding, precision };
            let back = read(&ply, "a.ply", &write(&ply, &mesh, &posed)).unwrap().rest;
            assert_eq!(back.polygons, mesh.polygons);
            assert!(distance(&back.positions, &posed) <= bound, "{ply:?}");
        }
    }
}

#[test]
fn doubles_are_chosen_where_floats_would_not_do() {
    let has_double = |mesh: &Mesh| {
        String::from_utf8_lossy(&write(&Ply::default(), mesh, &mesh.positions)).contains("property double x")
    };
    let mut mesh = grid(4);
    assert!(!has_double(&mesh));
    mesh.positions.iter_mut().for_each(|p| *p += Vector3::repeat(1e4));
    assert!(has_double(&mesh));
}

#[test]
fn attributes_of_vertices_are_kept_and_normals_turn() {
    let text = "ply\nformat ascii 1.0\ncomment a triangle\nelement edge 1\nproperty int from\nelement vertex 3\n\
        property double x\nproperty double y\nproperty double z\nproperty float nx\nproperty float ny\nproperty float nz\n\
        property float s\nproperty float t\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nproperty int other\n\
        element face 1\nproperty uchar flags\nproperty list uchar ushort vertex_index\nend_header\n7\n\
        0 0 0 0 0 1 0 0 10 20 30 5\n1 0 0 0 0 1 1 0 40 50 60 5\n0 1 0 0 0 1 0 1 70 80 90 5\n1 3 0 1 2\n";
    let mesh = read(&Ply::default(), "a.ply", text.as_bytes()).unwrap().rest;
    assert_eq!(mesh.polygons.corners(), [0, 1, 2]);
    assert_eq!(mesh.texture_coordinates.as_ref().unwrap().values, [[0., 0.], [1., 0.], [0., 1.]]);
    // A quarter turn about x: y to z, z to -y.
    let posed: Vec<_> = mesh.positions.iter().map(|p| Point3::new(p.x, -p.z, p.y)).collect();
    let ascii = Ply { encoding: Encoding::Ascii, ..Ply::default() };
    let written = String::from_utf8(write(&ascii, &mesh, &posed)).unwrap();
    let line = written.lines().last().unwrap();
    assert_eq!(line, "3 0 1 2");
    let vertices: Vec<_> = written.lines().skip_while(|line| *line != "end_header").skip(1).take(3).collect();
    assert!(vertices[2].starts_with("0.000000000 0.000000000 1.000000000 0 -1 0 0 1 70 80 90 255"), "{}", vertices[2]);
}

#[test]
fn seams_have_no_place_in_a_ply() {
    let mut mesh = grid(3);
    let count = mesh.polygons.corner_count() as u32;
    let values = (0..count).map(|i| [f64::from(i), 0.0]).collect();
    mesh.texture_coordinates = Some(CornerAttribute { values, indices: (0..count).map(Some).collect() });
    assert!(!String::from_utf8_lossy(&write(&Ply::default(), &mesh, &mesh.positions)).contains("property float s"));
}

#[test]
fn a_real_ply_is_read_and_written_back_bit_for_bit() {
    let Some(path) = data("pebble-camel/truth-camel-01.ply") else { return };
    let mesh = read_file(&Ply::default(), &path).rest;
    assert_eq!((mesh.positions.len(), mesh.polygons.len()), (51000, 99000));
    let body = |bytes: &[u8]| {
        let end = b"end_header\n";
        let start = bytes.windows(end.len()).position(|window| window == end).unwrap() + end.len();
        bytes[start..].to_vec()
    };
    assert!(body(&write(&Ply::default(), &mesh, &mesh.positions)) == body(&std::fs::read(path).unwrap()));
}

#[test]
fn damaged_plys_say_what_is_wrong() {
    let head = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
        element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n";
    let cases = [
        (format!("{head}3 0 1 3\n"), "a.ply: face 0 (from 0) refers to vertex 3: there are 3 (from 0)\n"),
        (format!("{head}3 0 1 -1\n"), "a.ply: face 0 (from 0) refers to vertex -1: there are 3 (from 0)\n"),
        (format!("{head}2 0 1\n"), "a.ply: face 0 (from 0) has 2 corners, expected at least 3\n"),
        (head.to_owned(), "a.ply:13: not a PLY: "),
        (
            format!("{head}3 0 1 2\n").replace("0 1 0", "0 nan 0"),
            "a.ply:12: not a PLY: Couldn't read element line. String: '0 nan 0 '\n",
        ),
        (head.replace("face 1", "face 0"), "a.ply: empty mesh: 3 vertices, 0 faces\n"),
        (head.replace("vertex 3", "vertex 99999999999"), "a.ply: 99999999999 vertex entries in a file of "),
        ("ply".to_owned(), "a.ply:"),
        (String::new(), "a.ply:"),
    ];
    for (text, expected) in cases {
        let error = message(&read(&Ply::default(), "a.ply", text.as_bytes()).unwrap_err());
        assert!(error.starts_with(expected), "{error}");
    }
}

const TRIANGLES: &str = "solid a b\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n\
    facet normal 0 0 1\nouter loop\nvertex 1 0 0\nvertex 1 1 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid a b\n";

fn binary_stl(header: &[u8; 80], triangles: &[[[f32; 3]; 3]]) -> Vec<u8> {
    let mut bytes = header.to_vec();
    bytes.extend((triangles.len() as u32).to_le_bytes());
    for triangle in triangles {
        bytes.extend([0; 12]);
        bytes.extend(triangle.iter().flatten().flat_map(|x| x.to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

#[test]
fn stl_triangles_are_joined_at_equal_corners() {
    let mut header = [b' '; 80];
    header[..6].copy_from_slice(b"solid ");
    let binary =
        binary_stl(&header, &[[[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]], [[1., 0., 0.], [1., 1., 0.], [0., 1., 0.]]]);
    let two_solids =
        TRIANGLES.replacen("endfacet\n", "endfacet\nendsolid\nsolid second\n", 1).replace("solid a b", "SOLID");
    for bytes in [TRIANGLES.as_bytes(), &binary, two_solids.as_bytes(), TRIANGLES.replace('\n', "\r\n").as_bytes()] {
        let mesh = read(&Stl::default(), "a.stl", bytes).unwrap().rest;
        assert_eq!(mesh.positions.len(), 4);
        assert_eq!(mesh.polygons.corners(), [0, 1, 2, 1, 3, 2]);
    }
}

#[test]
fn damaged_stls_say_what_is_wrong() {
    let error = |bytes: &[u8]| message(&read(&Stl::default(), "a.stl", bytes).unwrap_err());
    assert!(error(b"").starts_with("a.stl: not an STL: "));
    assert!(error(&TRIANGLES.as_bytes()[..90]).starts_with("a.stl: not an STL: "));
    assert!(error(b"solid\nendsolid\n").starts_with("a.stl: empty mesh: 0 vertices, 0 polygons"));
    let nan = binary_stl(&[b' '; 80], &[[[0., 0., f32::NAN], [1., 0., 0.], [0., 1., 0.]]]);
    assert!(error(&nan).starts_with("a.stl: vertex 0 (from 0) has coordinates 0 0 NaN"));
    assert!(error(&nan[..100]).starts_with("a.stl: not an STL: "));
}

proptest! {
    // Each case reads a dozen files.
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn no_damage_makes_the_readers_panic(
        encoding in prop::sample::select(ENCODINGS.to_vec()),
        edits in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..6),
        cut in any::<prop::sample::Index>(),
    ) {
        let mesh = grid(3);
        let ply = Ply { encoding, ..Ply::default() };
        let stl = binary_stl(&[b's'; 80], &[[[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]]]);
        let files = [write(&ply, &mesh, &mesh.positions), stl, TRIANGLES.as_bytes().to_vec()];
        for mut bytes in files {
            edits.iter().for_each(|(at, byte)| { let at = at.index(bytes.len()); bytes[at] = *byte; });
            for bytes in [&bytes[..], &bytes[..cut.index(bytes.len())]] {
                for (format, name) in [(&ply as &dyn Format, "a.ply"), (&Stl::default(), "a.stl")] {
                    if let Ok(sequence) = read(format, name, bytes) {
                        sequence.rest.validate().unwrap();
                    }
                }
            }
        }
    }
}
