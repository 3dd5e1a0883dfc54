//! glTF: morph targets, their names, and which of them are one pose.

mod support;

use mimesh_core::stage::{PoseChoice, RestShape, Selection};
use nalgebra::Point3;
use serde_json::{Value, json};
use support::gltf::{File, names, positions};

/// Triangles under nodes, one a mesh, each with two morph targets that lift the first vertex by 1 and by 2.
fn triangles(meshes: &[Value]) -> File {
    let mut file = File::new();
    for (index, extras) in meshes.iter().enumerate() {
        let position = file.floats(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
        let targets = [1.0, 2.0].map(|z| json!({ "POSITION": file.floats(&[[0.0, 0.0, z], [0.0; 3], [0.0; 3]]) }));
        let primitive = json!({ "attributes": { "POSITION": position }, "targets": targets });
        file.push("meshes", json!({ "primitives": [primitive], "extras": extras }));
        file.push("nodes", json!({ "mesh": index, "name": format!("mesh{index}") }));
    }
    file.json["scenes"] = json!([{ "nodes": (0..meshes.len()).collect::<Vec<_>>() }]);
    file
}

fn lifts(file: &File) -> Vec<Vec<f64>> {
    let of_pose = |positions: &Vec<Point3<f64>>| positions.iter().step_by(3).map(|p| p.z).collect();
    positions(&file.read().unwrap()).iter().map(of_pose).collect()
}

#[test]
fn targets_of_one_given_name_are_one_pose() {
    let file = triangles(&[json!({ "targetNames": ["a", "b"] }), json!({ "targetNames": ["b", "c"] })]);
    assert_eq!(names(&file.read().unwrap()), ["a", "b", "c"]);
    assert_eq!(lifts(&file), [[1.0, 0.0], [2.0, 1.0], [0.0, 2.0]]);
}

#[test]
fn targets_without_names_are_poses_of_their_mesh() {
    let file = triangles(&[json!({}), json!({})]);
    let expected = ["mesh0-target-0", "mesh0-target-1", "mesh1-target-0", "mesh1-target-1"];
    assert_eq!(names(&file.read().unwrap()), expected);
    assert_eq!(lifts(&file), [[1.0, 0.0], [2.0, 0.0], [0.0, 1.0], [0.0, 2.0]]);
    let one = triangles(&[json!({}), json!({ "targetNames": ["a", "target-0"] })]);
    assert_eq!(names(&one.read().unwrap()), ["target-0", "target-1", "a", "target-0-3"]);
}

#[test]
fn names_stand_at_meshes_primitives_or_accessors() {
    let mut file = triangles(&[json!({ "targetNames": [null, ""] })]);
    file.json["meshes"][0]["primitives"][0]["extras"] = json!({ "targetNames": ["at the primitive"] });
    file.json["accessors"][2]["name"] = "at the accessor".into();
    assert_eq!(names(&file.read().unwrap()), ["at the primitive", "at the accessor"]);
    let file = triangles(&[json!({ "targetNames": ["twice", "twice"] })]);
    assert_eq!(names(&file.read().unwrap()), ["twice", "twice-1"]);
}

#[test]
fn a_morph_target_may_be_the_rest() {
    let file = triangles(&[json!({ "targetNames": ["a", "b"] })]);
    let rest = Selection { rest: RestShape::Pose("b".into()), ..Selection::default() };
    let sequence = file.select(&rest).unwrap();
    assert_eq!(sequence.rest.positions[0].z, 2.0);
    assert_eq!(positions(&sequence).iter().map(|pose| pose[0].z).collect::<Vec<_>>(), [1.0, 2.0]);
    let none = Selection { poses: PoseChoice::Nothing, ..rest };
    assert!(file.select(&none).unwrap().poses.is_empty());
}

#[test]
fn weights_of_nodes_and_meshes_are_not_the_rest() {
    let mut file = triangles(&[json!({}), json!({}), json!({})]);
    file.json["nodes"][0]["weights"] = json!([0, 1]);
    file.json["meshes"][1]["weights"] = json!([1, 0]);
    // The node's own weights count.
    file.json["meshes"][2]["weights"] = json!([1, 0]);
    file.json["nodes"][2]["weights"] = json!([0, 0]);
    let sequence = file.read().unwrap();
    assert!(sequence.rest.positions.iter().all(|p| p.z == 0.0));
    let expected = "the rest pose has all morph targets at 0, unlike the file's default: `mesh0`, `mesh1`";
    assert_eq!(sequence.warnings, [expected]);
}

#[test]
fn targets_that_do_not_fit_are_named() {
    let mut file = triangles(&[json!({})]);
    file.json["accessors"][1]["count"] = 2.into();
    let error = file.read().unwrap_err().to_string();
    assert_eq!(error, "a.gltf: mesh `mesh0`, primitive 0: morph target 0 has 2 vertices, the mesh 3");
}
