//! A server in this process or in another one, and a client that sends exactly what a test wants.

#![allow(dead_code, reason = "each test uses a part of it")]

use std::{
    fmt::Write as _,
    fs,
    io::{Read, Write},
    net::{SocketAddr, TcpStream},
    path::{Path, PathBuf},
    time::{Duration, Instant},
};

use mimesh_core::{mesh::Surface, testkit::meshes};
use mimesh_pipeline::input::HelpCommands;
use mimesh_studio::{Server, Start, StudioOptions};
use serde_json::{Value, json};
use {
    mimesh_clusterers as _, mimesh_correspondences as _, mimesh_deformers as _, mimesh_formats as _,
    mimesh_generators as _, mimesh_landmarks as _, mimesh_metrics as _, mimesh_proximity as _, mimesh_samplers as _,
    mimesh_transfers as _, mimesh_weights as _,
};

/// A page that knows a server.
#[derive(Clone, Debug)]
pub struct Client {
    pub address: SocketAddr,
    pub token: String,
    pub cookie: String,
}

/// An answer.
#[derive(Clone, Debug)]
pub struct Answer {
    pub status: u16,
    pub head: String,
    pub body: Vec<u8>,
}

impl Answer {
    pub fn json(&self) -> Value {
        serde_json::from_slice(&self.body)
            .unwrap_or_else(|_| panic!("no JSON: {}", String::from_utf8_lossy(&self.body)))
    }

    pub fn header(&self, name: &str) -> Option<&str> {
        let lines = self.head.lines().filter_map(|line| line.split_once(": "));
        lines.filter(|(key, _)| key.eq_ignore_ascii_case(name)).map(|(_, value)| value).next()
    }
}

/// A surface as the text of an OBJ, each vertex moved by `change`.
pub fn obj(surface: &Surface, change: impl Fn([f64; 3]) -> [f64; 3]) -> String {
    let mut text = String::new();
    for p in &surface.positions {
        let [x, y, z] = change([p.x, p.y, p.z]);
        let _ = writeln!(text, "v {x} {y} {z}");
    }
    for [a, b, c] in &surface.triangles {
        let _ = writeln!(text, "f {} {} {}", a + 1, b + 1, c + 1);
    }
    text
}

/// A folder with a source in two poses, a target, and a pipeline `p.yaml` of them.
pub fn sample(folder: &Path) -> PathBuf {
    let (source, target) = (meshes::icosphere(2), meshes::icosphere(3));
    let write = |name: &str, text: String| fs::write(folder.join(name), text).unwrap();
    write("a.obj", obj(&source, |p| p));
    write("a-1.obj", obj(&source, |[x, y, z]| [x + 0.3 * y * y, y, z]));
    write("a-2.obj", obj(&source, |[x, y, z]| [x, 1.2 * y, z]));
    write("b.obj", obj(&target, |[x, y, z]| [1.5 * x, y, z]));
    let text = "# a comment\nsource: { rest: a.obj, poses: [a-1.obj, a-2.obj] }\ntarget: { rest: b.obj }\ncorrespondence: { type: nonrigid_fit }\n\
        transfer: { type: gradient }\nmetrics: [{ type: edge_stretch }]\noutput: [out/b-{pose}.obj]\n";
    write("p.yaml", text.into());
    folder.join("p.yaml")
}

/// What a server of a test begins with.
pub fn options(folder: &Path, start: Option<Start>) -> StudioOptions {
    StudioOptions {
        start,
        folder: folder.into(),
        roots: vec![],
        host: "127.0.0.1".into(),
        port: 0,
        allow_commands: false,
        cache: None,
        help: |_| HelpCommands::default(),
    }
}

/// Starts a server in this process, and shows the token.
pub fn serve(folder: &Path, start: Option<Start>) -> Client {
    let server = Server::new(options(folder, start)).unwrap_or_else(|failure| panic!("{failure}"));
    let url = server.url();
    std::thread::spawn(move || server.run());
    Client::enter(&url)
}

/// What a page sends to save `weights` of vertices.
pub fn weights(weights: &[f32]) -> Vec<u8> {
    let mut bytes = b"MSB1".to_vec();
    let mut head = json!({ "arrays": [{ "name": "weights", "type": "f32", "length": weights.len() }] }).to_string();
    head.push_str(&" ".repeat(head.len().next_multiple_of(4) - head.len()));
    bytes.extend((head.len() as u32).to_le_bytes());
    bytes.extend(head.as_bytes());
    bytes.extend(weights.iter().flat_map(|weight| weight.to_le_bytes()));
    bytes
}

impl Client {
    /// Opens `url` as a browser does.
    pub fn enter(url: &str) -> Self {
        let rest = url.strip_prefix("http://").expect("a URL");
        let (address, token) = rest.split_once("/?token=").expect("a token");
        let mut client = Self { address: address.parse().unwrap(), token: token.into(), cookie: String::new() };
        let answer = client.raw(&format!("GET /?token={token} HTTP/1.1\r\nHost: {address}\r\n\r\n"), &[]);
        assert_eq!(answer.status, 303, "{answer:?}");
        let cookie = answer.header("set-cookie").expect("a cookie");
        assert!(cookie.contains("HttpOnly") && cookie.contains("SameSite=Strict"), "{cookie}");
        client.cookie = cookie.split(';').next().unwrap_or_default().into();
        client
    }

    /// Sends `head`, which ends with an empty line, and `body`.
    pub fn raw(&self, head: &str, body: &[u8]) -> Answer {
        let mut stream = TcpStream::connect(self.address).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
        stream.write_all(head.as_bytes()).unwrap();
        // A server that refuses may close before all is sent.
        let _ = stream.write_all(body);
        read_answer(&mut stream)
    }

    pub fn head(&self, method: &str, path: &str, more: &str) -> String {
        let (address, cookie) = (self.address, &self.cookie);
        format!(
            "{method} {path} HTTP/1.1\r\nHost: {address}\r\nOrigin: http://{address}\r\nCookie: {cookie}\r\n{more}\r\n"
        )
    }

    pub fn get(&self, path: &str) -> Answer {
        self.raw(&self.head("GET", path, ""), &[])
    }

    pub fn send(&self, method: &str, path: &str, body: &Value) -> Answer {
        let body = body.to_string();
        let more = format!("Content-Type: application/json\r\nContent-Length: {}\r\n", body.len());
        self.raw(&self.head(method, path, &more), body.as_bytes())
    }

    pub fn send_bytes(&self, method: &str, path: &str, body: &[u8]) -> Answer {
        self.raw(&self.head(method, path, &format!("Content-Length: {}\r\n", body.len())), body)
    }

    pub fn post(&self, path: &str, body: Value) -> Answer {
        self.send("POST", path, &body)
    }

    /// The session; with the markers and the pipeline it is all that a page begins with.
    pub fn session(&self) -> Value {
        self.get("/api/session").json()
    }

    pub fn project(&self) -> u64 {
        self.session()["project"].as_u64().expect("a project")
    }

    pub fn markers(&self) -> Value {
        self.get("/api/markers").json()
    }

    /// Does `ops` on the present revision.
    pub fn edit(&self, id: &str, ops: Value) -> Answer {
        let base = self.markers()["revision"].clone();
        self.post("/api/markers", json!({ "project": self.project(), "base": base, "id": id, "ops": ops }))
    }

    /// Waits until `path` answers with something for which `is_it` holds.
    pub fn wait(&self, path: &str, is_it: impl Fn(&Value) -> bool) -> Value {
        let began = Instant::now();
        loop {
            let value = self.get(path).json();
            if is_it(&value) {
                return value;
            }
            assert!(began.elapsed() < Duration::from_secs(60), "{path} stays {value:#}");
            std::thread::sleep(Duration::from_millis(20));
        }
    }
}

/// Reads one answer, whose length is known.
pub fn read_answer(stream: &mut TcpStream) -> Answer {
    let mut bytes = Vec::new();
    let mut part = [0; 65536];
    loop {
        if let Some(end) = bytes.windows(4).position(|four| four == b"\r\n\r\n") {
            let head = String::from_utf8_lossy(&bytes[..end]).into_owned();
            let length = head.lines().filter_map(|line| line.split_once(": "));
            let length =
                length.filter(|(key, _)| key.eq_ignore_ascii_case("content-length")).map(|(_, value)| value).next();
            let length: usize = length.and_then(|length| length.parse().ok()).unwrap_or(0);
            if bytes.len() >= end + 4 + length {
                let status = head.split(' ').nth(1).and_then(|status| status.parse().ok()).unwrap_or(0);
                return Answer { status, head, body: bytes[end + 4..end + 4 + length].to_vec() };
            }
        }
        match stream.read(&mut part) {
            Ok(0) | Err(_) => return Answer { status: 0, head: String::new(), body: bytes },
            Ok(count) => bytes.extend(&part[..count]),
        }
    }
}
