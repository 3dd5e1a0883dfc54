//! OBJ: what a file keeps, what real files hold, and what damaged ones say.

mod support;

use std::path::Path;

use mimesh_core::{
    mesh::Part,
    stage::{BytesInput, Format, MeshWriter, Selection},
    testkit::data::{data, input},
};
use mimesh_formats::Obj;
use nalgebra::{Point3, Rotation3, Vector3};
use proptest::prelude::*;
use support::{distance, grid, message, read, read_file, twisted, write};

const CUBE_CORNER: &str = "\
# a corner\r\nmtllib none.mtl\r\no Corner\r\n\
v  0.0  0.0  0.0 1 0 0\r\nv  1.0  0.0  0.0 0 1 0\r\nv  0.0  1.0  0.0\r\nv  0.0  0.0  1.0\r\n\
vt 0 0\r\nvt 1 0\r\nvt 0 1\r\nvn 0.0 0.0 -1.0\r\nvn 0.0 -1.0 0.0\r\n\
g floor all\r\nusemtl Grey #2\r\ns 1\r\nf 1/1/1 \\\r\n 3/3/1 2/2/1\r\n\
g wall all\r\nf -4/1/2 -3/2/2 -1/3/2 # four\r\nl 1 2\r\n# no end";

fn corner() -> mimesh_core::mesh::MeshSequence {
    read(&Obj::default(), "corner.obj", CUBE_CORNER.as_bytes()).unwrap()
}

#[test]
fn names_attributes_and_order_are_those_of_the_file() {
    let sequence = corner();
    let mesh = &sequence.rest;
    assert_eq!(mesh.positions.len(), 4);
    assert_eq!(mesh.polygons.corners(), [0, 2, 1, 0, 1, 3]);
    let part = |group: &str, polygons| Part {
        object: Some("Corner".into()),
        groups: vec![group.into(), "all".into()],
        material: Some("Grey #2".into()),
        polygons,
    };
    assert_eq!(mesh.parts, [part("floor", 0..1), part("wall", 1..2)]);
    assert_eq!(mesh.texture_coordinates.as_ref().unwrap().indices, [0, 2, 1, 0, 1, 2].map(Some));
    assert_eq!(mesh.normals.as_ref().unwrap().indices, [0, 0, 0, 1, 1, 1].map(Some));
    assert_eq!(sequence.warnings.len(), 1);
    assert!(sequence.warnings[0].contains("none.mtl cannot be read"), "{}", sequence.warnings[0]);
}

#[test]
fn the_rest_pose_gives_the_file_back_byte_for_byte() {
    let mesh = corner().rest;
    assert_eq!(String::from_utf8(write(&Obj::default(), &mesh, &mesh.positions)).unwrap(), CUBE_CORNER);
}

#[test]
fn only_changed_numbers_change() {
    let mesh = corner().rest;
    let mut posed = mesh.positions.clone();
    posed[1].x = 1.5;
    posed[3] = Point3::new(0.0, -0.25, 1.0);
    let expected = CUBE_CORNER
        .replace("v  1.0  0.0  0.0 0 1 0", "v 1.500000000  0.0  0.0 0 1 0")
        .replace("v  0.0  0.0  1.0\r", "v  0.0 -0.250000000  1.0\r");
    let text = String::from_utf8(write(&Obj { turn_normals: false }, &mesh, &posed)).unwrap();
    assert_eq!(text, expected);
    // The wall has tipped by atan(1/4); its normal, and no other, with it.
    let turned = String::from_utf8(write(&Obj::default(), &mesh, &posed)).unwrap();
    let vn: Vec<_> = turned.lines().filter(|line| line.starts_with("vn")).collect();
    assert_eq!(vn, ["vn 0.0 0.0 -1.0", "vn 0.0 -0.9701 -0.2425"]);
}

#[test]
fn a_rigid_motion_turns_normals_by_itself() {
    let mesh = corner().rest;
    let turn = Rotation3::from_euler_angles(0.4, 0.5, 0.6);
    let posed: Vec<_> = mesh.positions.iter().map(|p| turn * p + Vector3::new(1.0, 2.0, 3.0)).collect();
    let back = read(&Obj::default(), "posed.obj", &write(&Obj::default(), &mesh, &posed)).unwrap().rest;
    for (posed, rest) in back.normals.unwrap().values.iter().zip(&mesh.normals.unwrap().values) {
        // Four decimals, the fewest that are written.
        assert!((Vector3::from(*posed) - turn * Vector3::from(*rest)).amax() <= 0.5001e-4);
    }
}

#[test]
fn columns_of_numbers_stay_aligned() {
    let text = "v    1.00    2.00\t   3.00\nv   -1.00   -2.00\t  13.00\nv    0.00    0.00\t   0.00\nf 1 2 3\n";
    let mesh = read(&Obj::default(), "a.obj", text.as_bytes()).unwrap().rest;
    let mut posed = mesh.positions.clone();
    posed[0].x = -1.0 / 3.0;
    posed[2] = Point3::new(100.0, 0.5, -1.0);
    let moved = String::from_utf8(write(&Obj::default(), &mesh, &posed)).unwrap();
    assert_eq!(moved.lines().next().unwrap(), "v -0.3333333    2.00\t   3.00");
    assert_eq!(moved.lines().nth(2).unwrap(), "v 100.0000000 0.5000000\t -1.0000000");
}

#[test]
fn other_meshes_are_written_in_full_and_read_back() {
    let mut mesh = corner().rest;
    mesh.document = Default::default();
    let bytes = write(&Obj::default(), &mesh, &mesh.positions);
    let back = read(&Obj::default(), "plain.obj", &bytes).unwrap().rest;
    assert_eq!(back.positions, mesh.positions);
    assert_eq!(back.polygons, mesh.polygons);
    assert_eq!(back.parts, mesh.parts);
    assert_eq!(back.texture_coordinates, mesh.texture_coordinates);
    assert_eq!(back.normals, mesh.normals);
}

#[test]
fn bytes_that_are_no_text_are_kept() {
    let text = b"# caf\xe9\no \xff\xfe\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3";
    let mesh = read(&Obj::default(), "latin.obj", text).unwrap().rest;
    assert_eq!(write(&Obj::default(), &mesh, &mesh.positions), text);
}

#[test]
fn materials_come_from_the_library_beside_the_file() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("my colours.mtl"), "newmtl red\nKd 1 0.5 0\nd 0.25\nnewmtl unused\nKd 0 0 0\n")
        .unwrap();
    let path = folder.path().join("a.obj");
    std::fs::write(&path, "mtllib my colours.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\nf 1 2 3\n").unwrap();
    let sequence = read_file(&Obj::default(), &path);
    assert_eq!(sequence.warnings, Vec::<String>::new());
    assert_eq!(sequence.rest.materials.len(), 1);
    assert_eq!(sequence.rest.materials[0].base_color, [1.0, 0.5, 0.0, 0.25]);
}

#[test]
fn errors_name_line_element_and_a_way_out() {
    let start = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    let cases = [
        (
            "v 0 0\nf 1 1 1",
            "a.obj:1: vertex 1 has 2 coordinates, expected 3\nthe file is damaged or cut short: export it again",
        ),
        (
            "v 0 0 nan\n",
            "a.obj:1: vertex 1 has coordinate `nan`: expected a finite number\nrepair the file or export it again without NaN and infinity",
        ),
        (
            "\nv 0 0 0\nv 0 1e999 0",
            "a.obj:3: vertex 2 has coordinate `1e999`: expected a finite number\nrepair the file or export it again without NaN and infinity",
        ),
        (
            "",
            "a.obj: empty mesh: 0 vertices, 0 faces\ngive a mesh with at least one face; point clouds and curves cannot take a deformation",
        ),
        (
            start,
            "a.obj: empty mesh: 3 vertices, 0 faces\ngive a mesh with at least one face; point clouds and curves cannot take a deformation",
        ),
    ];
    for (text, expected) in cases {
        assert_eq!(message(&read(&Obj::default(), "a.obj", text.as_bytes()).unwrap_err()), expected);
    }
    let faces = [
        ("f 1 2 4", "vertex index 4 is out of range: the file has 3 vertices\n"),
        ("f 1 2 0", "vertex index 0 is out of range: indices start at 1\n"),
        ("f 1 2 -4", "vertex index -4 is out of range: 3 vertices stand before this line\n"),
        ("f 1/1 2 3", "texture coordinate index 1 is out of range: the file has 0 texture coordinates\n"),
        ("f 1//1 2 3", "normal index 1 is out of range: the file has 0 normals\n"),
        ("f 1 2 c", "`c` is not a corner of a face\n"),
    ];
    for (face, expected) in faces {
        let error = message(&read(&Obj::default(), "a.obj", format!("{start}{face}").as_bytes()).unwrap_err());
        assert!(error.starts_with(&format!("a.obj:4: {expected}")), "{error}");
    }
}

#[test]
fn faces_of_two_corners_stay_in_the_file_and_out_of_the_mesh() {
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/1 2/1\nf 1/1 2/1 3/1\nf 3 3\nf\n";
    let sequence = read(&Obj::default(), "a.obj", text.as_bytes()).unwrap();
    let mesh = &sequence.rest;
    assert_eq!(mesh.polygons.corners(), [0, 1, 2]);
    assert_eq!(mesh.texture_coordinates.as_ref().unwrap().indices, [Some(0); 3]);
    let told = "3 faces have fewer than three corners (line 5): kept in the file and left out of the solve";
    assert_eq!(sequence.warnings, [told]);
    let posed: Vec<_> = mesh.positions.iter().map(|p| p + Vector3::new(0.0, 0.0, 1.0)).collect();
    let written = String::from_utf8(write(&Obj::default(), mesh, &posed)).unwrap();
    assert!(written.ends_with("f 1/1 2/1\nf 1/1 2/1 3/1\nf 3 3\nf\n"), "{written}");
    // Such a face must name vertices all the same.
    let error = message(&read(&Obj::default(), "a.obj", b"v 0 0 0\nf 1 2\n").unwrap_err());
    assert!(error.starts_with("a.obj:2: vertex index 2 is out of range"), "{error}");
}

#[test]
fn utf_16_is_read_as_pose_and_as_rest() {
    let text = "o Köpfchen\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    for order in [u16::to_le_bytes as fn(u16) -> [u8; 2], u16::to_be_bytes] {
        let bytes: Vec<u8> = "\u{feff}".encode_utf16().chain(text.encode_utf16()).flat_map(order).collect();
        let sequence = read(&Obj::default(), "a.obj", &bytes).unwrap();
        assert_eq!(sequence.warnings, ["the file is UTF-16 text: it is read, and results are written as UTF-8"]);
        assert_eq!(sequence.rest.parts[0].object.as_deref(), Some("Köpfchen"));
        assert_eq!(String::from_utf8(write(&Obj::default(), &sequence.rest, &sequence.rest.positions)).unwrap(), text);
        let pose = Obj::default().read_pose(&BytesInput::new("b.obj", bytes), &Selection::default(), &sequence.rest);
        assert_eq!(pose.unwrap(), sequence.rest.positions);
    }
}

#[test]
fn colours_behind_coordinates_are_colours_of_vertices() {
    let colors = |text: &str| read(&Obj::default(), "a.obj", text.as_bytes()).unwrap().rest.vertex_colors;
    let face = "f 1 2 3\n";
    let unit = format!("v 0 0 0 1 .5 0\nv 1 0 0 0 0 0 .25\nv 0 1 0\n{face}");
    assert_eq!(colors(&unit).unwrap(), [[1.0, 0.5, 0.0, 1.0], [0.0, 0.0, 0.0, 0.25], [1.0; 4]]);
    let bytes = format!("v 0 0 0 255 51 0\nv 1 0 0 0 0 0\nv 0 1 0 0 0 0\n{face}");
    assert_eq!(colors(&bytes).unwrap()[0], [1.0, 0.2, 0.0, 1.0]);
    // A number alone is a weight of curves.
    assert_eq!(colors(&format!("v 0 0 0 1\nv 1 0 0 1\nv 0 1 0 1\n{face}")), None);
}

#[test]
fn a_material_library_is_found_from_another_folder() {
    let top = tempfile::tempdir().unwrap();
    let (models, results) = (top.path().join("models"), top.path().join("out/deep"));
    std::fs::create_dir_all(models.join("mats")).unwrap();
    std::fs::create_dir_all(&results).unwrap();
    std::fs::write(models.join("my colours.mtl"), "newmtl red\nKd 1 0.5 0\n").unwrap();
    std::fs::write(models.join("mats/b.mtl"), "newmtl blue\nKd 0 0 1\n").unwrap();
    let text = "# head\nmtllib my colours.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nmtllib mats\\b.mtl\nmtllib none.mtl\n\
        usemtl red\nf 1//1 2//1 3//1\nusemtl blue\nf 3//1 2//1 1//1\nmtllib mats/b.mtl\n";
    let path = models.join("a.obj");
    std::fs::write(&path, text).unwrap();
    let mesh = read_file(&Obj::default(), &path).rest;
    let obj = Obj::default();
    let Some(MeshWriter::Pose(writer)) = obj.writer() else { unreachable!("an OBJ holds one pose") };
    let written = |folder: &Path| {
        let mut out = Vec::new();
        writer.write_in(folder, &mesh, &mesh.positions, &mut out).unwrap();
        String::from_utf8(out).unwrap()
    };
    assert_eq!(written(&models), text);
    assert_eq!(writer.warnings(&models, &mesh), Vec::<String>::new());
    let expected = text
        .replace("mtllib my", "mtllib ../../models/my")
        .replace("mtllib mats\\b", "mtllib ../../models/mats/b")
        .replace("mtllib mats/b", "mtllib ../../models/mats/b");
    assert_eq!(written(&results), expected);
    let told = writer.warnings(&results, &mesh);
    assert_eq!(told.len(), 1);
    assert!(told[0].contains("`../../models/my colours.mtl`, `../../models/mats/b.mtl`"), "{told:?}");
    // The library is read from there.
    let result = results.join("a.obj");
    std::fs::write(&result, expected).unwrap();
    assert_eq!(read_file(&Obj::default(), &result).rest.materials, mesh.materials);
}

#[test]
fn a_pose_of_the_same_vertices_may_have_other_faces_or_none() {
    let rest = read(&Obj::default(), "rest.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap().rest;
    let pose = |text: &str, same_vertices| {
        let selection = Selection { same_vertices, ..Selection::default() };
        Obj::default().read_pose(&BytesInput::new("pose.obj", text), &selection, &rest)
    };
    for faces in ["", "f 2 3 1\n", "f 9 9 9\nf x\n"] {
        let text = format!("v 5 0 0\nv 1 0 0\nv 0 1 0\n{faces}");
        assert_eq!(pose(&text, true).unwrap()[0], Point3::new(5.0, 0.0, 0.0));
        pose(&text, false).unwrap_err();
    }
    for text in ["v 5 0 0\nv 1 0 0\nv 0 1 0\n", "v 5 0 0\nv 1 0 0\nv 0 1 0\nf 2 3 1\n"] {
        let error = message(&pose(text, false).unwrap_err());
        assert!(error.contains("`poses: { files: …, same_vertices: true }`"), "{error}");
    }
    let error = message(&pose("v 5 0 0\n", true).unwrap_err());
    assert!(error.starts_with("pose.obj: pose has 1 vertices, the rest mesh 3\n"), "{error}");
}

#[test]
fn a_face_may_refer_to_vertices_that_come_later() {
    let mesh = read(&Obj::default(), "a.obj", b"f 1 2 3\nv 0 0 0\nv 1 0 0\nv 0 1 0\n").unwrap().rest;
    assert_eq!(mesh.polygons.corners(), [0, 1, 2]);
}

#[test]
fn a_pose_must_have_the_vertices_and_polygons_of_the_rest_mesh() {
    let rest =
        read(&Obj::default(), "rest.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3\nf 2 4 3\n").unwrap().rest;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("pose.obj");
    let pose = |text: &str| {
        std::fs::write(&path, text).unwrap();
        Obj::default().read_pose(&input(&path), &Selection::default(), &rest)
    };
    // Other attributes, materials and comments do not matter.
    let same = "vt 9 9\nv 5 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nusemtl x\nf 1/1 2/1 3/1\nf -3 -1 -2\n";
    assert_eq!(pose(same).unwrap()[0], Point3::new(5.0, 0.0, 0.0));
    let cases = [
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "pose has 3 vertices, the rest mesh 4"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 0\nf 1 2 3\n", "pose has 1 polygons, the rest mesh 2"),
        (
            "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 0\nf 1 2 3\nf 2 3 4\n",
            "polygon 1 (from 0) differs: pose has vertices [1, 2, 3], the rest mesh [1, 3, 2]",
        ),
    ];
    for (text, expected) in cases {
        let error = message(&pose(text).unwrap_err());
        assert!(error.starts_with(&format!("pose.obj: {expected}\n")), "{error}");
    }
}

#[test]
fn a_face_with_quads_seams_and_materials_comes_back_with_only_its_vertices_changed() {
    let Some(path) = data("ict-facekit/generic_neutral_mesh.obj") else { return };
    let bytes = std::fs::read(&path).unwrap();
    let mesh = read_file(&Obj::default(), &path).rest;
    assert_eq!((mesh.positions.len(), mesh.polygons.len()), (26719, 26384));
    assert!(write(&Obj::default(), &mesh, &mesh.positions) == bytes);

    let posed = twisted(&mesh.positions);
    let moved = write(&Obj::default(), &mesh, &posed);
    let lines = |bytes: &[u8]| -> Vec<Vec<u8>> { bytes.split(|&b| b == b'\n').map(<[u8]>::to_vec).collect() };
    let (before, after) = (lines(&bytes), lines(&moved));
    assert_eq!(before.len(), after.len());
    for (before, after) in before.iter().zip(&after) {
        assert!(before == after || (before.starts_with(b"v ") && after.starts_with(b"v ")));
    }
    let back = read(&Obj::default(), "moved.obj", &moved).unwrap().rest;
    assert!(distance(&back.positions, &posed) <= 8.7e-10 * mesh.diagonal());
}

#[test]
fn real_poses_are_read_as_by_tobj() {
    let files = [
        "ict-facekit/jawOpen.obj",
        "sumner-horse-poses/horse-01.obj",
        "sumner-camel-poses/camel-01.obj",
        "sumner-cat-poses/cat-01.obj",
        "sumner-horse-gallop/0001.obj",
        "cragl-mit-wolf/wolf.obj",
    ];
    for path in files.into_iter().filter_map(data) {
        let mesh = read_file(&Obj::default(), &path).rest;
        let ours = mesh.polygons.corners().iter().map(|&v| mesh.positions[v as usize]).collect::<Vec<_>>();
        assert!(ours == corners_by_tobj(&path), "{} differs", path.display());
    }
}

/// The positions of all corners in the order of the file.
fn corners_by_tobj(path: &Path) -> Vec<Point3<f64>> {
    let text = std::fs::read(path).unwrap();
    let options = tobj::LoadOptions::default();
    let no_materials = |_: &Path| Ok((Vec::new(), Default::default()));
    let (models, _) = tobj::load_obj_buf(&mut &text[..], &options, no_materials).unwrap();
    let corner = |mesh: &tobj::Mesh, v: u32| Point3::from_slice(&mesh.positions[3 * v as usize..][..3]);
    models.iter().flat_map(|m| m.mesh.indices.iter().map(|&v| corner(&m.mesh, v))).collect()
}

#[test]
fn a_posed_horse_has_normals_close_to_those_of_the_true_pose() {
    let (Some(rest), Some(pose)) =
        (data("sumner-horse-poses/horse-reference.obj"), data("sumner-horse-poses/horse-03.obj"))
    else {
        return;
    };
    let (rest, pose) = (read_file(&Obj::default(), &rest).rest, read_file(&Obj::default(), &pose).rest);
    let back = read(&Obj::default(), "a.obj", &write(&Obj::default(), &rest, &pose.positions)).unwrap().rest;
    assert!(distance(&back.positions, &pose.positions) <= 8.7e-10 * rest.diagonal());
    let angles = back.normals.unwrap().values.into_iter().zip(pose.normals.unwrap().values).map(|(ours, theirs)| {
        let (ours, theirs) = (Vector3::from(ours), Vector3::from(theirs));
        ours.angle(&theirs).to_degrees()
    });
    let mut angles: Vec<_> = angles.collect();
    angles.sort_by(f64::total_cmp);
    // The data set's own normals follow another rule; the median is far below what shading shows.
    assert!(angles[angles.len() / 2] < 1.0, "median {}", angles[angles.len() / 2]);
}

proptest! {
    #[test]
    fn no_bytes_make_the_reader_panic(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        let _ = read(&Obj::default(), "a.obj", &bytes);
    }

    #[test]
    fn no_damage_makes_the_reader_or_writer_panic(
        edits in prop::collection::vec((0..CUBE_CORNER.len(), prop::sample::select(b"0123456789-/ve.f#\\\n\r \xff".to_vec())), 0..12),
        end in 0..CUBE_CORNER.len(),
    ) {
        let mut bytes = CUBE_CORNER.as_bytes().to_vec();
        edits.iter().for_each(|&(at, byte)| bytes[at] = byte);
        for length in [bytes.len(), end] {
            let Ok(sequence) = read(&Obj::default(), "a.obj", &bytes[..length]) else { continue };
            let mesh = sequence.rest;
            mesh.validate().unwrap();
            prop_assert_eq!(&write(&Obj::default(), &mesh, &mesh.positions)[..], &bytes[..length]);
            let posed = twisted(&mesh.positions);
            let back = read(&Obj::default(), "b.obj", &write(&Obj::default(), &mesh, &posed)).unwrap().rest;
            prop_assert_eq!(&back.polygons, &mesh.polygons);
            let extent = mesh.diagonal().max(mimesh_core::mesh::diagonal(&posed));
            // One part in 2^52 of the largest coordinate is what the number itself holds.
            let size = posed.iter().map(|p| p.coords.amax()).fold(extent, f64::max);
            // Half a decimal of at most 1e-9 of the diagonal in each of three coordinates.
            prop_assert!(distance(&back.positions, &posed) <= 8.7e-10 * extent + 1e-15 * size);
        }
    }

    #[test]
    fn a_mesh_from_elsewhere_keeps_its_positions_to_1e_9_of_its_diagonal(scale in -12..12, offset in -2..4) {
        let mut mesh = grid(4);
        let scale = 10_f64.powi(scale);
        let offset = Vector3::repeat(10_f64.powi(offset) * scale);
        mesh.positions.iter_mut().for_each(|p| *p = *p * scale + offset);
        let back = read(&Obj::default(), "a.obj", &write(&Obj::default(), &mesh, &mesh.positions)).unwrap().rest;
        prop_assert_eq!(&back.polygons, &mesh.polygons);
        prop_assert!(distance(&back.positions, &mesh.positions) <= 1e-9 * mesh.diagonal());
    }
}
