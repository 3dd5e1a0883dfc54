//! Avatars: expressions refer to meshes and targets by number, and must find what they found before.

use nalgebra::Vector3;
use serde_json::json;

use super::{
    build::{Builder, write},
    difference::differences,
    evaluate::{load, parts, shapes},
};
use crate::Glb;

/// A head with two targets and a body, with expressions of VRM 1 and blend shapes of VRM 0.
fn avatar() -> Vec<u8> {
    let mut file = Builder::new(json!({
        "asset": { "version": "2.0", "generator": "Studio 4", "extras": { "seed": 1e-7 } },
        "extensionsUsed": ["VRMC_vrm", "VRM", "KHR_materials_unlit"],
        "scene": 0,
        "scenes": [{ "nodes": [0, 1, 2] }],
        "nodes": [{ "mesh": 0, "name": "Face" }, { "mesh": 1, "name": "Body", "extras": [1, null] }, { "camera": 0 }],
        "cameras": [{ "type": "perspective", "perspective": { "yfov": 0.7, "znear": 0.1 } }],
        "materials": [{ "extensions": { "KHR_materials_unlit": {} } }],
        "extensions": {
            "VRMC_vrm": {
                "specVersion": "1.0",
                "expressions": { "preset": { "happy": { "morphTargetBinds": [{ "node": 0, "index": 1, "weight": 1.0 }] } } },
            },
            "VRM": { "blendShapeMaster": { "blendShapeGroups": [{ "binds": [{ "mesh": 0, "index": 0, "weight": 100 }] }] } },
        },
    }));
    let mut face = file.square(1.0);
    let mut target = |z: f32| json!({ "POSITION": file.binary.attribute(&[[0.0, 0.0, z]; 4], true).unwrap() });
    face["targets"] = json!([target(1.0), target(2.0)]);
    face["extras"] = json!({ "targetNames": ["blink", "smile"] });
    let mut teeth = file.square(0.5);
    teeth["targets"] = face["targets"].clone();
    let mut body = file.square(2.0);
    body["material"] = 0.into();
    file.json["meshes"] = json!([
        { "name": "Face", "primitives": [face, teeth], "weights": [0, 0] }, { "name": "Body", "primitives": [body] },
    ]);
    file.glb()
}

#[test]
fn expressions_find_the_targets_that_they_found_before() {
    let before = avatar();
    let mesh = load(&before);
    let posed: Vec<_> = mesh.positions.iter().map(|p| p + Vector3::new(0.5, 0.0, 4.0)).collect();
    let (after, warnings) = write(&Glb::default(), &mesh, &[("puff", None, posed.clone()), ("smile", None, posed)]);
    assert_eq!(warnings, ["morph targets of the names exist already: `smile` is written as `smile-2`"]);
    let (old, new) = (parts(&before).0, parts(&after).0);
    // Displacements of two poses for three primitives, and zeros for normals, which do not turn.
    let mut expected = [
        "/accessors: +7",
        "/bufferViews: +6",
        "/buffers/0/byteLength: changed",
        "/meshes/0/extras: new",
        "/meshes/0/primitives/0/extras/targetNames: +2",
        "/meshes/0/primitives/0/targets: +2",
        "/meshes/0/primitives/1/targets: +2",
        "/meshes/0/weights: +2",
        "/meshes/1/extras: new",
        "/meshes/1/primitives/0/targets: new",
    ];
    expected.sort();
    let mut found = differences(&old, &new);
    found.sort();
    assert_eq!(found, expected);
    assert_eq!(new["meshes"][0]["extras"]["targetNames"], json!(["blink", "smile", "puff", "smile-2"]));
    // Targets 0 and 1 of every primitive still are what they were.
    for (old, new) in shapes(&before).iter().zip(shapes(&after)) {
        assert_eq!(old.targets[..], new.targets[..old.targets.len()]);
    }
}
