//! The live result of shapes is what a run writes of them: masked, strengthened, and with some left out.

mod common;
mod socket;

use std::fs;

use common::{Client, sample, serve, weights};
use mimesh_studio::Start;
use serde_json::{Value, json};
use socket::{Socket, connect, say, wait};

const VERTICES: usize = 642;

/// The target's vertices in a frame, relative to the origin of the target.
fn positions(bytes: &[u8]) -> Vec<[f32; 3]> {
    let length = u32::from_le_bytes([bytes[4], bytes[5], bytes[6], bytes[7]]) as usize;
    let numbers = bytes[8 + length..].chunks(4).map(|word| f32::from_le_bytes([word[0], word[1], word[2], word[3]]));
    numbers.take(3 * VERTICES).collect::<Vec<_>>().as_chunks::<3>().0.to_vec()
}

/// The vertices of an OBJ.
fn vertices(text: &str) -> Vec<[f32; 3]> {
    let numbers = |line: &str| line.split_whitespace().map(|word| word.parse().unwrap()).collect::<Vec<f32>>();
    text.lines().filter_map(|line| line.strip_prefix("v ")).map(|line| numbers(line).try_into().unwrap()).collect()
}

fn farthest(a: &[[f32; 3]], b: &[[f32; 3]]) -> f32 {
    a.as_flattened().iter().zip(b.as_flattened()).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

/// A project whose second shape alone is taken, by half, where `x` is above 0.
fn opened(folder: &std::path::Path) -> Client {
    let pipeline = sample(folder);
    let text = fs::read_to_string(&pipeline)
        .unwrap()
        .replace("poses: [a-1.obj, a-2.obj]", "poses: [a-1.obj, a-2.obj], poses_are: shapes");
    let shapes = "shapes: { except: '*1', strength: 0.5, masks: { '*': { file: half.target.mask.json } } }\n";
    fs::write(&pipeline, format!("{text}{shapes}markers: p.markers.yaml\n")).unwrap();
    let pairs = [0, 3, 5, 7, 9, 11].map(|v| format!("- {{ source: {v}, target: {v} }}\n"));
    fs::write(folder.join("p.markers.yaml"), format!("markers:\n{}", pairs.concat())).unwrap();
    let rest = vertices(&fs::read_to_string(folder.join("b.obj")).unwrap());
    let weights: Vec<f32> = rest.iter().map(|p| f32::from(u8::from(p[0] > 0.0))).collect();
    fs::write(folder.join("half.target.mask.json"), json!({ "weights": weights }).to_string()).unwrap();
    let client = serve(folder, Some(Start::Pipeline(pipeline)));
    client.wait("/api/pipeline", |pipeline| pipeline["checking"] == false && pipeline["diagnostics"] == json!([]));
    client
}

async fn look(socket: &mut Socket, look: u64, pose: Value) -> Vec<[f32; 3]> {
    say(socket, json!({ "type": "look", "look": look, "pose": pose, "channels": ["result"] })).await;
    let is_frame =
        |message: &Value| message["look"] == look && message["channel"] == "result" && !message["arrays"].is_null();
    positions(&wait(socket, is_frame).await.1)
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn what_is_shown_of_a_shape_is_what_a_run_writes() {
    let folder = tempfile::tempdir().unwrap();
    let client = opened(folder.path());
    let mut socket = connect(&client).await;
    let whole = look(&mut socket, 1, json!({ "index": 1 })).await;
    let blended = look(&mut socket, 2, json!({ "blend": [[1, 0.6]] })).await;
    let runner = client.clone();
    let run = tokio::task::spawn_blocking(move || {
        let job = runner.post("/api/run", json!({})).json();
        runner.wait(&format!("/api/jobs/{}", job["id"]), |job| job["state"] != "running")
    });
    assert_eq!(run.await.unwrap()["state"], "done");
    let files: Vec<_> = fs::read_dir(folder.path().join("out")).unwrap().map(|entry| entry.unwrap().path()).collect();
    let written: Vec<_> = files.iter().filter(|file| file.extension().is_some_and(|end| end == "obj")).collect();
    assert_eq!(written.len(), 1, "{files:?}");
    let (rest, written) = (
        vertices(&fs::read_to_string(folder.path().join("b.obj")).unwrap()),
        vertices(&fs::read_to_string(written[0]).unwrap()),
    );
    // Frames are relative to the middle of the target, which lies at the origin, and have 32 bits.
    assert!(farthest(&whole, &written) < 1e-5, "{}", farthest(&whole, &written));
    // Whoever has the file blends it in the same way.
    let mix = |k: f32| -> Vec<[f32; 3]> {
        rest.iter().zip(&written).map(|(a, b)| [0, 1, 2].map(|c| a[c] + k * (b[c] - a[c]))).collect()
    };
    assert!(farthest(&blended, &mix(0.6)) < 1e-5, "{}", farthest(&blended, &mix(0.6)));
    // The other half rests, and this one does not.
    let moved = |p: &[[f32; 3]], is_inside: bool| {
        let some = rest.iter().zip(p).filter(|(at, _)| (at[0] > 0.0) == is_inside);
        some.map(|(a, b)| farthest(&[*a], &[*b])).fold(0.0, f32::max)
    };
    assert!(
        moved(&whole, false) < 1e-6 && moved(&whole, true) > 0.05,
        "{} {}",
        moved(&whole, false),
        moved(&whole, true)
    );
    // A mask that is painted again shows at once.
    let mask = client.clone();
    let all = tokio::task::spawn_blocking(move || {
        mask.send_bytes("PUT", "/api/masks/target/half?replace=true", &weights(&[1.0; VERTICES]))
    });
    let answer = all.await.unwrap();
    assert_eq!(answer.status, 200, "{}", String::from_utf8_lossy(&answer.body));
    let is_frame = |message: &Value| message["channel"] == "result" && !message["arrays"].is_null();
    // Frames from before may be unread; that of the new mask comes, or this waits in vain.
    while moved(&positions(&wait(&mut socket, is_frame).await.1), false) < 0.02 {}
}
