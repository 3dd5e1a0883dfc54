//! Small files of known contents: copies, names, weights of existing clips, and what stays untouched.

use nalgebra::{Point3, Vector3};
use serde_json::{Value, json};

use super::{
    build::{Builder, write},
    difference::differences,
    evaluate::{load, load_parts, parts, shapes},
};
use crate::Glb;

/// A pose in which every vertex of `mesh` goes up by its number.
fn raised(positions: &[Point3<f64>]) -> Vec<Point3<f64>> {
    let up = |(vertex, position): (usize, &Point3<f64>)| position + Vector3::z() * (1.0 + vertex as f64);
    positions.iter().enumerate().map(up).collect()
}

/// Two nodes with one mesh, the second twice as large, mirrored and moved; a third with a mesh of its own.
fn two_nodes() -> Vec<u8> {
    let mut file = Builder::new(json!({
        "asset": { "version": "2.0" },
        "scene": 0,
        "scenes": [{ "nodes": [0, 1, 2] }],
        "nodes": [
            { "mesh": 0, "name": "left" },
            { "mesh": 0, "name": "right", "scale": [-2, 2, 2], "translation": [5, 0, 0], "weights": [0.5] },
            { "mesh": 1, "name": "other", "weights": [] },
        ],
    }));
    let mut primitive = file.square(1.0);
    primitive["targets"] = json!([{ "POSITION": file.binary.attribute(&[[0.0_f32, 0.5, 0.0]; 4], true).unwrap() }]);
    let other = file.square(3.0);
    file.json["meshes"] = json!([
        { "name": "wing", "primitives": [primitive], "extras": { "targetNames": ["flap"] }, "weights": [0.25] },
        { "name": "body", "primitives": [other] },
    ]);
    file.glb()
}

#[test]
fn nodes_that_show_one_mesh_get_copies_where_they_move_differently() {
    let before = two_nodes();
    let mesh = load(&before);
    let posed = raised(&mesh.positions);
    let (after, warnings) = write(&Glb::default(), &mesh, &[("up", None, posed.clone())]);
    assert_eq!(warnings, ["meshes that several nodes show are copied, since they move differently: `wing`"]);
    let json = parts(&after).0;
    assert_eq!(json["nodes"][1]["mesh"], 2);
    assert_eq!(json["nodes"][1]["weights"], json!([0.5, 0.0]));
    // The copy has the attributes and targets of the mesh.
    let (wing, copy) = (&json["meshes"][0], &json["meshes"][2]);
    assert_eq!(wing["primitives"][0]["attributes"], copy["primitives"][0]["attributes"]);
    assert_eq!(wing["primitives"][0]["targets"][0], copy["primitives"][0]["targets"][0]);
    assert_eq!((&wing["weights"], &copy["weights"]), (&json!([0.25, 0.0]), &json!([0.25, 0.0])));
    assert_eq!(copy["extras"]["targetNames"], json!(["flap", "up"]));
    let found: Vec<_> = shapes(&after).iter().flat_map(|shape| shape.with(shape.targets.len() - 1)).collect();
    // Small whole numbers and halves of them: nothing is rounded.
    assert_eq!(found, posed);
}

#[test]
fn nodes_that_show_one_mesh_share_it_where_they_move_alike() {
    let before = two_nodes();
    let mesh = load(&before);
    // Up by 1 in the mesh, which is 2 under the larger node.
    let mut posed = mesh.positions.clone();
    posed[..4].iter_mut().for_each(|p| p.z += 1.0);
    posed[4..8].iter_mut().for_each(|p| p.z += 2.0);
    let (after, warnings) = write(&Glb::default(), &mesh, &[("up", None, posed.clone())]);
    assert_eq!(warnings, [""; 0]);
    let expected = [
        "/nodes/1/weights: +1",
        "/meshes/0/primitives/0/targets: +1",
        "/meshes/0/extras/targetNames: +1",
        "/meshes/0/weights: +1",
        "/meshes/1/primitives/0/targets: new",
        "/meshes/1/extras: new",
        "/bufferViews: +1",
        "/accessors: +2",
        "/buffers/0/byteLength: changed",
    ];
    let mut found = differences(&parts(&before).0, &parts(&after).0);
    let mut wanted = expected.map(str::to_owned).to_vec();
    found.sort();
    wanted.sort();
    assert_eq!(found, wanted);
    let found: Vec<_> = shapes(&after).iter().flat_map(|shape| shape.with(shape.targets.len() - 1)).collect();
    assert_eq!(found, posed);
}

#[test]
fn meshes_that_were_not_read_stay_as_they_are() {
    let before = two_nodes();
    let mesh = load_parts(&before, &["other"]);
    let (after, _) = write(&Glb::default(), &mesh, &[("up", None, raised(&mesh.positions))]);
    let (old, new) = (parts(&before).0, parts(&after).0);
    assert_eq!(old["nodes"], new["nodes"]);
    assert_eq!(old["meshes"][0], new["meshes"][0]);
    assert_eq!(new["meshes"][1]["primitives"][0]["targets"].as_array().unwrap().len(), 1);
}

#[test]
fn names_that_exist_get_a_number_and_a_warning() {
    let before = two_nodes();
    let mesh = load(&before);
    let poses = ["flap", "new", "new"].map(|name| (name, None, mesh.positions.clone()));
    let (after, warnings) = write(&Glb::default(), &mesh, &poses);
    let told = "morph targets of the names exist already: `flap` is written as `flap-2`, `new` is written as `new-2`";
    assert_eq!(warnings, [told]);
    let json = parts(&after).0;
    assert_eq!(json["meshes"][0]["extras"]["targetNames"], json!(["flap", "flap-2", "new", "new-2"]));
    assert_eq!(json["meshes"][1]["extras"]["targetNames"], json!(["flap-2", "new", "new-2"]));
}

#[test]
fn points_lines_and_primitives_left_out_keep_the_number_of_targets() {
    let mut file = Builder::new(json!({
        "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0] }], "nodes": [{ "mesh": 0 }],
    }));
    let (mut read, left_out, mut line) = (file.square(1.0), file.square(2.0), file.square(4.0));
    let mut outline = read.clone();
    outline["mode"] = 1.into();
    read["material"] = 0.into();
    line["mode"] = 1.into();
    file.json["materials"] = json!([{ "name": "red" }]);
    file.json["meshes"] = json!([{ "primitives": [left_out, read, outline, line] }]);
    let before = file.glb();
    let mesh = load_parts(&before, &["red"]);
    let (after, _) = write(&Glb::default(), &mesh, &[("up", None, raised(&mesh.positions))]);
    let json = parts(&after).0;
    let accessor = |primitive: usize| {
        let targets = json["meshes"][0]["primitives"][primitive]["targets"].as_array().unwrap();
        assert_eq!(targets.len(), 1);
        targets[0]["POSITION"].as_u64().unwrap() as usize
    };
    let zero = [0.0; 3];
    let zeros = json!({ "componentType": 5126, "count": 4, "type": "VEC3", "min": zero, "max": zero });
    assert_eq!(json["accessors"][accessor(0)], zeros);
    // An outline has the vertices of what it is around.
    assert_eq!(accessor(2), accessor(1));
    assert_eq!(accessor(3), accessor(0));
}

#[test]
fn vertices_without_a_way_back_stay_and_are_counted() {
    let mut file = Builder::new(json!({
        "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0, 1] }],
        "nodes": [{ "mesh": 0, "scale": [1, 1, 0] }, { "mesh": 1 }],
    }));
    let (flat, free) = (file.square(1.0), file.square(2.0));
    file.json["meshes"] = json!([{ "name": "flat", "primitives": [flat] }, { "primitives": [free] }]);
    let before = file.glb();
    let mesh = load(&before);
    let mut posed = raised(&mesh.positions);
    posed[2] = mesh.positions[2];
    let (after, warnings) = write(&Glb::default(), &mesh, &[("up", None, posed.clone())]);
    let told = "3 vertices of `flat` do not move, since joints or nodes flatten the space they are stored in";
    assert_eq!(warnings, [told]);
    let shapes = shapes(&after);
    assert_eq!(shapes[0].with(0), mesh.positions[..4]);
    assert_eq!(shapes[1].with(0), posed[4..]);
}

#[test]
fn text_output_holds_the_same() {
    use mimesh_core::{
        stage::{Format, MeshWriter},
        testkit::memory_file::MemoryFile,
    };

    let before = two_nodes();
    let mesh = load(&before);
    let gltf = crate::Gltf::default();
    let Some(MeshWriter::Sequence(format)) = gltf.writer() else { unreachable!("a glTF is a sequence") };
    let file = MemoryFile::default();
    let mut writer = format.start(&mesh, 1, Box::new(file.clone())).unwrap();
    writer.add("up", None, &raised(&mesh.positions)).unwrap();
    writer.finish().unwrap();
    let mut text: Value = serde_json::from_slice(&file.bytes()).unwrap();
    let (json, bytes) = parts(&write(&Glb::default(), &mesh, &[("up", None, raised(&mesh.positions))]).0);
    let buffer = text["buffers"][0].as_object_mut().unwrap();
    let uri = buffer.shift_remove("uri").unwrap();
    let data = uri.as_str().unwrap().strip_prefix("data:application/octet-stream;base64,").unwrap();
    use base64::Engine as _;
    assert_eq!(base64::engine::general_purpose::STANDARD.decode(data).unwrap(), bytes);
    assert_eq!(text, json);
}
