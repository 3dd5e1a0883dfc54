//! Meshes that were not read from a glTF: where they are stored, and in what unit.

use mimesh_core::{
    mesh::Mesh,
    stage::{Format, Selection},
    testkit::data::{data, input},
};
use nalgebra::{Point3, Vector3};
use serde_json::json;

use super::{
    build::write,
    evaluate::{parts, shapes},
};
use crate::{Glb, LengthUnit, Obj, UpAxis};

/// The largest distance of the corners of `glb` with target `pose` (none: at rest) from `positions`, summed in f64.
fn largest_error(glb: &[u8], mesh: &Mesh, pose: Option<usize>, positions: &[Point3<f64>]) -> f64 {
    let json = parts(glb).0;
    let number = |value: &serde_json::Value| value.as_f64().unwrap();
    let fans = mesh
        .polygons
        .iter()
        .flat_map(|polygon| polygon[1..].windows(2).flat_map(|edge| [polygon[0], edge[0], edge[1]]));
    let mut wanted = fans.map(|vertex| positions[vertex as usize]);
    let mut largest: f64 = 0.0;
    for shape in shapes(glb) {
        // The `gltf` crate has translations in f32; here the JSON counts.
        let translation = &json["nodes"][shape.node]["translation"];
        let offset = Vector3::from(std::array::from_fn(|i| translation.get(i).map_or(0.0, number)));
        let moves = |corner: usize| pose.map_or_else(Vector3::zeros, |pose| shape.targets[pose][corner]);
        for &corner in &shape.corners {
            let found = shape.stored[corner as usize] + offset + moves(corner as usize);
            largest = largest.max((found - wanted.next().unwrap()).norm());
        }
    }
    assert_eq!(wanted.next(), None);
    largest
}

#[test]
fn a_mesh_far_from_the_origin_keeps_the_digits_of_its_own_size() {
    let Some(path) = data("reports/obj_huge.obj") else { return };
    let read = |path| Obj::default().read(&input(path), &Selection::default()).unwrap().rest;
    let mesh = read(path);
    let poses: Vec<_> = ["reports/obj_huge-00.obj", "reports/obj_huge-01.obj"]
        .iter()
        .filter_map(|pose| Some(("pose", None, read(data(pose)?).positions)))
        .collect();
    let (glb, _) = write(&Glb::default(), &mesh, &poses);
    // Stored coordinates are up to half a diagonal and steps of the offset from 0; two of them are rounded to f32.
    let bound = 2.0 * f64::from(f32::EPSILON) * mesh.diagonal();
    assert!(largest_error(&glb, &mesh, None, &mesh.positions) <= bound);
    for (index, (_, _, positions)) in poses.iter().enumerate() {
        assert!(largest_error(&glb, &mesh, Some(index), positions) <= bound);
    }
    assert!(poses.len() == 2 && mesh.positions[0].coords.amax() > 1e3 * mesh.diagonal());
}

#[test]
fn a_mesh_near_the_origin_has_no_translation() {
    let mesh = Mesh::from_triangles(
        vec![Point3::new(1., 0., 0.), Point3::new(2., 0., 0.), Point3::new(1., 1., 0.)],
        &[[0, 1, 2]],
    );
    let json = parts(&write(&Glb::default(), &mesh, &[]).0).0;
    assert_eq!(json["nodes"], json!([{ "name": "mesh", "mesh": 0 }]));
}

#[test]
fn unit_and_up_axis_are_put_in_the_node() {
    let p = Point3::new;
    // 1 ft by 2 ft by 3 ft, far away, Z up.
    let positions = vec![p(100., 0., 0.), p(101., 0., 0.), p(100., 2., 0.), p(100., 0., 3.)];
    let mesh = Mesh::from_triangles(positions, &[[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]);
    let mut posed = mesh.positions.clone();
    posed[3].z = 4.0;
    let glb = Glb { unit: LengthUnit::Foot, up: UpAxis::Z, ..Glb::default() };
    let (bytes, _) = write(&glb, &mesh, &[("tall", None, posed.clone())]);
    let shape = &shapes(&bytes)[0];
    for (found, wanted) in [(shape.at(&[]), &mesh.positions), (shape.with(0), &posed)] {
        for (corner, p) in shape.corners.iter().zip(mesh.polygons.corners()) {
            let p = wanted[*p as usize];
            let wanted = Point3::new(p.x, p.z, -p.y) * 0.3048;
            // Coordinates of 30 m in the f32 of the evaluation's node.
            assert!((found[*corner as usize] - wanted).norm() < 30.0 * f64::from(f32::EPSILON) * 2.0);
        }
    }
    let scales = [
        (LengthUnit::Metre, None),
        (LengthUnit::Centimetre, Some(0.01)),
        (LengthUnit::Millimetre, Some(0.001)),
        (LengthUnit::Inch, Some(0.0254)),
    ];
    for (unit, scale) in scales {
        let json = parts(&write(&Glb { unit, ..Glb::default() }, &mesh, &[]).0).0;
        assert_eq!(json["nodes"][0].get("scale"), scale.map(|s| json!([s, s, s])).as_ref());
    }
}
