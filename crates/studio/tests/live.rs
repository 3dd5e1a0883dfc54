//! The socket: frames of the pose that is looked at, events, and messages that make no sense.

mod common;
mod socket;

use std::time::Duration;

use common::{Client, sample, serve};
use futures_util::{SinkExt, StreamExt};
use mimesh_studio::Start;
use serde_json::{Value, json};
use socket::{connect, say, wait};
use tokio_tungstenite::tungstenite::Message;

/// The vertices of a frame, which come last.
fn positions(bytes: &[u8], vertices: usize) -> Vec<f32> {
    let length = u32::from_le_bytes([bytes[4], bytes[5], bytes[6], bytes[7]]) as usize;
    let start = 8 + length;
    bytes[start..start + 12 * vertices]
        .chunks(4)
        .map(|word| f32::from_le_bytes([word[0], word[1], word[2], word[3]]))
        .collect()
}

/// A project with markers in a file: where there are none they are proposed unasked, which would be an edit among those of the test.
fn opened(folder: &std::path::Path) -> Client {
    let pipeline = sample(folder);
    let text = std::fs::read_to_string(&pipeline).unwrap();
    std::fs::write(&pipeline, format!("{text}markers: p.markers.yaml\n")).unwrap();
    let pairs = [0, 3, 5, 7, 9, 11].map(|v| format!("- {{ source: {v}, target: {v} }}\n"));
    std::fs::write(folder.join("p.markers.yaml"), format!("markers:\n{}", pairs.concat())).unwrap();
    let client = serve(folder, Some(Start::Pipeline(pipeline)));
    client.wait("/api/pipeline", |pipeline| pipeline["checking"] == false && pipeline["diagnostics"] == json!([]));
    client
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_look_is_answered_with_frames_and_edits_with_new_ones() {
    let folder = tempfile::tempdir().unwrap();
    let client = opened(folder.path());
    let mut socket = connect(&client).await;
    let (hello, _) = wait(&mut socket, |message| message["type"] == "hello").await;
    assert_eq!(hello["markers"], client.markers()["revision"]);
    let all = ["source", "preview", "result", "truth"];
    say(
        &mut socket,
        json!({ "type": "look", "look": 1, "pose": { "index": 0 }, "channels": all, "scalar": "edge_stretch" }),
    )
    .await;
    let (source, bytes) = wait(&mut socket, |message| message["channel"] == "source" && message["look"] == 1).await;
    assert_eq!(source["pose"], json!({ "index": 0 }));
    assert_eq!(positions(&bytes, 162).len(), 3 * 162);
    let (preview, bytes) =
        wait(&mut socket, |message| message["channel"] == "preview" && !message["arrays"].is_null()).await;
    let before = positions(&bytes, 642);
    assert!(before.iter().all(|x| x.is_finite()) && preview["drag"].is_null());
    let (result, bytes) =
        wait(&mut socket, |message| message["channel"] == "result" && !message["arrays"].is_null()).await;
    assert_eq!(result["scalar"]["name"], "edge_stretch", "{result:#}");
    assert_eq!(result["arrays"][1]["length"], 642);
    assert!(positions(&bytes, 642).iter().all(|x| x.is_finite()));
    // A drag changes the preview, and no document.
    let drag = json!({ "type": "drag", "drag": 4, "pair": 1, "side": "target", "point": { "vertex": 100 } });
    say(&mut socket, drag).await;
    let (dragged, bytes) = wait(&mut socket, |message| message["channel"] == "preview" && message["drag"] == 4).await;
    assert_eq!(dragged["revision"], client.markers()["revision"]);
    assert_ne!(positions(&bytes, 642), before);
    // A move of the pair ends it, and is told.
    let moved = client.clone();
    let edited = tokio::task::spawn_blocking(move || {
        moved.edit("m", json!([{ "op": "move", "pair": 1, "side": "target", "point": { "vertex": 100 } }])).json()
    });
    let revision = edited.await.unwrap()["markers"]["revision"].clone();
    wait(&mut socket, |message| message["type"] == "markers" && message["markers"]["revision"] == revision).await;
    wait(&mut socket, |message| {
        message["channel"] == "result" && message["revision"] == revision && !message["arrays"].is_null()
    })
    .await;
    let (after, _) = wait(&mut socket, |message| {
        message["channel"] == "preview" && message["revision"] == revision && message["drag"].is_null()
    })
    .await;
    assert!(after["milliseconds"].is_number() || after["state"] == "ready", "{after}");
    // What cannot be had is told at once.
    wait(&mut socket, |message| message["channel"] == "truth" && message["state"] == "unavailable").await;
    // How sure the pairs are: those of a file are confirmed.
    let colours =
        json!({ "type": "look", "look": 9, "pose": null, "channels": ["preview"], "scalar": "pair_confidence" });
    say(&mut socket, colours).await;
    let (sure, bytes) = wait(&mut socket, |message| message["look"] == 9 && !message["arrays"].is_null()).await;
    assert_eq!((&sure["scalar"]["unit"], &sure["scalar"]["high"]), (&json!("%"), &json!(100.0)));
    assert!(positions(&bytes, 642 + 214)[3 * 642..].iter().all(|share| *share == 100.0));
    // At rest the target rests.
    say(&mut socket, json!({ "type": "look", "look": 10, "pose": null, "channels": ["preview"] })).await;
    let (_, bytes) = wait(&mut socket, |message| message["look"] == 10 && !message["arrays"].is_null()).await;
    let mesh = {
        let rest = client.clone();
        tokio::task::spawn_blocking(move || rest.get("/api/mesh/target").body).await.unwrap()
    };
    let rest = positions(&mesh, 642);
    let off = positions(&bytes, 642).iter().zip(&rest).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(off < 1e-3, "{off}");
    // Half of a shape moves the source half as far.
    say(&mut socket, json!({ "type": "look", "look": 11, "pose": { "blend": [[0, 0.5]] }, "channels": ["source"] }))
        .await;
    let (_, bytes) = wait(&mut socket, |message| message["look"] == 11 && !message["arrays"].is_null()).await;
    assert_eq!(positions(&bytes, 162).len(), 486);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn messages_that_make_no_sense_are_answered() {
    let folder = tempfile::tempdir().unwrap();
    let client = opened(folder.path());
    let mut socket = connect(&client).await;
    let messages = [
        "",
        "{",
        "null",
        "[]",
        "{}",
        r#"{"type":"explode"}"#,
        r#"{"type":"look","look":-1,"pose":null,"channels":[]}"#,
        r#"{"type":"look","look":1,"pose":{"index":"x"},"channels":[]}"#,
        r#"{"type":"drag","drag":1,"pair":1,"side":"up","point":null}"#,
    ];
    for message in messages {
        socket.stream.send(Message::text(message)).await.unwrap();
        let (error, _) = wait(&mut socket, |answer| answer["type"] == "error").await;
        assert_eq!(error["error"]["code"], "bad_request", "{message}");
    }
    socket.stream.send(Message::binary(vec![0u8; 100])).await.unwrap();
    wait(&mut socket, |answer| answer["type"] == "error").await;
    say(&mut socket, json!({ "type": "look", "look": 1, "pose": { "index": 99 }, "channels": ["source"] })).await;
    wait(&mut socket, |answer| {
        answer["type"] == "error" && answer["error"]["message"].as_str().unwrap().contains("99")
    })
    .await;
    say(&mut socket, json!({ "type": "look", "look": 2, "pose": null, "channels": ["source"] })).await;
    wait(&mut socket, |answer| answer["look"] == 2).await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn floods_and_large_messages_close_the_socket_alone() {
    let folder = tempfile::tempdir().unwrap();
    let client = opened(folder.path());
    let mut socket = connect(&client).await;
    let flood = async {
        loop {
            if socket
                .stream
                .send(Message::text(r#"{"type":"drag","drag":1,"pair":1,"side":"source","point":null}"#))
                .await
                .is_err()
            {
                return None;
            }
            if let Ok(Some(Ok(Message::Close(frame)))) =
                tokio::time::timeout(Duration::from_micros(10), socket.stream.next()).await
            {
                return frame.map(|frame| u16::from(frame.code));
            }
        }
    };
    let code = tokio::time::timeout(Duration::from_secs(20), flood).await.expect("it is closed");
    assert!(code.is_none_or(|code| code == 1008), "{code:?}");
    let mut socket = connect(&client).await;
    let _ = socket.stream.send(Message::text("x".repeat(100_000))).await;
    let closed = async {
        while let Some(Ok(message)) = socket.stream.next().await {
            if message.is_close() {
                break;
            }
        }
    };
    tokio::time::timeout(Duration::from_secs(10), closed).await.expect("it is closed");
    let status = tokio::task::spawn_blocking(move || client.get("/api/session").status).await.unwrap();
    assert_eq!(status, 200);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn results_of_all_frames_are_computed_ahead_and_played() {
    let folder = tempfile::tempdir().unwrap();
    let client = opened(folder.path());
    let mut socket = connect(&client).await;
    let look = |look: u64, index: u64, channels: Value| json!({ "type": "look", "look": look, "pose": { "index": index }, "channels": channels, "scalar": "edge_stretch", "ahead": true });
    say(&mut socket, look(1, 0, json!(["source", "preview"]))).await;
    let is_whole = |message: &Value| message["type"] == "ahead" && message["done"] == message["count"];
    let (ahead, _) = wait(&mut socket, is_whole).await;
    assert_eq!((&ahead["count"], &ahead["step"], &ahead["scalar"]), (&json!(2), &json!(1), &json!("edge_stretch")));
    assert_eq!(ahead["revision"], client.markers()["revision"]);
    // A frame that is there is the answer at once, with its colours, and no preview comes beside it.
    say(&mut socket, look(2, 1, json!(["source", "result"]))).await;
    let (played, bytes) = wait(&mut socket, |message| message["channel"] == "result" && message["look"] == 2).await;
    assert_eq!((&played["pose"], &played["arrays"][1]["length"]), (&json!({ "index": 1 }), &json!(642)));
    assert!(played["milliseconds"].as_f64().unwrap() < 50.0, "{played}");
    let first = positions(&bytes, 642);
    // It is what a stopped frame shows.
    say(&mut socket, look(3, 0, json!(["result"]))).await;
    say(&mut socket, look(4, 1, json!(["result"]))).await;
    wait(&mut socket, |message| message["type"] == "worst").await;
    let (stopped, bytes) = wait(&mut socket, |message| message["channel"] == "result" && message["look"] == 4).await;
    assert_eq!(stopped["pose"], json!({ "index": 1 }));
    let differ = positions(&bytes, 642).iter().zip(&first).map(|(a, b)| (a - b).abs()).fold(0.0f32, f32::max);
    assert!(differ < 1e-6, "{differ}");
    // Other points make it all anew.
    let moved = client.clone();
    let edited = tokio::task::spawn_blocking(move || {
        moved.edit("m", json!([{ "op": "move", "pair": 1, "side": "target", "point": { "vertex": 100 } }])).json()
    });
    let revision = edited.await.unwrap()["markers"]["revision"].clone();
    let (ahead, _) = wait(&mut socket, |message| is_whole(message) && message["revision"] == revision).await;
    assert_eq!(ahead["error"], Value::Null);
}
