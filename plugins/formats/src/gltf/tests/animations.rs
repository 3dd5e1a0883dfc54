//! Existing clips of weights, and new ones.

use mimesh_core::mesh::ClipTime;
use nalgebra::Vector3;
use serde_json::{Value, json};

use super::{
    build::{Builder, Written, write},
    evaluate::{load, parts},
};
use crate::{Glb, PoseAnimation};

/// Three nodes with two meshes of one target; a clip in which all are moved by one sampler, and a spline.
fn animated() -> Vec<u8> {
    let mut file = Builder::new(json!({
        "asset": { "version": "2.0" },
        "scene": 0,
        "scenes": [{ "nodes": [0, 1] }],
        "nodes": [{ "mesh": 0 }, { "mesh": 1 }, { "mesh": 2 }],
    }));
    let mut meshes = Vec::new();
    for targets in [1, 2, 1] {
        let mut primitive = file.square(1.0);
        let moves = file.binary.attribute(&[[0.0_f32, 0.0, 1.0]; 4], true).unwrap();
        primitive["targets"] = (0..targets).map(|_| json!({ "POSITION": moves })).collect::<Vec<_>>().into();
        meshes.push(json!({ "primitives": [primitive] }));
    }
    file.json["meshes"] = meshes.into();
    let input = file.binary.times(&[0.0, 1.0]).unwrap();
    let mut scalars = |values: &[f32]| {
        let bytes: Vec<u8> = values.iter().flat_map(|x| x.to_le_bytes()).collect();
        file.binary.like(&json!({ "componentType": 5126, "type": "SCALAR" }), &bytes, values.len()).unwrap()
    };
    let linear = scalars(&[0.25, 0.75]);
    let spline = scalars(&[1., 2., 3., 4., 5., 6., 7., 8., 9., 10., 11., 12.]);
    let bytes = file.binary.like(&json!({ "componentType": 5121, "normalized": true, "type": "SCALAR" }), &[1, 2], 2);
    let moves =
        |sampler: usize, node: usize| json!({ "sampler": sampler, "target": { "node": node, "path": "weights" } });
    file.json["animations"] = json!([
        {
            "name": "Run",
            "samplers": [
                { "input": input, "output": linear },
                { "input": input, "output": spline, "interpolation": "CUBICSPLINE" },
            ],
            "channels": [moves(0, 0), moves(0, 2), moves(1, 1)],
        },
        { "samplers": [{ "input": input, "output": bytes.unwrap(), "interpolation": "STEP" }], "channels": [moves(0, 0)] },
    ]);
    file.glb()
}

/// The bytes of an accessor that has a view of its own.
fn bytes(json: &Value, buffer: &[u8], accessor: &Value) -> Vec<u8> {
    let accessor = &json["accessors"][accessor.as_u64().unwrap() as usize];
    let view = &json["bufferViews"][accessor["bufferView"].as_u64().unwrap() as usize];
    let start = view["byteOffset"].as_u64().unwrap() as usize;
    buffer[start..start + view["byteLength"].as_u64().unwrap() as usize].to_vec()
}

fn floats(json: &Value, buffer: &[u8], accessor: &Value) -> Vec<f32> {
    bytes(json, buffer, accessor).as_chunks().0.iter().map(|&b| f32::from_le_bytes(b)).collect()
}

/// Poses that move everything up, with times.
fn poses(glb: &[u8], times: &[(&'static str, Option<(&str, f64)>)]) -> Vec<Written<'static>> {
    let mesh = load(glb);
    let posed: Vec<_> = mesh.positions.iter().map(|p| p + Vector3::z()).collect();
    let time = |(clip, seconds): (&str, f64)| ClipTime { clip: clip.into(), seconds };
    times.iter().map(|&(name, at)| (name, at.map(time), posed.clone())).collect()
}

#[test]
fn weights_of_existing_clips_get_zeros_for_new_targets() {
    let before = animated();
    let (after, _) = write(&Glb::default(), &load(&before), &poses(&before, &[("smile", None), ("frown", None)]));
    let (json, buffer) = parts(&after);
    let run = &json["animations"][0];
    // Node 2 is in no scene and was not read, so its mesh and its sampler stay.
    assert_eq!(run["channels"][1], parts(&before).0["animations"][0]["channels"][1]);
    assert_eq!(run["samplers"][0], parts(&before).0["animations"][0]["samplers"][0]);
    let output =
        |channel: usize| &run["samplers"][run["channels"][channel]["sampler"].as_u64().unwrap() as usize]["output"];
    assert_eq!(floats(&json, &buffer, output(0)), [0.25, 0.0, 0.0, 0.75, 0.0, 0.0]);
    // In-tangents, values and out-tangents of each key.
    let spline: Vec<f32> = (0..6).flat_map(|row| [2.0 * row as f32 + 1.0, 2.0 * row as f32 + 2.0, 0.0, 0.0]).collect();
    assert_eq!(floats(&json, &buffer, output(2)), spline);
    // The type of the numbers stays.
    let step = &json["animations"][1]["samplers"][0]["output"];
    assert_eq!(bytes(&json, &buffer, step), [1, 0, 0, 2, 0, 0]);
    assert_eq!(json["accessors"][step.as_u64().unwrap() as usize]["normalized"], true);
}

#[test]
fn sets_of_shapes_are_not_animated_unless_asked_for() {
    let before = animated();
    let (mesh, shapes) = (load(&before), poses(&before, &[("smile", None), ("frown", None)]));
    let animations = |animation| {
        let json = parts(&write(&Glb { animation, ..Glb::default() }, &mesh, &shapes).0).0;
        json["animations"].as_array().unwrap()[2..].to_vec()
    };
    assert_eq!(animations(PoseAnimation::Auto), [""; 0]);
    assert_eq!(animations(PoseAnimation::None), [""; 0]);
    assert_eq!(animations(PoseAnimation::Play).len(), 1);
    let without_times = Glb { animation: PoseAnimation::ClipTimes, ..Glb::default() };
    let (_, warnings) = write(&without_times, &mesh, &shapes);
    assert_eq!(warnings, ["2 of 2 poses have no time in a clip, and no animation shows them"]);
}

#[test]
fn frames_are_played_after_the_existing_targets() {
    let before = animated();
    let frames = poses(&before, &[("horse-01", None), ("horse-02", None)]);
    let (after, _) = write(&Glb::default(), &load(&before), &frames);
    let (json, buffer) = parts(&after);
    let played = &json["animations"][2];
    assert_eq!(played["name"], "poses");
    assert_eq!(floats(&json, &buffer, &played["samplers"][0]["input"]), [0.0, 1.0 / 24.0]);
    // The first mesh has one target before the new ones, the second two.
    assert_eq!(floats(&json, &buffer, &played["samplers"][0]["output"]), [0., 1., 0., 0., 0., 1.]);
    assert_eq!(floats(&json, &buffer, &played["samplers"][1]["output"]), [0., 0., 1., 0., 0., 0., 0., 1.]);
    let targets = played["channels"].as_array().unwrap().iter().map(|c| (&c["sampler"], &c["target"]["node"]));
    assert_eq!(targets.collect::<Vec<_>>(), [(&json!(0), &json!(0)), (&json!(1), &json!(1))]);
}

#[test]
fn frames_of_clips_keep_clips_and_times_under_names_of_their_own() {
    let before = animated();
    let times = [("a", Some(("Run", 0.5))), ("b", Some(("Walk", 0.0))), ("c", Some(("Run", 0.75)))];
    let (after, _) = write(&Glb::default(), &load(&before), &poses(&before, &times));
    let (json, buffer) = parts(&after);
    let names: Vec<_> = json["animations"].as_array().unwrap().iter().map(|a| a["name"].as_str()).collect();
    assert_eq!(names, [Some("Run"), None, Some("Run-poses"), Some("Walk")]);
    let run = &json["animations"][2];
    assert_eq!(floats(&json, &buffer, &run["samplers"][0]["input"]), [0.5, 0.75]);
    assert_eq!(floats(&json, &buffer, &run["samplers"][0]["output"]), [0., 1., 0., 0., 0., 0., 0., 1.]);
}
