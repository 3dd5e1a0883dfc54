//! PLY and STL: what comes back, what real files hold, and what damaged files say.

mod support;

use std::path::Path;

use mimesh_core::{
    mesh::{CornerAttribute, Mesh},
    stage::{BytesInput, Format, MeshWriter, Selection},
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
fn texture_coordinates_with_seams_are_those_of_corners() {
    let mut mesh = grid(3);
    let count = mesh.polygons.corner_count() as u32;
    let values = (0..count).map(|i| [f64::from(i), 0.5]).collect();
    mesh.texture_coordinates = Some(CornerAttribute { values, indices: (0..count).map(Some).collect() });
    for encoding in ENCODINGS {
        let ply = Ply { encoding, ..Ply::default() };
        let back = read(&ply, "a.ply", &write(&ply, &mesh, &mesh.positions)).unwrap().rest;
        assert_eq!(back.texture_coordinates, mesh.texture_coordinates);
    }
}

/// A triangle and a quad as text, with what stands behind the coordinates, its header lines, and what stands behind the corners.
fn small(vertex_header: &str, vertex: &str, face_header: &str, face: &str) -> String {
    format!(
        "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\n{vertex_header}\
        element face 2\nproperty list uchar int vertex_indices\n{face_header}end_header\n\
        0 0 0{vertex}\n1 0 0{vertex}\n1 1 0{vertex}\n0 1 0{vertex}\n2 0 .5{vertex}\n4 0 1 2 3{face}\n3 1 4 2{face}\n"
    )
}

#[test]
fn numbers_and_lines_of_a_text_may_be_written_in_any_way() {
    let plain = small("", "", "", "");
    let expected = read(&Ply::default(), "a.ply", plain.as_bytes()).unwrap().rest;
    assert_eq!((expected.positions.len(), expected.positions[4]), (5, Point3::new(2.0, 0.0, 0.5)));
    let (header, body) = plain.split_once("end_header\n").unwrap();
    let with_body = |body: String| format!("{header}end_header\n{body}");
    let utf_16: Vec<u8> = plain.encode_utf16().flat_map(u16::to_le_bytes).collect();
    let variants = [
        with_body(body.replace(' ', "\n")).into_bytes(),
        with_body(body.replace('\n', " ")).into_bytes(),
        with_body(body.replace("1 1 0", "1. +1.0e0 -0.")).into_bytes(),
        with_body(body.replace("4 0 1 2 3", "4\n0 1\n\n2 3")).into_bytes(),
        plain.replace('\n', "\r\n").into_bytes(),
        plain.replace('\n', "\r").into_bytes(),
        format!("\u{feff}{plain}\n\n").into_bytes(),
        utf_16,
    ];
    for bytes in variants {
        let mesh = read(&Ply::default(), "a.ply", &bytes).unwrap().rest;
        assert_eq!((&mesh.positions, &mesh.polygons), (&expected.positions, &expected.polygons));
    }
    // Entries that have more numbers than properties would all be out of step.
    let error = message(&read(&Ply::default(), "a.ply", with_body(body.replace('\n', " 7\n")).as_bytes()).unwrap_err());
    assert!(error.starts_with("a.ply:"), "{error}");
    let trailing = read(&Ply::default(), "a.ply", format!("{plain}written by hand\n").as_bytes()).unwrap();
    assert_eq!(
        trailing.warnings,
        ["16 bytes after the last entry are not read: if the header's counts are too low, entries are missing"]
    );
}

#[test]
fn colours_of_any_type_come_back_in_theirs() {
    let types = [
        ("uchar", " 255 51 0", [1.0, 0.2, 0.0]),
        ("float", " 1 0.25 0", [1.0, 0.25, 0.0]),
        ("ushort", " 65535 13107 0", [1.0, 0.2, 0.0]),
    ];
    for (kind, numbers, [r, g, b]) in types {
        let header = ["red", "green", "blue"].map(|name| format!("property {kind} {name}\n")).concat();
        for encoding in ENCODINGS {
            let ply = Ply { encoding, ..Ply::default() };
            let mesh = read(&ply, "a.ply", small(&header, numbers, &header, numbers).as_bytes()).unwrap().rest;
            assert_eq!(mesh.vertex_colors, Some(vec![[r, g, b, 1.0]; 5]));
            let bytes = write(&ply, &mesh, &mesh.positions);
            let stored = if kind == "uchar" { "property uchar red" } else { "property float red" };
            assert_eq!(String::from_utf8_lossy(&bytes).matches(stored).count(), 2, "of vertices and of faces");
            let back = read(&ply, "a.ply", &bytes).unwrap().rest;
            for (back, there) in back.vertex_colors.as_ref().unwrap().iter().zip(mesh.vertex_colors.as_ref().unwrap()) {
                // f32, or exact for whole numbers of 8 bits.
                back.iter().zip(there).for_each(|(a, b)| assert!((a - b).abs() < 1e-7));
            }
            // Faces and vertices of the second writing are those of the first, so that colours of faces are kept too.
            assert_eq!(write(&ply, &back, &back.positions), bytes);
        }
    }
}

#[test]
fn strips_are_triangles_that_turn_alike() {
    let text = "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\n\
        element tristrips 1\nproperty list int int vertex_indices\nend_header\n\
        0 0 0\n0 1 0\n1 0 0\n1 1 0\n2 0 0\n9 0 2 1 3 -1 2 4 3 3\n";
    let mesh = read(&Ply::default(), "a.ply", text.as_bytes()).unwrap().rest;
    assert_eq!(mesh.polygons.corners(), [0, 2, 1, 1, 2, 3, 2, 4, 3]);
    for corners in mesh.polygons.iter() {
        let [a, b, c] = [0, 1, 2].map(|k| mesh.positions[corners[k] as usize]);
        assert!((b - a).cross(&(c - a)).z > 0.0);
    }
}

#[test]
fn what_a_ply_leaves_out_is_told_by_name() {
    let header = "property float quality\nproperty list uchar int owners\n";
    let text = small(header, " 1 2 7 8", "property int flags\n", " 4")
        .replace("element vertex", "comment TextureFile skin.png\nelement edge 1\nproperty int a\nelement vertex")
        .replace("end_header\n", "end_header\n3\n");
    let mesh = read(&Ply::default(), "a.ply", text.as_bytes()).unwrap().rest;
    let ply = Ply::default();
    let Some(MeshWriter::Pose(writer)) = ply.writer() else { unreachable!("a PLY holds one pose") };
    let told = "left out of PLY: the element `edge`, the vertex properties `quality`, `owners`, the face properties `flags`, \
        the name of the texture file `skin.png`";
    assert_eq!(writer.warnings(Path::new(""), &mesh), [told]);
    let short = small("", "", "", "").replace("face 2", "face 3") + "2 0 1\n";
    let sequence = read(&ply, "a.ply", short.as_bytes()).unwrap();
    assert_eq!(sequence.warnings, ["1 faces of fewer than three corners are left out"]);
}

#[test]
fn vertices_alone_are_a_pose_of_the_same_vertices() {
    let rest = read(&Ply::default(), "a.ply", small("", "", "", "").as_bytes()).unwrap().rest;
    let points = small("", "", "", "").replace("face 2", "face 0").split_once("\n4 0").unwrap().0.to_owned();
    let pose = |same_vertices| {
        let selection = Selection { same_vertices, ..Selection::default() };
        Ply::default().read_pose(&BytesInput::new("a.ply", points.as_bytes()), &selection, &rest)
    };
    assert_eq!(pose(true).unwrap(), rest.positions);
    pose(false).unwrap_err();
}

#[test]
fn other_readers_of_ply_agree() {
    let text = small("", "", "", "");
    let mesh = read(&Ply::default(), "a.ply", text.as_bytes()).unwrap().rest;
    for encoding in ENCODINGS {
        let ply = Ply { encoding, ..Ply::default() };
        let bytes = write(&ply, &mesh, &mesh.positions);
        let parser = ply_rs_bw::parser::Parser::<ply_rs_bw::ply::DefaultElement>::new();
        let theirs = parser.read_ply(&mut &bytes[..]).unwrap();
        let xs: Vec<_> = theirs.payload["vertex"].iter().map(|vertex| vertex["x"].clone()).collect();
        let expected = mesh.positions.iter().map(|p| ply_rs_bw::ply::Property::Float(p.x as f32)).collect::<Vec<_>>();
        assert_eq!(xs, expected);
        assert_eq!(theirs.payload["face"].len(), 2);
    }
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
        (format!("{head}2 0 1\n"), "a.ply: empty mesh: 3 vertices, 0 faces\n"),
        (head.to_owned(), "a.ply:13: not a PLY: the file ends in face 0 (from 0)\n"),
        (format!("{head}3 0 1 2\n").replace("0 1 0", "0 nan 0"), "a.ply: vertex 2 (from 0) has coordinates 0 NaN 0"),
        (
            format!("{head}3 0 1 2\n").replace("0 1 0", "0 one 0"),
            "a.ply:12: not a PLY: `one` of vertex 2 (from 0) is no number\n",
        ),
        (
            head.replace("int vertex", "whole vertex"),
            "a.ply:8: not a PLY: `property list uchar whole vertex_indices` is no property\n",
        ),
        (head.replace("element", "elements"), "a.ply:3: not a PLY: `elements vertex 3` has no place in a header\n"),
        (head.replace("face 1", "face 0"), "a.ply: empty mesh: 3 vertices, 0 faces\n"),
        (
            head.replace("vertex 3", "vertex 99999999999"),
            "a.ply:10: not a PLY: the header counts 99999999999 vertex entries of at least 6 bytes each, the file has ",
        ),
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
fn untidy_stls_are_read() {
    let expected = read(&Stl::default(), "a.stl", TRIANGLES.as_bytes()).unwrap().rest;
    let triangles = [[[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]], [[1., 0., 0.], [1., 1., 0.], [0., 1., 0.]]];
    let mut with_nan = binary_stl(&[b' '; 80], &triangles);
    with_nan[84..96].fill(0xff);
    let named = binary_stl(&std::array::from_fn(|i| b"solid made by a program"[i % 23]), &triangles);
    let utf_16: Vec<u8> = TRIANGLES.encode_utf16().flat_map(u16::to_be_bytes).collect();
    let variants: Vec<Vec<u8>> = vec![
        TRIANGLES.replace("endsolid", "end solid").into(),
        TRIANGLES.replace("endloop", "end loop").replace("endfacet", "End Facet").into(),
        TRIANGLES.replace("normal 0 0 1", "normal nan -nan(ind) 1.#QNAN").into(),
        TRIANGLES.replace("normal 0 0 1", "normal").into(),
        TRIANGLES.replace("a b", "a vertex of solid facets").into(),
        TRIANGLES.replace("outer loop\n", "outer loop ").replace("vertex 0 1 0\n", "vertex 0. 1. -.0 ").into(),
        TRIANGLES.replace('\n', "\r").into(),
        with_nan,
        named.clone(),
        utf_16,
    ];
    for bytes in variants {
        let text = String::from_utf8_lossy(&bytes).into_owned();
        let mesh = read(&Stl::default(), "a.stl", &bytes).unwrap_or_else(|error| panic!("{error}: {text}")).rest;
        assert_eq!((&mesh.positions, &mesh.polygons), (&expected.positions, &expected.polygons), "{text}");
    }
    let mut trailing = named;
    trailing.extend(b"\0\0made today");
    let sequence = read(&Stl::default(), "a.stl", &trailing).unwrap();
    assert_eq!(sequence.rest.polygons, expected.polygons);
    assert_eq!(sequence.warnings, ["12 bytes after the 2 triangles that the header counts are not read"]);
}

#[test]
fn stl_out_is_what_another_reader_reads() {
    let mesh = grid(4);
    let posed = twisted(&mesh.positions);
    let bytes = write(&Stl::default(), &mesh, &posed);
    let theirs = stl_io::read_stl(&mut std::io::Cursor::new(&bytes)).unwrap();
    let (triangles, _) = mesh.polygons.fans();
    assert_eq!(theirs.faces.len(), triangles.len());
    for (face, corners) in theirs.faces.iter().zip(&triangles) {
        let at = |v: usize| Point3::from(theirs.vertices[v].0.map(f64::from));
        let corners = corners.map(|v| posed[v as usize]);
        for (&v, expected) in face.vertices.iter().zip(corners) {
            // Half a unit in the last place of coordinates up to 2, in each of three.
            assert!((at(v) - expected).norm() <= 2.1e-7);
        }
        let normal = (corners[1] - corners[0]).cross(&(corners[2] - corners[0])).normalize();
        assert!((Vector3::from(face.normal.0.map(f64::from)) - normal).norm() <= 2e-7);
    }
    let stl = Stl::default();
    let Some(MeshWriter::Pose(writer)) = stl.writer() else { unreachable!("an STL holds one pose") };
    let told = "left out of STL: polygons of more than three corners";
    assert_eq!(writer.warnings(Path::new(""), &mesh), [told]);
    let mut far = mesh.clone();
    far.positions.iter_mut().for_each(|p| *p += Vector3::repeat(1e4));
    assert!(writer.warnings(Path::new(""), &far)[1].contains("32-bit numbers of STL move vertices"));
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
    assert!(error(&TRIANGLES.as_bytes()[..90]).starts_with("a.stl:8: not an STL: the file ends in facet 0 (from 0)"));
    assert!(error(&TRIANGLES.as_bytes()[..60]).starts_with("a.stl:5: not an STL: `` is no coordinate of a vertex"));
    let two = TRIANGLES.replacen("vertex 0 0 0\n", "", 1);
    assert!(error(two.as_bytes()).starts_with("a.stl:6: not an STL: a triangle has 2 corners, expected 3"));
    assert!(error(b"solid\nendsolid\n").starts_with("a.stl: empty mesh: 0 vertices, 0 polygons"));
    let nan = binary_stl(&[b' '; 80], &[[[0., 0., f32::NAN], [1., 0., 0.], [0., 1., 0.]]]);
    assert!(error(&nan).starts_with("a.stl: facet 0 (from 0) has the coordinate NaN: expected finite numbers"));
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
