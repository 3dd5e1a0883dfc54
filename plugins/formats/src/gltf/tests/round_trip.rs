//! What the reader reads of a file that was read, given targets and written.

use std::collections::BTreeMap;

use mimesh_core::{
    mesh::{Mesh, MeshSequence, Pose},
    stage::{BytesInput, ClipChoice, ClipTimes, Format, PoseChoice, Selection},
    testkit::data::data,
};
use nalgebra::{Point3, Vector3};
use serde_json::json;

use super::{
    build::{Builder, twisted, write},
    evaluate::{load, parts, shapes},
};
use crate::Glb;

fn read(glb: &[u8], selection: &Selection) -> MeshSequence {
    Glb::default().read(&BytesInput::new("a.glb", glb), selection).unwrap()
}

/// The largest distance between positions in parts of the diagonal.
fn distance(mesh: &Mesh, found: &[Point3<f64>], wanted: &[Point3<f64>]) -> f64 {
    let largest = found.iter().zip(wanted).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
    largest / mesh.diagonal()
}

#[test]
fn poses_of_skinned_files_come_back_as_they_were_given() {
    for path in
        ["khronos-gltf/Fox.glb", "khronos-gltf/CesiumMan.glb", "robot/RobotExpressive.glb", "reports/g_avatar.glb"]
    {
        let Some(path) = data(path) else { continue };
        let before = std::fs::read(&path).unwrap();
        let mesh = load(&before);
        let posed = twisted(&mesh);
        let (after, _) = write(&Glb::default(), &mesh, &[("twist", None, posed.clone())]);
        let (old, new) = (read(&before, &Selection::default()), read(&after, &Selection::default()));
        assert!(old.rest.positions == new.rest.positions && old.rest.polygons == new.rest.polygons);
        assert_eq!(old.animations, new.animations);
        let names = |poses: &[Pose]| poses.iter().map(|pose| pose.name.clone()).collect::<Vec<_>>();
        // Poses come mesh by mesh, so that the new one may stand before others.
        let at = new.poses.iter().position(|pose| pose.name == "twist").unwrap();
        let mut others = new.poses.clone();
        let last = others.remove(at);
        assert_eq!(names(&others), names(&old.poses));
        assert!(old.poses.iter().zip(&others).all(|(old, new)| old.positions == new.positions));
        // Rounding to f32 in the stored space, times the condition of the joints' transforms, which is small here.
        let error = distance(&mesh, &last.positions.get().unwrap(), &posed);
        assert!(error < 1e-6, "{}: {error:e}", path.display());
        if old.animations.is_empty() {
            continue;
        }
        // Every clip moves as before.
        let clips = PoseChoice::Clips(ClipChoice { times: ClipTimes::PerSecond(3.0), ..ClipChoice::default() });
        let clips = Selection { poses: clips, ..Selection::default() };
        let (old, new) = (read(&before, &clips), read(&after, &clips));
        assert_eq!(names(&old.poses), names(&new.poses));
        assert!(old.poses.iter().zip(&new.poses).all(|(old, new)| old.positions == new.positions));
    }
}

#[test]
fn a_clip_of_a_file_comes_back_at_its_own_times() {
    let Some(path) = data("khronos-gltf/Fox.glb") else { return };
    let before = std::fs::read(path).unwrap();
    let clips = |clip: &str| {
        let choice =
            ClipChoice { clips: vec![clip.into()], times: ClipTimes::PerSecond(12.0), ..ClipChoice::default() };
        Selection { poses: PoseChoice::Clips(choice), keep_document: true, ..Selection::default() }
    };
    let run = read(&before, &clips("Run"));
    let poses: Vec<_> = run
        .poses
        .iter()
        .map(|pose| (&pose.name[..], pose.time.clone(), pose.positions.get().unwrap().into_owned()))
        .collect();
    let (after, warnings) = write(&Glb::default(), &run.rest, &poses);
    assert_eq!(warnings, [""; 0]);
    let back = read(&after, &clips("Run-poses"));
    assert_eq!(back.poses.len(), run.poses.len());
    for (back, pose) in back.poses.iter().zip(&run.poses) {
        assert_eq!(back.time.as_ref().unwrap().clip, "Run-poses");
        let (found, wanted) = (back.time.as_ref().unwrap().seconds, pose.time.as_ref().unwrap().seconds);
        assert!((found - wanted).abs() < 1e-9);
        // Times are f32 in the file, so that a little of the next frame may be blended in.
        assert!(distance(&run.rest, &back.positions.get().unwrap(), &pose.positions.get().unwrap()) < 1e-5);
    }
}

#[test]
fn a_file_with_buffers_and_images_beside_it_becomes_one_that_stands_alone() {
    let mut file = Builder::new(json!({
        "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0] }], "nodes": [{ "mesh": 0 }],
    }));
    let primitive = file.square(1.0);
    file.json["meshes"] = json!([{ "primitives": [primitive] }]);
    let (mut json, bytes) = parts(&file.glb());
    let png = b"\x89PNG\r\n\x1a\nrest".to_vec();
    json["images"] = json!([{ "uri": "skin%201.png" }, { "uri": "lost.png" }]);
    json["buffers"] = json!([
        { "uri": "data:application/octet-stream;base64,AQID", "byteLength": 3 },
        { "uri": "body.bin", "byteLength": bytes.len() },
    ]);
    json["bufferViews"].as_array_mut().unwrap().iter_mut().for_each(|view| view["buffer"] = 1.into());
    let mut input = BytesInput::new("a.gltf", json.to_string());
    input.others = BTreeMap::from([("body.bin".into(), bytes), ("skin 1.png".into(), png)]);
    let selection = Selection { keep_document: true, ..Selection::default() };
    let mesh = crate::Gltf::default().read(&input, &selection).unwrap().rest;
    let posed: Vec<_> = mesh.positions.iter().map(|p| p + Vector3::z()).collect();
    let (after, _) = write(&Glb::default(), &mesh, &[("up", None, posed.clone())]);
    let written = parts(&after).0;
    assert_eq!(written["buffers"].as_array().unwrap().len(), 1);
    assert_eq!(written["buffers"][0].get("uri"), None);
    assert_eq!((written["images"][0].get("uri"), &written["images"][0]["mimeType"]), (None, &json!("image/png")));
    // An image that was not found stays what it was.
    assert_eq!(written["images"][1], json!({ "uri": "lost.png" }));
    assert_eq!(read(&after, &Selection::default()).poses[0].positions.get().unwrap(), posed);
    assert_eq!(shapes(&after)[0].with(0), posed);
}
