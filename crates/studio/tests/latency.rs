//! How long a drag takes until the frame of the moved target is there. Not a test of a law: run it by hand, with two meshes in
//! `MIMESH_LATENCY=SOURCE,TARGET`, as `cargo test --release -p mimesh-studio --test latency -- --ignored --nocapture`.

mod common;

use std::{path::PathBuf, time::Instant};

use common::{Client, serve};
use futures_util::{SinkExt, StreamExt};
use mimesh_studio::Start;
use serde_json::{Value, json};
use tokio_tungstenite::{
    client_async,
    tungstenite::{Message, client::IntoClientRequest},
};

/// Drags that are timed.
const DRAGS: u64 = 60;

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[ignore = "needs two meshes, and measures times"]
async fn drag_to_frame() {
    let Ok(files) = std::env::var("MIMESH_LATENCY") else { return };
    let (source, target) = files.split_once(',').expect("two files");
    let folder = tempfile::tempdir().unwrap();
    let copy = |file: &str| {
        let to = folder.path().join(PathBuf::from(file).file_name().unwrap());
        std::fs::copy(file, &to).unwrap();
        to
    };
    let (source, target) = (copy(source), copy(target));
    let started = Instant::now();
    let client = serve(folder.path(), Some(Start::Pair(source, target)));
    println!("open: {:.0} ms", 1e3 * started.elapsed().as_secs_f64());
    let began = Instant::now();
    client.get("/api/mesh/source");
    let bytes = client.get("/api/mesh/target").body.len();
    println!("both meshes: {:.0} ms, target {:.1} MB", 1e3 * began.elapsed().as_secs_f64(), bytes as f64 / 1e6);
    let vertices = client.session()["target"]["vertices"].as_u64().unwrap();
    let markers = client.wait("/api/markers", |markers| !markers["pairs"].as_array().unwrap().is_empty());
    println!(
        "proposed: {} pairs after {:.1} s",
        markers["pairs"].as_array().unwrap().len(),
        started.elapsed().as_secs_f64()
    );
    let mut socket = connect(&client).await;
    let look = json!({ "type": "look", "look": 1, "pose": null, "channels": ["preview"] });
    let began = Instant::now();
    socket.send(Message::text(look.to_string())).await.unwrap();
    wait(&mut socket, None).await;
    println!("first preview: {:.0} ms", 1e3 * began.elapsed().as_secs_f64());
    let mut times: Vec<f64> = Vec::new();
    let mut of_server: Vec<f64> = Vec::new();
    for drag in 1..=DRAGS {
        let point = json!({ "vertex": (drag * 37) % vertices });
        let message = json!({ "type": "drag", "drag": drag, "pair": 1, "side": "target", "point": point });
        let began = Instant::now();
        socket.send(Message::text(message.to_string())).await.unwrap();
        let header = wait(&mut socket, Some(drag)).await;
        times.push(1e3 * began.elapsed().as_secs_f64());
        of_server.push(header["milliseconds"].as_f64().unwrap());
    }
    for (name, times) in [("drag to frame", &mut times), ("of that the server", &mut of_server)] {
        times.sort_by(f64::total_cmp);
        let at = |share: f64| times[((times.len() - 1) as f64 * share) as usize];
        println!("{name}: median {:.0} ms, p95 {:.0} ms", at(0.5), at(0.95));
    }
}

type Socket = tokio_tungstenite::WebSocketStream<tokio::net::TcpStream>;

async fn connect(client: &Client) -> Socket {
    let mut request = format!("ws://{}/api/live", client.address).into_client_request().unwrap();
    let headers = request.headers_mut();
    headers.insert("Origin", format!("http://{}", client.address).parse().unwrap());
    headers.insert("Cookie", client.cookie.parse().unwrap());
    let stream = tokio::net::TcpStream::connect(client.address).await.unwrap();
    client_async(request, stream).await.unwrap().0
}

/// The header of the next preview of this drag.
async fn wait(socket: &mut Socket, drag: Option<u64>) -> Value {
    loop {
        match socket.next().await.expect("an open socket").unwrap() {
            Message::Binary(bytes) => {
                let length = u32::from_le_bytes([bytes[4], bytes[5], bytes[6], bytes[7]]) as usize;
                let header: Value = serde_json::from_slice(&bytes[8..8 + length]).unwrap();
                if header["channel"] == "preview" && header["drag"] == json!(drag) {
                    return header;
                }
            }
            Message::Text(text) if text.contains("\"failed\"") || text.contains("\"unavailable\"") => panic!("{text}"),
            _ => {}
        }
    }
}
