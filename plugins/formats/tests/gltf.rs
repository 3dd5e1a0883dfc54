//! glTF: what comes back of what is written, and what the Khronos validator says of it.

mod support;

use std::{path::Path, process::Command};

use mimesh_core::{
    mesh::{CornerAttribute, Material, Mesh, MeshSequence, Part},
    stage::{Format, MeshWriter, Selection},
    testkit::data::{data, input, missing},
    testkit::memory_file::MemoryFile,
};
use mimesh_formats::{Glb, Gltf, Obj, PoseAnimation};
use nalgebra::{Point3, Vector3};
use proptest::prelude::*;
use support::{distance, grid, read, read_file, twisted};

/// Half a unit in the last place of an f32 at each of two additions, for coordinates up to `size`.
fn f32_rounding(positions: &[Point3<f64>]) -> f64 {
    let size = positions.iter().map(|p| p.coords.amax()).fold(0.0, f64::max);
    2.0 * f64::from(f32::EPSILON) * size
}

/// A grid with two objects, three materials, seams in texture coordinates and hard edges.
fn furnished() -> Mesh {
    let mut mesh = grid(5);
    let count = mesh.polygons.corner_count();
    let part = |object: &str, material: Option<&str>, polygons| Part {
        object: Some(object.into()),
        groups: Vec::new(),
        material: material.map(str::to_owned),
        polygons,
    };
    mesh.parts = vec![part("left", Some("red"), 0..4), part("left", None, 4..8), part("right", Some("glass"), 8..16)];
    mesh.materials = vec![
        Material { name: "red".into(), base_color: [1.0, 0.25, 0.0, 1.0], ..Material::default() },
        Material { name: "glass".into(), base_color: [0.0, 0.5, 1.0, 0.5], ..Material::default() },
    ];
    let uv = |corner: usize| [corner as f64 / count as f64, if corner < 16 { 0.25 } else { 0.75 }];
    mesh.texture_coordinates =
        Some(CornerAttribute { values: (0..count).map(uv).collect(), indices: (0..count as u32).map(Some).collect() });
    let normals = vec![[0.0, 0.0, 1.0], [0.0, 0.6, 0.8]];
    let indices = (0..count).map(|corner| Some(u32::from(corner >= 32))).collect();
    mesh.normals = Some(CornerAttribute { values: normals, indices });
    mesh
}

fn write_all(format: &dyn Format, mesh: &Mesh, poses: &[(&str, Vec<Point3<f64>>)]) -> Vec<u8> {
    let Some(MeshWriter::Sequence(writer)) = format.writer() else { unreachable!("glTF holds sequences") };
    let file = MemoryFile::default();
    let mut writer = writer.start(mesh, poses.len(), Box::new(file.clone())).unwrap();
    poses.iter().for_each(|(name, positions)| writer.add(name, None, positions).unwrap());
    writer.finish().unwrap();
    file.bytes()
}

/// Two poses: everything moves, and one vertex moves.
fn poses(mesh: &Mesh) -> Vec<(&'static str, Vec<Point3<f64>>)> {
    let mut one = mesh.positions.clone();
    one[3] += Vector3::new(0.0, 0.25, 0.5);
    vec![("twist", twisted(&mesh.positions)), ("one", one)]
}

fn corners(mesh: &Mesh, positions: &[Point3<f64>]) -> Vec<Point3<f64>> {
    mesh.polygons.corners().iter().map(|&v| positions[v as usize]).collect()
}

/// Every triangle of a fan from the first corner.
fn fans(mesh: &Mesh) -> Mesh {
    let mut triangles = Vec::new();
    for polygon in mesh.polygons.iter() {
        triangles.extend(polygon[1..].windows(2).map(|pair| [polygon[0], pair[0], pair[1]]));
    }
    Mesh::from_triangles(mesh.positions.clone(), &triangles)
}

fn check(mesh: &Mesh, poses: &[(&str, Vec<Point3<f64>>)], back: &MeshSequence) {
    let fans = fans(mesh);
    let rest = corners(&fans, &mesh.positions);
    assert!(distance(&corners(&back.rest, &back.rest.positions), &rest) <= f32_rounding(&rest));
    assert_eq!(
        back.poses.iter().map(|pose| &pose.name[..]).collect::<Vec<_>>(),
        poses.iter().map(|p| p.0).collect::<Vec<_>>()
    );
    for (pose, (_, positions)) in back.poses.iter().zip(poses) {
        let expected = corners(&fans, positions);
        let bound = f32_rounding(&expected) + f32_rounding(&rest);
        assert!(distance(&corners(&back.rest, &pose.positions.get().unwrap()), &expected) <= bound);
    }
}

#[test]
fn a_triangle_mesh_comes_back_with_its_order_and_its_poses() {
    let mut mesh = fans(&grid(6));
    // A vertex of no polygon keeps its place too.
    mesh.positions.insert(36, Point3::new(0.5, 0.5, 0.5));
    let poses = poses(&mesh);
    let animation = PoseAnimation::Play;
    let (glb, gltf) = (Glb { animation, ..Glb::default() }, Gltf { animation, ..Gltf::default() });
    for (format, name) in [(&glb as &dyn Format, "a.glb"), (&gltf, "a.gltf")] {
        let back = read(format, name, &write_all(format, &mesh, &poses)).unwrap();
        check(&mesh, &poses, &back);
        assert_eq!(back.rest.polygons, mesh.polygons);
        assert!(distance(&back.rest.positions, &mesh.positions) <= f32_rounding(&mesh.positions));
        assert_eq!(back.warnings, Vec::<String>::new());
        let animation = &back.animations[0];
        assert_eq!((&animation.name[..], &animation.channels[..]), ("poses", &["morph targets".to_owned()][..]));
        assert!((animation.seconds - 1.0 / 24.0).abs() < 1e-8);
    }
}

#[test]
fn parts_materials_and_attributes_come_back() {
    let mesh = furnished();
    let poses = poses(&mesh);
    let back = read(&Glb::default(), "a.glb", &write_all(&Glb::default(), &mesh, &poses)).unwrap();
    check(&mesh, &poses, &back);
    let names = |mesh: &Mesh| mesh.parts.iter().map(|p| (p.object.clone(), p.material.clone())).collect::<Vec<_>>();
    assert_eq!(names(&back.rest), names(&mesh));
    assert_eq!(back.rest.parts.iter().map(|part| part.polygons.clone()).collect::<Vec<_>>(), [0..8, 8..16, 16..32]);
    assert_eq!(back.rest.materials, mesh.materials);
    let uv = back.rest.texture_coordinates.unwrap();
    // The first corner of the second triangle of a quad is the quad's first.
    let [u, v] = uv.values[uv.indices[3].unwrap() as usize];
    assert!(u.abs() < 1e-7 && (v - 0.25).abs() < 1e-7);
    let normals = back.rest.normals.unwrap();
    assert_eq!(normals.values[normals.indices[95].unwrap() as usize].map(|x| x as f32), [0.0, 0.6, 0.8]);
}

#[test]
fn without_poses_there_is_no_animation_and_equal_names_are_told_apart() {
    let mesh = grid(3);
    let back = read(&Glb::default(), "a.glb", &write_all(&Glb::default(), &mesh, &[])).unwrap();
    assert!(back.poses.is_empty() && back.animations.is_empty());
    let twice = [("a", mesh.positions.clone()), ("a", mesh.positions.clone())];
    let back = read(&Glb::default(), "a.glb", &write_all(&Glb::default(), &mesh, &twice)).unwrap();
    assert_eq!(back.poses.iter().map(|pose| &pose.name[..]).collect::<Vec<_>>(), ["a", "a-1"]);
}

#[test]
fn numbered_poses_are_played_and_named_ones_are_not() {
    let mesh = grid(3);
    let clips = |names: [&'static str; 2]| {
        let poses = names.map(|name| (name, mesh.positions.clone()));
        read(&Glb::default(), "a.glb", &write_all(&Glb::default(), &mesh, &poses)).unwrap().animations.len()
    };
    assert_eq!((clips(["horse-01", "horse-02"]), clips(["smile", "frown"])), (1, 0));
}

#[test]
fn still_vertices_cost_no_space() {
    let mesh = grid(60);
    let mut one = mesh.positions.clone();
    one[7].z += 1.0;
    let none = write_all(&Glb::default(), &mesh, &[]).len();
    let still = write_all(&Glb::default(), &mesh, &[("still", mesh.positions.clone())]).len();
    let one = write_all(&Glb::default(), &mesh, &[("one", one)]).len();
    let all = write_all(&Glb::default(), &mesh, &[("all", twisted(&mesh.positions))]).len();
    assert!(still < none + 1500 && one < none + 2000, "{none} {still} {one}");
    assert!(all >= none + 2 * 12 * 3600);
}

#[test]
fn equal_input_gives_equal_bytes() {
    let mesh = furnished();
    assert!(write_all(&Glb::default(), &mesh, &poses(&mesh)) == write_all(&Glb::default(), &mesh, &poses(&mesh)));
}

#[test]
fn a_glb_that_is_too_large_to_be_held_is_written_as_it_comes() {
    let mesh = grid(300);
    let moved = |k: usize| mesh.positions.iter().map(|p| p + Vector3::z() * (k + 1) as f64).collect::<Vec<_>>();
    // Twelve bytes a vertex and pose: 42 MB, of which 32 are held.
    let written = |most: usize| {
        let glb = Glb { pose_normals: false, ..Glb::default() };
        let Some(MeshWriter::Sequence(format)) = glb.writer() else { unreachable!("glTF holds sequences") };
        let file = MemoryFile::default();
        let mut writer = format.start(&mesh, most, Box::new(file.clone())).unwrap();
        (0..40).for_each(|k| writer.add(&format!("pose-{k}"), None, &moved(k)).unwrap());
        assert!(file.bytes().len() > 30_000_000, "it is in the file before the end");
        writer.finish().unwrap();
        file.bytes()
    };
    let expected = written(40);
    for bytes in [&expected, &written(36), &written(4000)] {
        let json_length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
        assert_eq!(u32::from_le_bytes(bytes[8..12].try_into().unwrap()) as usize, bytes.len());
        let sequence = read(&Glb::default(), "large.glb", bytes).unwrap();
        assert_eq!(sequence.poses.len(), 40);
        let posed = sequence.poses[39].positions.get().unwrap();
        let rises = posed.iter().zip(&sequence.rest.positions).map(|(p, q)| p.z - q.z);
        // f32 holds numbers of this size to 4e-6.
        assert!(rises.map(|rise| (rise - 40.0).abs()).fold(0.0, f64::max) < 1e-5);
        // What follows the JSON is the same, however much room was left.
        let numbers = |bytes: &[u8], json: usize| bytes[20 + json..].to_vec();
        let of_expected = u32::from_le_bytes(expected[12..16].try_into().unwrap()) as usize;
        assert!(numbers(bytes, json_length) == numbers(&expected, of_expected));
    }
    let json = &expected[20..20 + u32::from_le_bytes(expected[12..16].try_into().unwrap()) as usize];
    let spaces = json.iter().rev().take_while(|byte| **byte == b' ').count();
    assert!(spaces < json.len() / 2, "{spaces} of {} bytes of room are left", json.len());
}

#[test]
fn what_gltf_cannot_hold_is_an_error() {
    let mut mesh = grid(3);
    mesh.positions[4].x = 1e39;
    let error = Glb::default().writer().map(|writer| match writer {
        MeshWriter::Sequence(writer) => writer.start(&mesh, 0, Box::<MemoryFile>::default()).err().unwrap().to_string(),
        MeshWriter::Pose(_) => unreachable!(),
    });
    assert_eq!(error.unwrap(), "vertex 4 (from 0) has coordinate 1e39, beyond the numbers of glTF");
    let still = Glb { frames_per_second: 0.0, ..Glb::default() };
    let Some(MeshWriter::Sequence(writer)) = still.writer() else { unreachable!() };
    assert_eq!(
        writer.start(&grid(3), 0, Box::<MemoryFile>::default()).err().unwrap().to_string(),
        "frames_per_second: expected 0.001 to 1000000, found 0"
    );
}

/// Runs the Khronos validator; its counts of errors, warnings, infos and hints.
fn validate(bytes: &[u8], name: &str) -> Option<String> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/gltf-validator");
    if !folder.join("node_modules/gltf-validator").exists() {
        missing("gltf-validator", "run `npm ci --prefix tests/gltf-validator`");
        return None;
    }
    let file = tempfile::Builder::new().suffix(name).tempfile().unwrap();
    std::fs::write(file.path(), bytes).unwrap();
    let output = Command::new("node").arg(folder.join("validate.mjs")).arg(file.path()).output();
    let output = output.expect("node is there where its packages are");
    Some(String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr))
}

/// What is left of a report when texture coordinates may be there without a texture, as many are.
fn without_textures(report: &str) -> String {
    let (counts, messages) = report.split_once('\n').unwrap();
    // A report without messages is its counts alone.
    let messages = if messages.is_empty() { "[]" } else { messages };
    let messages: Vec<serde_json::Value> = serde_json::from_str(messages).expect("a list of messages");
    let unused = |m: &serde_json::Value| {
        m["code"] == "UNUSED_OBJECT" && m["pointer"].as_str().is_some_and(|at| at.ends_with("/TEXCOORD_0"))
    };
    let others: Vec<_> = messages.iter().filter(|message| !unused(message)).collect();
    let quiet = counts.starts_with("{\"errors\":0,\"warnings\":0,") && others.is_empty();
    if quiet { "no remarks".into() } else { report.into() }
}

#[test]
fn the_khronos_validator_finds_nothing_to_say() {
    let clean = "no remarks";
    let mesh = furnished();
    // Far more poses than are keyed densely, so that the weights are sparse.
    let still: Vec<_> = (0..80).map(|_| ("still", mesh.positions.clone())).collect();
    let played = Glb { animation: PoseAnimation::Play, ..Glb::default() };
    let all = [write_all(&played, &mesh, &poses(&mesh)), write_all(&played, &mesh, &still)];
    let plain = write_all(&Glb { pose_normals: false, ..Glb::default() }, &grid(4), &poses(&grid(4)));
    let empty = write_all(&Glb::default(), &grid(2), &[]);
    for bytes in all.iter().chain([&plain, &empty]) {
        let Some(report) = validate(bytes, ".glb") else { return };
        assert_eq!(without_textures(&report), clean);
    }
    let text = write_all(&Gltf::default(), &mesh, &poses(&mesh));
    assert_eq!(without_textures(&validate(&text, ".gltf").unwrap()), clean);
}

#[test]
fn a_real_sequence_passes_the_khronos_validator() {
    for (rest, pose) in [
        ("sumner-camel-poses/camel-reference.obj", "sumner-camel-poses/camel-03.obj"),
        ("ict-facekit/generic_neutral_mesh.obj", "ict-facekit/jawOpen.obj"),
    ] {
        let (Some(rest), Some(pose)) = (data(rest), data(pose)) else { return };
        let mesh = read_file(&Obj::default(), &rest).rest;
        let poses = [("pose", Obj::default().read_pose(&input(&pose), &Selection::default(), &mesh).unwrap())];
        let bytes = write_all(&Glb::default(), &mesh, &poses);
        let back = read(&Glb::default(), "a.glb", &bytes).unwrap();
        assert_eq!(back.rest.polygons.len(), fans(&mesh).polygons.len());
        assert!(
            distance(&back.rest.positions[..mesh.positions.len()], &mesh.positions) <= f32_rounding(&mesh.positions)
        );
        let Some(report) = validate(&bytes, ".glb") else { return };
        assert!(report.starts_with("{\"errors\":0,\"warnings\":0,"), "{report}");
    }
}

proptest! {
    #[test]
    fn no_damage_makes_the_reader_panic(edits in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..8), cut in any::<prop::sample::Index>()) {
        let mut bytes = write_all(&Glb::default(), &furnished(), &poses(&furnished()));
        edits.iter().for_each(|(at, byte)| { let at = at.index(bytes.len()); bytes[at] = *byte; });
        if let Ok(sequence) = read(&Glb::default(), "a.glb", &bytes) {
            sequence.rest.validate().unwrap();
        }
        let _ = read(&Glb::default(), "a.glb", &bytes[..cut.index(bytes.len())]);
    }

    #[test]
    fn no_damaged_number_in_the_json_makes_the_reader_panic(edits in prop::collection::vec((any::<prop::sample::Index>(), prop::sample::select(b"0123456789".to_vec())), 1..6)) {
        let mut bytes = write_all(&Glb::default(), &furnished(), &poses(&furnished()));
        let end = 20 + u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
        let digits: Vec<_> = (20..end).filter(|&at| bytes[at].is_ascii_digit()).collect();
        edits.iter().for_each(|(at, byte)| bytes[digits[at.index(digits.len())]] = *byte);
        if let Ok(sequence) = read(&Glb::default(), "a.glb", &bytes) {
            sequence.rest.validate().unwrap();
            sequence.poses.iter().for_each(|pose| assert_eq!(pose.positions.get().unwrap().len(), sequence.rest.positions.len()));
        }
    }
}

#[test]
fn an_obj_brings_its_textures_and_its_colours() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    std::fs::create_dir(at("tex")).unwrap();
    let (png, jpeg) = (b"\x89PNG\r\n\x1a\nskin".to_vec(), b"\xff\xd8\xff\xe0eyes".to_vec());
    std::fs::write(at("tex/my skin.png"), &png).unwrap();
    std::fs::write(at("eyes.jpg"), &jpeg).unwrap();
    std::fs::write(at("old.tga"), b"\0\0\x02").unwrap();
    let library = "newmtl skin\nKd 0 0 0\nd 0.5\nmap_Kd -s 1 1 1 tex\\my skin.png\nnewmtl eyes\nKd 1 1 1\nmap_Kd C:\\Users\\me\\eyes.jpg\n\
        newmtl old\nKd 0.25 0.5 1\nmap_Kd old.tga\nnewmtl gone\nKd 1 0 0\nmap_Kd gone.png\n";
    std::fs::write(at("a.mtl"), library).unwrap();
    let faces = ["skin", "eyes", "old", "gone"].map(|name| format!("usemtl {name}\nf 1/1 2/1 3/1\n")).concat();
    std::fs::write(
        at("a.obj"),
        format!("mtllib a.mtl\nv 0 0 0 1 0.5 0\nv 1 0 0 1 1 1\nv 0 1 0 0 0 0\nvt 0 0\n{faces}"),
    )
    .unwrap();
    let selection = Selection { keep_document: true, ..Selection::default() };
    let mesh = Obj::default().read(&input(at("a.obj")), &selection).unwrap().rest;

    let glb = Glb::default();
    let Some(MeshWriter::Sequence(sequence)) = glb.writer() else { unreachable!("glTF holds sequences") };
    let warnings = sequence.start(&mesh, 0, Box::<MemoryFile>::default()).unwrap().warnings();
    assert_eq!(warnings.len(), 2, "{warnings:?}");
    assert!(warnings[0].starts_with("texture left out: `old.tga` is neither PNG nor JPEG"), "{warnings:?}");
    assert!(warnings[1].starts_with("texture left out: `gone.png` cannot be read"), "{warnings:?}");
    let bytes = write_all(&glb, &mesh, &poses_of_three(&mesh));
    let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    let json: serde_json::Value = serde_json::from_slice(&bytes[20..20 + length]).unwrap();
    let binary = &bytes[28 + length..];
    for (number, (name, kind, contents)) in
        [("my skin.png", "image/png", &png), ("eyes.jpg", "image/jpeg", &jpeg)].into_iter().enumerate()
    {
        let image = &json["images"][number];
        assert_eq!((image["name"].as_str(), image["mimeType"].as_str()), (Some(name), Some(kind)));
        let view = &json["bufferViews"][image["bufferView"].as_u64().unwrap() as usize];
        let start = view["byteOffset"].as_u64().unwrap() as usize;
        assert_eq!(&binary[start..start + view["byteLength"].as_u64().unwrap() as usize], &contents[..]);
        assert_eq!(json["textures"][number]["source"], number);
    }
    let looks = |number: usize| &json["materials"][number]["pbrMetallicRoughness"];
    // The image stands in the place of the colour; without one the colour stays.
    assert_eq!(looks(0)["baseColorFactor"], serde_json::json!([1.0, 1.0, 1.0, 0.5]));
    assert_eq!(looks(0)["baseColorTexture"]["index"], 0);
    assert_eq!(looks(1)["baseColorTexture"]["index"], 1);
    assert_eq!(looks(2)["baseColorFactor"], serde_json::json!([0.25, 0.5, 1.0, 1.0]));
    assert!(looks(3)["baseColorTexture"].is_null());
    let back = read(&glb, "a.glb", &bytes).unwrap().rest;
    for (back, there) in back.vertex_colors.unwrap().iter().zip(mesh.vertex_colors.unwrap()) {
        // f32 of a linear colour, whose inverse is at most 13 times as steep.
        back.iter().zip(there).for_each(|(a, b)| assert!((a - b).abs() < 1e-6, "{back:?} {there:?}"));
    }
}

/// One pose, in which the first vertex moves.
fn poses_of_three(mesh: &Mesh) -> Vec<(&'static str, Vec<Point3<f64>>)> {
    let mut moved = mesh.positions.clone();
    moved[0].z += 0.5;
    vec![("up", moved)]
}
