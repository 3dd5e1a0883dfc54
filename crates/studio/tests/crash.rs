//! A server that is killed at any moment: what it had accepted is on the disk, whole.

mod common;

use std::{
    collections::BTreeSet,
    io::{BufRead, BufReader},
    path::Path,
    process::{Child, Command, Stdio},
    time::Duration,
};

use common::{Client, options, sample};
use mimesh_studio::{Server, Start};
use serde_json::json;

/// Tells the second process of this test which pipeline it serves.
const SERVED: &str = "MIMESH_TEST_SERVED";

/// The server in a process of its own; alone it does nothing.
#[test]
fn served() {
    let Ok(pipeline) = std::env::var(SERVED) else { return };
    let pipeline = Path::new(&pipeline);
    let folder = pipeline.parent().expect("a folder");
    let server = Server::new(options(folder, Some(Start::Pipeline(pipeline.into())))).expect("a server");
    println!("\nURL {}", server.url());
    server.run().expect("it serves");
}

struct Process(Child);

impl Drop for Process {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn start(pipeline: &Path) -> (Process, Client) {
    let mut child = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "served", "--nocapture"])
        .env(SERVED, pipeline)
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let lines = BufReader::new(child.stdout.take().unwrap()).lines();
    let url = lines.map_while(Result::ok).find_map(|line| line.strip_prefix("URL ").map(str::to_owned)).expect("a URL");
    (Process(child), Client::enter(&url))
}

#[test]
fn no_click_is_lost_whenever_the_server_is_killed() {
    let folder = tempfile::tempdir().unwrap();
    let pipeline = sample(folder.path());
    let mut accepted: BTreeSet<String> = BTreeSet::new();
    let mut number = 0;
    for round in 0..50u64 {
        let (mut process, client) = start(&pipeline);
        let found = names(&client);
        assert!(
            accepted.is_subset(&found),
            "round {round}: {:?} are lost",
            accepted.difference(&found).collect::<Vec<_>>()
        );
        // What was sent and not answered may be there or not.
        accepted = found;
        let project = client.project();
        let killer = std::thread::spawn(move || {
            std::thread::sleep(Duration::from_millis(5 + 7 * (round % 13)));
            let _ = process.0.kill();
            let _ = process.0.wait();
        });
        for _ in 0..200 {
            number += 1;
            let name = format!("click {number}");
            let vertex = number % 162;
            let ops =
                json!([{ "op": "add", "name": name, "source": { "vertex": vertex }, "target": { "vertex": vertex } }]);
            let base = 1;
            let edit = json!({ "project": project, "base": base, "id": name, "client": "test", "ops": ops });
            match try_post(&client, &edit.to_string()) {
                Some(status) => {
                    assert_eq!(status, 200);
                    accepted.insert(name);
                }
                None => break,
            }
        }
        killer.join().unwrap();
        let text = std::fs::read_to_string(folder.path().join("p.markers.yaml")).unwrap_or_default();
        let whole = text.is_empty() || text.ends_with("}\n") || text.ends_with("[]\n");
        assert!(whole, "round {round}: the file is not whole");
    }
    assert!(accepted.len() > 50, "only {} clicks were accepted", accepted.len());
    let left: Vec<_> = std::fs::read_dir(folder.path())
        .unwrap()
        .flatten()
        .filter(|entry| entry.file_name().to_string_lossy().ends_with(".part"))
        .collect();
    assert!(left.len() <= 50, "{left:?}");
    // And the pipeline names the file.
    assert!(std::fs::read_to_string(&pipeline).unwrap().contains("markers: p.markers.yaml"));
}

fn names(client: &Client) -> BTreeSet<String> {
    let markers = client.markers();
    let pairs = markers["pairs"].as_array().expect("pairs");
    pairs
        .iter()
        .filter(|pair| pair["status"] == "confirmed")
        .filter_map(|pair| Some(pair["name"].as_str()?.to_owned()))
        .collect()
}

/// The status of the answer; `None` if the server is gone.
fn try_post(client: &Client, body: &str) -> Option<u16> {
    use std::io::Write;
    let mut stream = std::net::TcpStream::connect(client.address).ok()?;
    stream.set_read_timeout(Some(Duration::from_secs(10))).ok()?;
    let head = client.head(
        "POST",
        "/api/markers",
        &format!("Content-Type: application/json\r\nContent-Length: {}\r\n", body.len()),
    );
    stream.write_all(head.as_bytes()).ok()?;
    stream.write_all(body.as_bytes()).ok()?;
    let answer = common::read_answer(&mut stream);
    Some(answer.status).filter(|status| *status != 0)
}
