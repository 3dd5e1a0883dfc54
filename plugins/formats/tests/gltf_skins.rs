//! glTF: skinned meshes lie where their joints place them; known answers.

mod support;

use nalgebra::{Matrix4, Point3, Rotation3, Vector3};
use serde_json::json;
use support::{
    distance,
    gltf::{STRIP, about_z, bent, positions, strip, translation},
};

/// Rounding of a dozen operations on numbers of size 10.
const ROUNDING: f64 = 1e-14;

fn stored() -> Vec<Point3<f64>> {
    STRIP.into_iter().map(Point3::from).collect()
}

#[test]
fn joints_place_the_mesh_and_its_node_does_not() {
    let mut file = strip();
    assert_eq!(file.read().unwrap().rest.positions, stored());
    // What stands above the skeleton moves it, at the exporter's scale.
    file.json["nodes"][1]["scale"] = json!([100, 100, 100]);
    file.json["nodes"][1]["translation"] = json!([0, 0, 7]);
    let expected: Vec<_> = stored().iter().map(|p| Point3::new(100.0 * p.x, 100.0 * p.y, 100.0 * p.z + 7.0)).collect();
    assert!(distance(&file.read().unwrap().rest.positions, &expected) < 100.0 * ROUNDING);
    let sequence = file.read().unwrap();
    assert_eq!(sequence.warnings, Vec::<String>::new());
}

#[test]
fn the_rest_is_as_the_nodes_are_stored() {
    let mut file = strip();
    file.json["nodes"][3]["rotation"] = json!(about_z(30.0));
    assert!(distance(&file.read().unwrap().rest.positions, &bent(30.0)) < ROUNDING);
}

#[test]
fn without_inverse_bind_matrices_they_are_the_identity() {
    let mut file = strip();
    file.json["skins"][0].as_object_mut().unwrap().remove("inverseBindMatrices");
    // The upper joint now carries what it moves one further up.
    let share = [0.0, 0.0, 0.5, 0.5, 1.0, 1.0];
    let expected: Vec<_> = stored().iter().zip(share).map(|(p, share)| p + Vector3::y() * share).collect();
    assert!(distance(&file.read().unwrap().rest.positions, &expected) < ROUNDING);
}

#[test]
fn weights_of_all_kinds_and_sets_are_divided_by_their_sum() {
    let whole = |steps: f64| {
        [[1.0, 0.0], [1.0, 0.0], [0.5, 0.5], [0.5, 0.5], [0.0, 1.0], [0.0, 1.0]].map(|w: [f64; 2]| w.map(|w| w * steps))
    };
    let mut file = strip();
    file.json["nodes"][3]["rotation"] = json!(about_z(60.0));
    // 254 of 255 in all: even halves, and a sum that is not 1.
    let small: Vec<[u8; 4]> = whole(254.0).iter().map(|w| [w[0] as u8, w[1] as u8, 0, 0]).collect();
    let weights = file.bytes4(&small);
    file.json["accessors"][weights]["normalized"] = true.into();
    let attributes = &mut file.json["meshes"][0]["primitives"][0]["attributes"];
    attributes["WEIGHTS_0"] = weights.into();
    assert!(distance(&file.read().unwrap().rest.positions, &bent(60.0)) < ROUNDING);

    let large: Vec<u8> =
        whole(60000.0).iter().flat_map(|w| [w[0], w[1], 0.0, 0.0]).flat_map(|w| (w as u16).to_le_bytes()).collect();
    let weights = file.accessor("VEC4", 5123, 6, &large);
    file.json["accessors"][weights]["normalized"] = true.into();
    let joints: Vec<u8> = [0_u16, 1, 0, 0].repeat(6).iter().flat_map(|joint| joint.to_le_bytes()).collect();
    let joints = file.accessor("VEC4", 5123, 6, &joints);
    let attributes = &mut file.json["meshes"][0]["primitives"][0]["attributes"];
    (attributes["WEIGHTS_0"], attributes["JOINTS_0"]) = (weights.into(), joints.into());
    assert!(distance(&file.read().unwrap().rest.positions, &bent(60.0)) < ROUNDING);

    // The upper joint's share in a second set of influences, the lower one's split over four.
    let first: Vec<[f64; 4]> = whole(2.0).iter().map(|w| [w[0] / 4.0; 4]).collect();
    let second: Vec<[f64; 4]> = whole(2.0).iter().map(|w| [0.0, 0.0, w[1], 0.0]).collect();
    let (first, second) = (file.floats(&first), file.floats(&second));
    let (lower, upper) = (file.bytes4(&[[0; 4]; 6]), file.bytes4(&[[0, 0, 1, 0]; 6]));
    let attributes = &mut file.json["meshes"][0]["primitives"][0]["attributes"];
    (attributes["WEIGHTS_0"], attributes["JOINTS_0"]) = (first.into(), lower.into());
    (attributes["WEIGHTS_1"], attributes["JOINTS_1"]) = (second.into(), upper.into());
    assert!(distance(&file.read().unwrap().rest.positions, &bent(60.0)) < ROUNDING);
}

#[test]
fn a_vertex_without_weights_follows_its_first_joint() {
    let mut file = strip();
    file.json["nodes"][3]["rotation"] = json!(about_z(90.0));
    let (joints, weights) = (file.bytes4(&[[1, 0, 0, 0]; 6]), file.floats(&[[0.0; 4]; 6]));
    let attributes = &mut file.json["meshes"][0]["primitives"][0]["attributes"];
    (attributes["WEIGHTS_0"], attributes["JOINTS_0"]) = (weights.into(), joints.into());
    let expected: Vec<_> = stored().iter().map(|p| Point3::new(1.0 - p.y, 1.0 + p.x, 0.0)).collect();
    assert!(distance(&file.read().unwrap().rest.positions, &expected) < ROUNDING);
}

#[test]
fn inverse_bind_matrices_may_hold_the_scale_of_quantised_positions() {
    let mut file = strip();
    file.json["nodes"][3]["rotation"] = json!(about_z(45.0));
    // 2 units are 60,000 steps, from −1; powers of two keep f32 matrices exact.
    let bytes: Vec<u8> = STRIP
        .iter()
        .flat_map(|[x, y, z]| [x + 1.0, y + 1.0, z + 1.0, 0.0])
        .flat_map(|x| ((x * 8192.0) as u16).to_le_bytes())
        .collect();
    let position = file.accessor("VEC3", 5123, 6, &bytes);
    let view = file.json["accessors"][position]["bufferView"].as_u64().unwrap() as usize;
    file.json["bufferViews"][view]["byteStride"] = 8.into();
    file.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = position.into();
    let dequantised = |y: f64| {
        let s = 1.0 / 8192.0;
        [s, 0., 0., 0., 0., s, 0., 0., 0., 0., s, 0., -1.0, -1.0 + y, -1.0, 1.0]
    };
    let inverse = file.floats(&[dequantised(0.0), dequantised(-1.0)]);
    file.json["skins"][0]["inverseBindMatrices"] = inverse.into();
    file.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    assert!(distance(&file.read().unwrap().rest.positions, &bent(45.0)) < ROUNDING);
}

#[test]
fn a_joint_under_uneven_scale_is_sheared() {
    let mut file = strip();
    file.json["nodes"][2]["scale"] = json!([1, 3, 1]);
    file.json["nodes"][3]["rotation"] = json!(about_z(30.0));
    let scale = Matrix4::new_nonuniform_scaling(&Vector3::new(1.0, 3.0, 1.0));
    let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), 30_f64.to_radians()).to_homogeneous();
    let [up, down] = [1.0, -1.0].map(|y| Matrix4::new_translation(&Vector3::new(0.0, y, 0.0)));
    let upper = scale * up * turn * down;
    let share = [0.0, 0.0, 0.5, 0.5, 1.0, 1.0];
    let expected: Vec<_> = stored()
        .iter()
        .zip(share)
        .map(|(p, share)| scale.transform_point(p).lerp(&upper.transform_point(p), share))
        .collect();
    assert!(distance(&file.read().unwrap().rest.positions, &expected) < ROUNDING);
}

#[test]
fn morph_targets_move_the_mesh_before_its_joints() {
    let mut file = strip();
    file.json["nodes"][3]["rotation"] = json!(about_z(90.0));
    let mut moves = [[0.0; 3]; 6];
    moves[4] = [0.0, 0.0, 2.0];
    moves[5] = [0.0, 1.0, 0.0];
    let target = file.floats(&moves);
    file.json["meshes"][0]["primitives"][0]["targets"] = json!([{ "POSITION": target }]);
    let mut expected = bent(90.0);
    expected[4].z += 2.0;
    // Up is to the left under the turned joint.
    expected[5].x -= 1.0;
    assert!(distance(&positions(&file.read().unwrap())[0], &expected) < ROUNDING);
}

#[test]
fn a_primitive_without_joints_follows_its_node() {
    let mut file = strip();
    let attributes = file.json["meshes"][0]["primitives"][0]["attributes"].as_object_mut().unwrap();
    attributes.remove("JOINTS_0");
    let expected: Vec<_> = stored().iter().map(|p| p + Vector3::repeat(9.0)).collect();
    assert_eq!(file.read().unwrap().rest.positions, expected);
}

#[test]
fn normals_follow_the_joints() {
    let mut file = strip();
    file.json["nodes"][3]["rotation"] = json!([0.5_f64.sqrt(), 0.0, 0.0, 0.5_f64.sqrt()]);
    let normals = file.floats(&[[0.0, 0.0, 1.0]; 6]);
    file.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = normals.into();
    let normals = file.read().unwrap().rest.normals.unwrap();
    assert_eq!(normals.values[0], [0.0, 0.0, 1.0]);
    // The upper joint turns z to −y.
    assert!((Vector3::from(normals.values[5]) + Vector3::y()).norm() < ROUNDING);
}

#[test]
fn a_mirrored_skeleton_turns_no_triangle_inside_out() {
    let mut file = strip();
    file.json["nodes"][1]["scale"] = json!([-1, 1, 1]);
    let mesh = file.read().unwrap().rest;
    let surface = mimesh_core::mesh::Surface::new(&mesh).unwrap();
    assert!(surface.area_normals(&surface.positions).iter().all(|normal| normal.z > 0.0));
}

#[test]
fn what_is_wrong_with_a_skin_is_named() {
    let error = |edit: &dyn Fn(&mut support::gltf::File)| {
        let mut file = strip();
        edit(&mut file);
        file.read().unwrap_err().to_string()
    };
    let joints = error(&|file| {
        let joints = file.bytes4(&[[0, 2, 0, 0]; 6]);
        file.json["meshes"][0]["primitives"][0]["attributes"]["JOINTS_0"] = joints.into();
    });
    let place = "a.gltf: mesh `skinned`, primitive 0";
    assert_eq!(joints, format!("{place}: vertex 2 (from 0) follows joint 2: the skin has 2 (from 0)"));
    let weights = error(&|file| {
        let weights = file.floats(&[[f64::NAN; 4]; 6]);
        file.json["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_0"] = weights.into();
    });
    assert_eq!(weights, format!("{place}: vertex 0 (from 0) has weights that are not finite"));
    let few = error(&|file| {
        let inverse = file.floats(&[translation(0.0, 0.0, 0.0)]);
        file.json["skins"][0]["inverseBindMatrices"] = inverse.into();
    });
    assert_eq!(few, format!("{place}: skin 0: 1 inverse bind matrices for 2 joints"));
    let missing = error(&|file| file.json["skins"][0]["joints"] = json!([2, 9]));
    assert_eq!(missing, format!("{place}: skin 0: node 9 does not exist: there are 4 (from 0)"));
    let infinite = error(&|file| {
        let mut matrix = translation(0.0, 0.0, 0.0);
        matrix[5] = f64::NAN;
        let inverse = file.floats(&[translation(0.0, 0.0, 0.0), matrix]);
        file.json["skins"][0]["inverseBindMatrices"] = inverse.into();
    });
    assert_eq!(infinite, format!("{place}: skin 0: the inverse bind matrix of node `upper` is not finite"));
}
