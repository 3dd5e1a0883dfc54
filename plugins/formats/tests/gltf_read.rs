//! glTF: what real files hold, where nodes place meshes, and which of them are chosen.

mod support;

use mimesh_core::{
    mesh::Mesh,
    stage::{BytesInput, Format, Selection},
    testkit::data::data,
};
use mimesh_formats::{Glb, Gltf};
use nalgebra::Point3;
use serde_json::json;
use support::{
    distance,
    gltf::{File, names},
    message, read_file,
};

#[test]
fn real_files_hold_what_is_known_of_them() {
    // Vertices, triangles, morph targets, clips.
    let known = [
        ("khronos-gltf/BrainStem.glb", [34159, 61666, 0, 1]),
        ("khronos-gltf/Fox.glb", [1728, 576, 0, 3]),
        ("khronos-gltf/CesiumMan.glb", [3273, 4672, 0, 1]),
        ("khronos-gltf/RiggedSimple.glb", [960, 892, 0, 1]),
        ("khronos-gltf/SimpleSkin.gltf", [10, 8, 0, 1]),
        ("khronos-gltf/MorphStressTest.gltf", [1528, 2412, 8, 3]),
    ];
    for (file, counts) in known {
        let Some(path) = data(file) else { continue };
        let sequence = read_file(&Glb::default(), &path);
        let rest = &sequence.rest;
        let found = [rest.positions.len(), rest.polygons.len(), sequence.poses.len(), sequence.animations.len()];
        assert_eq!(found, counts, "{file}");
    }
    let Some(path) = data("khronos-gltf/MorphStressTest.gltf") else { return };
    let stress = read_file(&Gltf::default(), &path);
    assert_eq!(names(&stress), ["Key 1", "Key 2", "Key 3", "Key 4", "Key 5", "Key 6", "Key 7", "Key 8"]);
    let Some(path) = data("robot/RobotExpressive.glb") else { return };
    let robot = read_file(&Glb::default(), &path);
    assert_eq!(names(&robot), ["Angry", "Surprised", "Sad"]);
    assert_eq!(robot.animations.len(), 14);
    let objects: std::collections::BTreeSet<_> = robot.rest.parts.iter().map(|part| &part.object).collect();
    assert_eq!(objects.len(), 14);
}

#[test]
fn skinned_files_stand_as_their_joints_have_them() {
    // Low and high corner in the evaluation of three.js, which rounds in places to f32.
    let known = [
        ("khronos-gltf/CesiumMan.glb", [[-0.56914, 0.0, -0.131], [0.56914, 1.50655, 0.18095]]),
        ("robot/RobotExpressive.glb", [[-1.52069, -0.0203, -1.26915], [1.57876, 4.44092, 1.41604]]),
    ];
    for (file, [low, high]) in known {
        let Some(path) = data(file) else { continue };
        let rest = read_file(&Glb::default(), &path).rest;
        let (a, b) = rest.bounding_box_of(&rest.positions);
        let far = (a - Point3::from(low)).amax().max((b - Point3::from(high)).amax());
        assert!(far < 1e-4, "{file}: {a} {b}");
    }
}

#[test]
fn nodes_place_meshes_and_primitives_share_vertices() {
    // Four corners of a square as signed bytes at a stride of 4, normalised; a strip and a fan of them.
    let bytes: Vec<u8> = [[0, 0, 0, 0], [127, 0, 0, 0], [0, 127, 0, 0], [127, 127, 0, 0_u8]].concat();
    let json = serde_json::json!({
        "asset": { "version": "2.0" },
        "extensionsRequired": ["KHR_mesh_quantization"],
        "buffers": [{ "byteLength": 20, "uri": "the%20numbers.bin" }],
        "bufferViews": [
            { "buffer": 0, "byteLength": 16, "byteStride": 4 }, { "buffer": 0, "byteOffset": 16, "byteLength": 4 },
        ],
        "accessors": [
            { "bufferView": 0, "componentType": 5120, "normalized": true, "count": 4, "type": "VEC3" },
            { "bufferView": 1, "componentType": 5121, "count": 4, "type": "SCALAR" },
            { "bufferView": 0, "componentType": 5120, "count": 4, "type": "VEC3" },
        ],
        "meshes": [{ "primitives": [
            { "attributes": { "POSITION": 0 }, "mode": 5, "targets": [{ "POSITION": 2 }] },
            { "attributes": { "POSITION": 0 }, "mode": 6, "indices": 1, "targets": [{ "POSITION": 2 }] },
            { "attributes": { "POSITION": 0 }, "mode": 0 },
        ] }],
        "nodes": [
            { "children": [2], "translation": [0, 0, 5], "scale": [2, 2, 2] },
            { "mesh": 0, "name": "mirrored", "scale": [-1, 1, 1] },
            { "mesh": 0, "name": "turned", "rotation": [0, 0, 0.5_f64.sqrt(), 0.5_f64.sqrt()] },
            { "mesh": 0, "name": "in no scene" },
        ],
        "scenes": [{ "nodes": [0, 1] }],
    });
    let mut input = BytesInput::new("a.gltf", json.to_string());
    input.others.insert("the numbers.bin".into(), [&bytes[..], &[0, 1, 3, 2]].concat());
    let sequence = Gltf::default().read(&input, &Selection::default()).unwrap();
    let mesh = &sequence.rest;
    let p = Point3::new;
    let expected = [
        p(0., 0., 5.),
        p(0., 2., 5.),
        p(-2., 0., 5.),
        p(-2., 2., 5.),
        p(0., 0., 0.),
        p(-1., 0., 0.),
        p(0., 1., 0.),
        p(-1., 1., 0.),
    ];
    // A quaternion of unit length to the last bit.
    assert!(distance(&mesh.positions, &expected) < 1e-15);
    assert_eq!(
        mesh.polygons.iter().map(<[u32]>::to_vec).collect::<Vec<_>>(),
        [[0, 1, 2], [1, 3, 2], [0, 1, 3], [0, 3, 2], [4, 6, 5], [5, 6, 7], [4, 7, 5], [4, 6, 7],]
    );
    let surface = mimesh_core::mesh::Surface::new(mesh).unwrap();
    assert!(surface.area_normals(&surface.positions).iter().all(|normal| normal.z > 0.0));
    assert_eq!(
        mesh.parts.iter().map(|part| part.object.as_deref().unwrap()).collect::<Vec<_>>(),
        ["turned", "mirrored"]
    );
    assert_eq!(sequence.warnings, ["primitives of points or lines were left out: `turned`, `mirrored`"]);
    // The displacements are turned and scaled as the mesh is.
    assert_eq!(sequence.poses.len(), 1);
    assert_eq!(sequence.poses[0].name, "target-0");
    let positions = sequence.poses[0].positions.get().unwrap();
    assert!((positions[1] - p(0., 256., 5.)).norm() < 1e-12);
    assert!((positions[5] - p(-128., 0., 0.)).norm() < 1e-12);
}

/// Three triangles: `left` and `right` show one mesh of two materials, `other` a mesh of its own.
fn three() -> File {
    let mut file = File::new();
    let position = file.floats(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    let primitive = |material: usize| json!({ "attributes": { "POSITION": position }, "material": material });
    file.push(
        "materials",
        json!({ "name": "skin", "pbrMetallicRoughness": { "baseColorFactor": [0.1, 0.2, 0.3, 1] } }),
    );
    file.push("materials", json!({}));
    file.push("meshes", json!({ "name": "pair", "primitives": [primitive(0), primitive(1)] }));
    file.push("meshes", json!({ "name": "single", "primitives": [primitive(0)] }));
    file.push("nodes", json!({ "name": "left", "mesh": 0 }));
    file.push("nodes", json!({ "name": "right", "mesh": 0 }));
    file.push("nodes", json!({ "mesh": 1 }));
    file.json["scenes"] = json!([{ "nodes": [0, 1, 2] }]);
    file
}

#[test]
fn meshes_are_chosen_by_node_mesh_or_material() {
    let file = three();
    let parts = |mesh: &Mesh| {
        let part = |p: &mimesh_core::mesh::Part| {
            format!("{} {}", p.object.as_deref().unwrap(), p.material.as_deref().unwrap())
        };
        mesh.parts.iter().map(part).collect::<Vec<_>>()
    };
    let chosen = |names: &[&str]| {
        let meshes = names.iter().map(|name| (*name).to_owned()).collect();
        parts(&file.select(&Selection { meshes, ..Selection::default() }).unwrap().rest)
    };
    let all = ["left skin", "left material-1", "right skin", "right material-1", "single skin"];
    assert_eq!(chosen(&[]), all);
    assert_eq!(chosen(&["left"]), all[..2]);
    assert_eq!(chosen(&["pair"]), all[..4]);
    assert_eq!(chosen(&["material-1", "single"]), ["left material-1", "right material-1", "single skin"]);
    let skin = file.select(&Selection { meshes: vec!["skin".into()], ..Selection::default() }).unwrap().rest;
    assert_eq!((skin.polygons.len(), skin.positions.len()), (3, 9));
    assert_eq!(skin.materials.len(), 1);
    assert_eq!(skin.materials[0].base_color, [0.1, 0.2, 0.3, 1.0]);
    let wrong = Selection { meshes: vec!["left".into(), "Head".into()], ..Selection::default() };
    assert_eq!(
        message(&file.select(&wrong).unwrap_err()),
        "a.gltf: nothing in the file is called `Head`: it has the nodes `left`, `right`, `single`, \
         the meshes `pair`, `single`, the materials `skin`, `material-1`\n\
         name parts that the file has, by their nodes, meshes or materials"
    );
}

#[test]
fn meshes_that_are_left_out_are_not_looked_at() {
    let mut file = three();
    file.json["meshes"][1]["primitives"][0]["attributes"]["POSITION"] = 99.into();
    assert!(file.read().is_err());
    assert!(file.select(&Selection { meshes: vec!["pair".into()], ..Selection::default() }).is_ok());
}

#[test]
fn images_are_read_for_a_writer_alone_and_may_be_missing() {
    let mut file = three();
    file.json["images"] =
        json!([{ "uri": "a%20b.png" }, { "uri": "missing.png" }, { "uri": "data:image/png;base64," }]);
    let mut input = BytesInput::new("a.gltf", file.text());
    input.others.insert("a b.png".into(), vec![1]);
    let keep = Selection { keep_document: true, ..Selection::default() };
    let kept = Gltf::default().read(&input, &keep).unwrap();
    assert_eq!(kept.warnings, ["images that cannot be read stay references: `missing.png`"]);
    assert!(format!("{:?}", kept.rest.document).contains(".."));
    let plain = Gltf::default().read(&input, &Selection::default()).unwrap();
    assert_eq!(plain.warnings, Vec::<String>::new());
    assert!(format!("{:?}", plain.rest.document).contains("none"));
}

#[test]
fn a_node_whose_transform_is_no_such_is_named() {
    let error = |node: serde_json::Value| {
        let mut file = three();
        file.json["nodes"][1] = node;
        file.read().unwrap_err().to_string()
    };
    let matrix = error(json!({ "name": "bad", "mesh": 0, "matrix": [1, 0, 0] }));
    assert_eq!(matrix, "a.gltf: node `bad`: `matrix` is [1,0,0]: expected 16 finite numbers");
    let scale = error(json!({ "name": "bad", "mesh": 0, "scale": [1, null, 1] }));
    assert_eq!(scale, "a.gltf: node `bad`: `scale` is [1,null,1]: expected 3 finite numbers");
    let huge = error(json!({ "mesh": 0, "scale": [1e300, 1, 1] }));
    assert_eq!(huge, "a.gltf: node 1 has a transform that is not finite");
}
