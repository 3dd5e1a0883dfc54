//! Real files with morph targets added: the JSON differs where it must, and the targets move vertices to their poses.

use mimesh_core::testkit::data::data;

use super::{
    build::{twisted, write},
    difference::differences,
    evaluate::{load, parts, shapes},
};
use crate::Glb;

/// The GLB at `path` of the test data with a twisted pose and one in which one vertex moves.
fn with_two_targets(path: &str) -> Option<(Vec<u8>, Vec<u8>)> {
    let before = std::fs::read(data(path)?).unwrap();
    let mesh = load(&before);
    let mut one = mesh.positions.clone();
    one[5].y += 0.25 * mesh.diagonal();
    let poses = [("twist", None, twisted(&mesh)), ("one", None, one)];
    let (after, warnings) = write(&Glb::default(), &mesh, &poses);
    assert_eq!(warnings, [""; 0]);
    // Vertices end up where they should.
    let (mut start, mut checked) = (0, Vec::new());
    for (shape, old) in shapes(&after).iter().zip(shapes(&before)) {
        assert_eq!((shape.node, shape.mesh, shape.primitive), (old.node, old.mesh, old.primitive));
        if checked.contains(&(shape.node, shape.position)) {
            continue;
        }
        checked.push((shape.node, shape.position));
        let end = start + shape.stored.len();
        assert!(shape.at(&[]) == old.at(&[]), "rest stays");
        for (pose, (_, _, positions)) in poses.iter().enumerate() {
            let found = shape.with(old.targets.len() + pose);
            for (vertex, (found, wanted)) in found.iter().zip(&positions[start..end]).enumerate() {
                // A displacement of about a diagonal is rounded to f32 in the stored space; the way back may stretch it
                // by the condition of the transform.
                let linear = shape.transforms[vertex].fixed_view::<3, 3>(0, 0).into_owned();
                let condition = linear.norm() * linear.try_inverse().unwrap().norm();
                let bound = 2e-7 * condition * mesh.diagonal();
                assert!((found - wanted).norm() <= bound, "{path} {pose} {vertex}: {found} {wanted}");
            }
        }
        start = end;
    }
    assert_eq!(start, mesh.positions.len());
    Some((before, after))
}

/// The differences of the JSON, and a check that the old bytes are the start of the new ones.
fn changes(before: &[u8], after: &[u8]) -> Vec<String> {
    let ((old, old_bytes), (new, new_bytes)) = (parts(before), parts(after));
    let length = old["buffers"][0]["byteLength"].as_u64().unwrap() as usize;
    assert!(new_bytes.starts_with(&old_bytes[..length]));
    differences(&old, &new)
}

#[test]
fn a_skinned_and_textured_fox_gets_its_targets_and_nothing_else() {
    let Some((before, after)) = with_two_targets("khronos-gltf/Fox.glb") else { return };
    let expected = [
        "/accessors: +2",
        "/bufferViews: +3",
        "/buffers/0/byteLength: changed",
        "/meshes/0/primitives/0/targets: new",
        "/meshes/0/extras: new",
    ];
    assert_eq!(changes(&before, &after), expected);
}

#[test]
fn a_robot_gets_targets_on_each_mesh_and_longer_weights_in_its_clips() {
    let Some((before, after)) = with_two_targets("robot/RobotExpressive.glb") else { return };
    let mut expected: Vec<String> =
        ["/accessors: +67", "/bufferViews: +56", "/buffers/0/byteLength: changed"].map(str::to_owned).to_vec();
    let json = parts(&before).0;
    for (index, mesh) in json["meshes"].as_array().unwrap().iter().enumerate() {
        // The head has three targets of its own.
        let (targets, names) =
            if index == 2 { ("targets: +2", "extras/targetNames: +2") } else { ("targets: new", "extras: new") };
        expected.push(format!("/meshes/{index}/{names}"));
        let primitives = 0..mesh["primitives"].as_array().unwrap().len();
        expected.extend(primitives.map(|primitive| format!("/meshes/{index}/primitives/{primitive}/{targets}")));
    }
    expected.push("/meshes/2/weights: +2".into());
    expected.extend((0..14).map(|clip| format!("/animations/{clip}/samplers/0/output: changed")));
    expected.sort();
    let mut found = changes(&before, &after);
    found.sort();
    assert_eq!(found, expected);
}

#[test]
fn an_avatar_keeps_skin_image_extension_and_its_own_target() {
    let Some((before, after)) = with_two_targets("reports/g_avatar.glb") else { return };
    // Positions and normals of two poses; those of the second are sparse.
    let expected = [
        "/buffers/0/byteLength: changed",
        "/bufferViews: +6",
        "/accessors: +4",
        "/meshes/0/primitives/0/targets: +2",
        "/meshes/0/extras/targetNames: +2",
    ];
    assert_eq!(changes(&before, &after), expected);
    let json = parts(&after).0;
    assert_eq!(json["meshes"][0]["extras"]["targetNames"], serde_json::json!(["existing", "twist", "one"]));
}

#[test]
fn a_vrm_keeps_its_targets() {
    let Some((before, after)) = with_two_targets("reports/g_ok.vrm") else { return };
    let expected = [
        "/buffers/0/byteLength: changed",
        "/bufferViews: +3",
        "/accessors: +2",
        "/meshes/0/primitives/0/targets: +2",
        "/meshes/0/extras/targetNames: +2",
    ];
    assert_eq!(changes(&before, &after), expected);
}
