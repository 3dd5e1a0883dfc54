//! Nodes that stand for points.

use mimesh_core::stage::{BytesInput, Format, ScenePoint};
use serde_json::json;

use super::build::Builder;
use crate::Glb;

/// The points of a GLB: names, places and whether they are doubtful.
fn points(glb: Vec<u8>) -> Vec<(String, [f64; 3], bool)> {
    let found = Glb::default().read_points(&BytesInput::new("m.glb", glb)).unwrap();
    found.into_iter().map(|ScenePoint { name, position, is_doubtful }| (name, position.into(), is_doubtful)).collect()
}

#[test]
fn nodes_without_another_role_are_points_where_they_stand() {
    let mut file = Builder::new(json!({
        "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0, 6, 8, 12] }, { "nodes": [11] }],
        "extensionsUsed": ["KHR_lights_punctual"],
        "extensions": { "KHR_lights_punctual": { "lights": [{ "type": "point" }] } },
        "cameras": [{ "type": "orthographic", "orthographic": { "xmag": 1, "ymag": 1, "zfar": 2, "znear": 0 } }],
        "nodes": [
            // A group of the mesh, turned by 90° about x, twice as large.
            { "name": "Character", "children": [1, 2, 3, 4, 5], "translation": [1, 0, 0],
              "rotation": [0.5_f64.sqrt(), 0, 0, 0.5_f64.sqrt()], "scale": [2, 2, 2] },
            { "name": "Body", "mesh": 0, "skin": 0 },
            { "name": "nose", "translation": [0, 1, 0] },
            { "name": "Camera", "camera": 0 },
            { "name": "Lamp", "extensions": { "KHR_lights_punctual": { "light": 0 } } },
            { "translation": [5, 5, 5] },
            { "name": "Landmarks", "children": [7] },
            { "name": "ear", "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 3, 4, 5, 1] },
            { "name": "Armature", "children": [9] },
            { "name": "Spine", "children": [10], "translation": [0, 1, 0] },
            { "name": "Spine_end", "translation": [0, 1, 0] },
            { "name": "elsewhere" },
            { "name": "Eye", "mesh": 0 },
        ],
    }));
    let mut primitive = file.square(1.0);
    let joints = file.binary.like(&json!({ "componentType": 5121, "type": "VEC4" }), &[0; 16], 4).unwrap();
    let weights = file.binary.attribute(&[[1.0_f32, 0.0, 0.0, 0.0]; 4], false).unwrap();
    primitive["attributes"]["JOINTS_0"] = joints.into();
    primitive["attributes"]["WEIGHTS_0"] = weights.into();
    file.json["meshes"] = json!([{ "primitives": [primitive] }]);
    file.json["skins"] = json!([{ "joints": [9] }]);
    let found = points(file.glb());
    let names: Vec<_> = found.iter().map(|(name, _, doubtful)| (name.as_str(), *doubtful)).collect();
    assert_eq!(names, [("nose", false), ("Landmarks", true), ("ear", false), ("Spine_end", true)]);
    // The turn takes (0, 1, 0) to (0, 0, 1); the sine is rounded.
    assert!((nalgebra::Point3::from(found[0].1) - nalgebra::Point3::new(1.0, 0.0, 2.0)).norm() < 1e-15);
    assert_eq!(found[2].1, [3.0, 4.0, 5.0]);
    assert_eq!(found[3].1, [0.0, 2.0, 0.0]);
}

#[test]
fn a_damaged_file_is_refused() {
    let broken = json!({ "asset": { "version": "2.0" }, "nodes": [{ "name": "a", "children": [3] }] });
    let error = Glb::default().read_points(&BytesInput::new("m.gltf", broken.to_string())).unwrap_err().to_string();
    assert_eq!(error, "m.gltf: node 3 does not exist: there are 1 (from 0)");
}
