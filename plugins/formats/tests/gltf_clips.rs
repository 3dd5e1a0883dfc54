//! glTF: clips as poses; known answers at and between keys, names and times.

mod support;

use mimesh_core::{
    mesh::ClipTime,
    stage::{ClipTimes, RestShape, Selection},
};
use nalgebra::{Point3, Vector3};
use serde_json::json;
use support::{
    distance,
    gltf::{File, about_z, bent, clips, names, positions, strip},
    message,
};

/// Rounding of f32 in keys, of numbers up to 2.
const F32: f64 = 4.0 * f32::EPSILON as f64;

/// The strip with a clip that turns its upper joint by 90° from 0.5 to 1.5 s.
fn turning(interpolation: &str) -> File {
    let mut file = strip();
    let (from, to) = (about_z(0.0), about_z(90.0));
    let output = match interpolation {
        "CUBICSPLINE" => file.floats(&[[0.0; 4], from, [0.0; 4], [0.0; 4], to, [0.0; 4]]),
        _ => file.floats(&[from, to]),
    };
    file.clip("Turn", 3, "rotation", interpolation, &[0.5, 1.5], output);
    file
}

/// The positions at `seconds` of a clip.
fn at(file: &File, clip: &str, seconds: f64) -> Vec<Point3<f64>> {
    let rest = RestShape::Clip { name: clip.into(), seconds };
    file.select(&Selection { rest, ..Selection::default() }).unwrap().rest.positions
}

#[test]
fn keys_are_met_and_hold_before_the_first_and_after_the_last() {
    for interpolation in ["LINEAR", "STEP", "CUBICSPLINE"] {
        let file = turning(interpolation);
        let keys = file.at_keys("Turn");
        assert!(distance(&keys[0], &bent(0.0)) < F32 && distance(&keys[1], &bent(90.0)) < F32, "{interpolation}");
        assert!(distance(&at(&file, "Turn", 0.0), &bent(0.0)) < F32, "{interpolation}");
        assert!(distance(&at(&file, "Turn", 9.0), &bent(90.0)) < F32, "{interpolation}");
    }
}

#[test]
fn between_keys_the_interpolation_counts() {
    // An even turn; no turn until the key; 3 s² − 2 s³ of the quaternion, normalised.
    assert!(distance(&at(&turning("LINEAR"), "Turn", 0.75), &bent(22.5)) < F32);
    assert!(distance(&at(&turning("STEP"), "Turn", 1.25), &bent(0.0)) < F32);
    let share = 3.0 * 0.25_f64.powi(2) - 2.0 * 0.25_f64.powi(3);
    let ([_, _, z, w], [_, _, _, one]) = (about_z(90.0), about_z(0.0));
    let (z, w) = (share * z, (1.0 - share) * one + share * w);
    let degrees = 2.0 * z.atan2(w).to_degrees();
    assert!(distance(&at(&turning("CUBICSPLINE"), "Turn", 0.75), &bent(degrees)) < F32);
}

#[test]
fn poses_have_names_times_and_the_rate_asked_for() {
    let file = turning("LINEAR");
    let sequence = file.select(&clips(&["Turn"], ClipTimes::PerSecond(4.0), None)).unwrap();
    assert_eq!(names(&sequence), ["Turn-00", "Turn-01", "Turn-02", "Turn-03", "Turn-04"]);
    let times: Vec<_> = sequence.poses.iter().map(|pose| pose.time.clone().unwrap()).collect();
    let seconds = [0.5, 0.75, 1.0, 1.25, 1.5];
    assert_eq!(times, seconds.map(|seconds| ClipTime { clip: "Turn".into(), seconds }));
    for (positions, degrees) in positions(&sequence).iter().zip([0.0, 22.5, 45.0, 67.5, 90.0]) {
        assert!(distance(positions, &bent(degrees)) < F32);
    }
    // The rest stays as the file stores it, and the clip is listed.
    assert_eq!(sequence.rest.positions, strip().read().unwrap().rest.positions);
    let clip = &file.read().unwrap().animations[0];
    assert_eq!((&clip.name[..], clip.seconds, &clip.channels[..]), ("Turn", 1.5, &["skeleton".to_owned()][..]));
}

#[test]
fn a_range_starts_the_raster_and_one_time_has_the_name_of_its_clip() {
    let file = turning("LINEAR");
    let times = |rate, range| {
        let sequence = file.select(&clips(&["Turn"], rate, Some(range))).unwrap();
        sequence.poses.iter().map(|pose| pose.time.as_ref().unwrap().seconds).collect::<Vec<_>>()
    };
    assert_eq!(times(ClipTimes::PerSecond(2.0), [0.75, 1.5]), [0.75, 1.25]);
    assert_eq!(times(ClipTimes::PerSecond(2.0), [1.0, 99.0]), [1.0, 1.5]);
    assert_eq!(times(ClipTimes::Keys, [1.0, 2.0]), [1.5]);
    let one = file.select(&clips(&["Turn"], ClipTimes::Keys, Some([1.0, 2.0]))).unwrap();
    assert_eq!(names(&one), ["Turn"]);
}

#[test]
fn all_clips_come_in_order_under_names_of_their_own() {
    let mut file = turning("LINEAR");
    let output = file.floats(&[[1.0, 0.0, 0.0], [2.0, 0.0, 0.0]]);
    file.clip("Turn", 1, "translation", "STEP", &[0.0, 1.0], output);
    file.clip("", 1, "scale", "LINEAR", &[0.0], output);
    let output = file.floats(&[[1.0, 1.0, 1.0]]);
    file.clip("elsewhere", 0, "scale", "LINEAR", &[0.0], output);
    let sequence = file.select(&clips(&[], ClipTimes::Keys, None)).unwrap();
    assert_eq!(names(&sequence), ["Turn-00", "Turn-01", "Turn-1-00", "Turn-1-01", "2"]);
    // The skeleton's parent moves all of it; the node of a skinned mesh nothing.
    let moved: Vec<_> = strip().read().unwrap().rest.positions.iter().map(|p| p + Vector3::x()).collect();
    assert!(distance(&positions(&sequence)[2], &moved) < F32);
    assert_eq!(sequence.warnings, ["clips that do not move the mesh: `elsewhere`"]);
    let listed: Vec<_> = sequence.animations.iter().map(|clip| &clip.name[..]).collect();
    assert_eq!(listed, ["Turn", "Turn-1", "2", "elsewhere"]);
}

#[test]
fn weights_of_morph_targets_are_clips_too() {
    let mut file = File::new();
    let position = file.floats(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    let up = file.floats(&[[0.0, 0.0, 1.0], [0.0; 3], [0.0; 3]]);
    let out = file.floats(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0; 3]]);
    file.push(
        "meshes",
        json!({
            "weights": [0.5, 0],
            "primitives": [{ "attributes": { "POSITION": position }, "targets": [{ "POSITION": up }, { "POSITION": out }] }],
        }),
    );
    file.push("nodes", json!({ "mesh": 0, "name": "face" }));
    let output = file.floats(&[[0.0], [0.0], [1.0], [0.5]]);
    file.clip("talk", 0, "weights", "LINEAR", &[0.0, 1.0], output);
    let output = file.floats(&[[0.0, 0.0, 4.0]]);
    file.clip("walk", 0, "translation", "LINEAR", &[0.0], output);
    let p = |x, y, z| Point3::new(x, y, z);
    assert_eq!(at(&file, "talk", 0.5), [p(0.0, 0.0, 0.5), p(1.25, 0.0, 0.0), p(0.0, 1.0, 0.0)]);
    // A clip without weights has those that the file stores; the rest has none, which is told.
    assert_eq!(at(&file, "walk", 0.0), [p(0.0, 0.0, 4.5), p(1.0, 0.0, 4.0), p(0.0, 1.0, 4.0)]);
    let sequence = file.read().unwrap();
    assert_eq!(sequence.rest.positions[0], p(0.0, 0.0, 0.0));
    assert_eq!(sequence.warnings, ["the rest pose has all morph targets at 0, unlike the file's default: `face`"]);
}

#[test]
fn a_channel_moves_a_node_that_is_stored_as_a_matrix() {
    let mut file = turning("LINEAR");
    file.json["nodes"][3] = json!({ "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 1, 0, 1] });
    assert!(distance(&at(&file, "Turn", 1.0), &bent(45.0)) < F32);
}

#[test]
fn what_a_file_does_not_have_is_named_with_what_it_has() {
    let mut file = turning("LINEAR");
    let error = |file: &File, selection: &Selection| message(&file.select(selection).unwrap_err());
    let hint = "`mimesh inspect` lists the morph targets and clips of a file";
    let run = clips(&["Run"], ClipTimes::Keys, None);
    assert_eq!(error(&file, &run), format!("a.gltf: no clip is called `Run`: the file has `Turn`\n{hint}"));
    let pose = Selection { rest: RestShape::Pose("smile".into()), ..Selection::default() };
    assert_eq!(error(&file, &pose), format!("a.gltf: no morph target is called `smile`: the file has none\n{hint}"));
    let late = clips(&["Turn"], ClipTimes::Keys, Some([2.0, 3.0]));
    assert_eq!(error(&file, &late), format!("a.gltf: the clip `Turn` ends at 1.5 s, before 2 s\n{hint}"));
    let still = clips(&["Turn"], ClipTimes::PerSecond(0.0), None);
    assert_eq!(error(&file, &still), format!("a.gltf: 0 poses a second: expected a number above 0\n{hint}"));
    let many = clips(&["Turn"], ClipTimes::PerSecond(1e9), None);
    assert_eq!(
        error(&file, &many),
        format!("a.gltf: 1000000000 poses a second of the clip `Turn` are more than 1000000\n{hint}")
    );
    file.json["animations"] = json!([]);
    let all = clips(&[], ClipTimes::Keys, None);
    assert_eq!(error(&file, &all), format!("a.gltf: the file has no clip\n{hint}"));
}

#[test]
fn channels_that_cannot_be_read_are_told_once_and_left_out() {
    let mut file = turning("LINEAR");
    file.json["animations"][0]["channels"] = json!([
        { "sampler": 0, "target": { "node": 3, "path": "rotation" } },
        { "sampler": 7, "target": { "node": 3, "path": "scale" } },
        { "sampler": 0, "target": { "node": 3, "path": "translation" } },
        { "sampler": 0, "target": { "path": "pointer", "extensions": { "KHR_animation_pointer": {} } } },
    ]);
    let sequence = file.read().unwrap();
    assert_eq!(
        sequence.warnings,
        [
            "animation channels that move no node were left out: `Turn`",
            "2 channels of the clip `Turn` were left out, the first since sampler 7 does not exist: there are 1 (from 0)",
        ]
    );
    assert!(distance(&file.at_keys("Turn")[1], &bent(90.0)) < F32);
}

#[test]
fn one_thread_or_many_give_the_same_poses() {
    let file = turning("CUBICSPLINE");
    let sequence = file.select(&clips(&[], ClipTimes::PerSecond(24.0), None)).unwrap();
    let alone = positions(&sequence);
    std::thread::scope(|scope| {
        let threads: Vec<_> = (0..4).map(|_| scope.spawn(|| positions(&sequence))).collect();
        threads.into_iter().for_each(|thread| assert_eq!(thread.join().unwrap(), alone));
    });
}
