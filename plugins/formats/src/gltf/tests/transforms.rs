//! Targets under any affine placement, and normals that turn with the surface.

use nalgebra::{Matrix3, Matrix4, Point3, Vector3};
use proptest::prelude::*;
use serde_json::json;

use super::{
    build::{Builder, write},
    evaluate::{Shape, load, shapes},
};
use crate::Glb;

/// A square under a node with `matrix`.
fn placed(matrix: &Matrix4<f64>) -> Vec<u8> {
    let matrix: Vec<f64> = matrix.iter().map(|&x| f64::from(x as f32)).collect();
    // A skin of one joint, so that shear is kept: the joint stands at the origin and the inverse bind matrix has it all.
    let mut file = Builder::new(json!({
        "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0, 1] }],
        "nodes": [{ "mesh": 0, "skin": 0 }, {}],
    }));
    let mut primitive = file.square(1.0);
    let joints = file.binary.like(&json!({ "componentType": 5121, "type": "VEC4" }), &[0; 16], 4).unwrap();
    let weights = file.binary.attribute(&[[1.0_f32, 0.0, 0.0, 0.0]; 4], false).unwrap();
    primitive["attributes"]["JOINTS_0"] = joints.into();
    primitive["attributes"]["WEIGHTS_0"] = weights.into();
    file.json["meshes"] = json!([{ "primitives": [primitive] }]);
    let bytes: Vec<u8> = matrix.iter().flat_map(|&x| (x as f32).to_le_bytes()).collect();
    let inverse = file.binary.like(&json!({ "componentType": 5126, "type": "MAT4" }), &bytes, 1).unwrap();
    file.json["skins"] = json!([{ "joints": [1], "inverseBindMatrices": inverse }]);
    file.glb()
}

fn linear(shape: &Shape) -> Matrix3<f64> {
    shape.transforms[0].fixed_view::<3, 3>(0, 0).into()
}

fn condition(linear: &Matrix3<f64>) -> f64 {
    linear.try_inverse().map_or(f64::INFINITY, |inverse| linear.norm() * inverse.norm())
}

proptest! {
    #[test]
    fn targets_move_vertices_to_their_poses(
        numbers in prop::array::uniform12(-2.0_f64..2.0),
        moves in prop::collection::vec(prop::array::uniform3(-1.0_f64..1.0), 4),
    ) {
        let mut matrix = Matrix4::identity();
        matrix.fixed_view_mut::<3, 4>(0, 0).copy_from_slice(&numbers);
        let glb = placed(&matrix);
        let mesh = load(&glb);
        let mut posed: Vec<_> = mesh.positions.iter().zip(&moves).map(|(p, d)| p + Vector3::from(*d)).collect();
        posed[1] = mesh.positions[1];
        let (after, warnings) = write(&Glb::default(), &mesh, &[("pose", None, posed.clone())]);
        let shape = &shapes(&after)[0];
        let condition = condition(&linear(shape));
        prop_assert!(shape.targets[0].iter().flatten().all(|x| x.is_finite()));
        if condition > 9e5 {
            return Ok(());
        }
        prop_assert_eq!(warnings, [""; 0]);
        prop_assert_eq!(shape.targets[0][1], Vector3::zeros());
        for (found, wanted) in shape.with(0).iter().zip(&posed) {
            // A displacement of length d is stored as at most ‖A⁻¹‖ d, rounded to f32, and comes back times ‖A‖.
            let bound = f64::from(f32::EPSILON) * condition * 2.0 + 1e-12 * condition;
            prop_assert!((found - wanted).norm() <= bound, "{} {}", found, wanted);
        }
    }

    #[test]
    fn normals_turn_with_the_surface(
        numbers in prop::array::uniform9(-2.0_f64..2.0),
        angles in prop::array::uniform3(-3.0_f64..3.0),
    ) {
        let mut matrix = Matrix4::identity();
        matrix.fixed_view_mut::<3, 3>(0, 0).copy_from_slice(&numbers);
        let glb = placed(&matrix);
        let mesh = load(&glb);
        let turn = nalgebra::Rotation3::from_euler_angles(angles[0], angles[1], angles[2]);
        let posed: Vec<Point3<f64>> = mesh.positions.iter().map(|p| turn * p).collect();
        let before = &shapes(&glb)[0];
        let linear = linear(before);
        let condition = condition(&linear);
        prop_assume!(condition < 100.0);
        let (after, _) = write(&Glb::default(), &mesh, &[("pose", None, posed)]);
        let stored = normal_targets(&after);
        let back = linear.try_inverse().unwrap().transpose();
        let rest = (back * Vector3::z()).normalize();
        for change in stored {
            let normal = back * (Vector3::z() + change);
            // Unit length in the stored space, and turned by the turn of all; f32 and the condition of the way back.
            prop_assert!(((Vector3::z() + change).norm() - 1.0).abs() < 1e-6);
            prop_assert!((normal.normalize() - turn * rest).norm() < 1e-6 * condition);
        }
    }
}

/// The differences of normals of the first target of the first primitive.
fn normal_targets(glb: &[u8]) -> Vec<Vector3<f64>> {
    let file = gltf::Gltf::from_slice_without_validation(glb).unwrap();
    let blob = super::evaluate::parts(glb).1;
    let primitive = file.meshes().next().unwrap().primitives().next().unwrap();
    let reader = primitive.reader(|_| Some(&blob[..]));
    let normals = reader.read_morph_targets().next().unwrap().1;
    normals.unwrap().map(|n| Vector3::from(n).cast()).collect()
}

#[test]
fn normals_of_a_pose_are_left_out_where_they_are_not_wanted() {
    let glb = placed(&Matrix4::identity());
    let mesh = load(&glb);
    let posed: Vec<_> = mesh.positions.iter().map(|p| Point3::new(p.x, p.z, p.y)).collect();
    for pose_normals in [false, true] {
        let (after, _) = write(&Glb { pose_normals, ..Glb::default() }, &mesh, &[("pose", None, posed.clone())]);
        let json = super::evaluate::parts(&after).0;
        assert_eq!(json["meshes"][0]["primitives"][0]["targets"][0].get("NORMAL").is_some(), pose_normals);
    }
}
