//! What others may try: every attempt is refused, and the server goes on.

mod common;

use std::{
    io::{Read, Write},
    net::TcpStream,
    path::Path,
    time::{Duration, Instant},
};

use common::{Client, read_answer, sample, serve};
use mimesh_studio::Start;
use serde_json::json;

fn server(folder: &Path) -> Client {
    let pipeline = sample(folder);
    serve(folder, Some(Start::Pipeline(pipeline)))
}

#[test]
fn without_the_cookie_nothing_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let client = server(folder.path());
    let address = client.address;
    for path in ["/", "/api/session", "/api/files", "/api/mesh/source", "/api/live", "/assets/x.js"] {
        let answer = client.raw(&format!("GET {path} HTTP/1.1\r\nHost: {address}\r\n\r\n"), &[]);
        assert_eq!(answer.status, 401, "{path}");
        assert_eq!(answer.json()["error"]["code"], "unauthorized");
    }
    for cookie in
        [client.cookie.replace('a', "b").replace('1', "2"), format!("{}x", client.cookie), "mimesh-1=x".into()]
    {
        let head = format!("GET /api/session HTTP/1.1\r\nHost: {address}\r\nCookie: {cookie}\r\n\r\n");
        assert_eq!(client.raw(&head, &[]).status, 401, "{cookie}");
    }
    let wrong = client.raw(&format!("GET /?token={} HTTP/1.1\r\nHost: {address}\r\n\r\n", "0".repeat(64)), &[]);
    assert!(wrong.status == 403 && wrong.header("set-cookie").is_none());
    assert_eq!(client.get("/api/session").status, 200);
}

#[test]
fn foreign_hosts_and_origins_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let client = server(folder.path());
    let (address, cookie) = (client.address, &client.cookie);
    let port = address.port();
    for host in ["evil.example".to_owned(), format!("evil.example:{port}"), "127.0.0.1:1".into(), String::new()] {
        let head = format!("GET /api/session HTTP/1.1\r\nHost: {host}\r\nCookie: {cookie}\r\n\r\n");
        assert_eq!(client.raw(&head, &[]).status, 403, "{host}");
        // Not even with the token.
        let head = format!("GET /?token={} HTTP/1.1\r\nHost: {host}\r\n\r\n", client.token);
        assert_eq!(client.raw(&head, &[]).status, 403, "{host}");
    }
    let own = format!("http://{address}");
    let origins = [
        "http://evil.example",
        "null",
        "https://127.0.0.1",
        &format!("{own}.evil.example"),
        &own.replace("127.0.0.1", "localhost"),
    ];
    for origin in origins {
        for method in ["GET", "POST"] {
            let head = format!(
                "{method} /api/markers HTTP/1.1\r\nHost: {address}\r\nOrigin: {origin}\r\nCookie: {cookie}\r\n\
                 Content-Type: application/json\r\nContent-Length: 2\r\n\r\n"
            );
            assert_eq!(client.raw(&head, b"{}").status, 403, "{method} {origin}");
        }
    }
    // What changes something must say where it comes from, and so must a socket.
    let head = format!(
        "POST /api/run HTTP/1.1\r\nHost: {address}\r\nCookie: {cookie}\r\nContent-Type: application/json\r\nContent-Length: 2\r\n\r\n"
    );
    assert_eq!(client.raw(&head, b"{}").status, 403);
    for origin in ["", "Origin: http://evil.example\r\n"] {
        let head = format!(
            "GET /api/live HTTP/1.1\r\nHost: {address}\r\n{origin}Cookie: {cookie}\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n\
             Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n"
        );
        assert_eq!(client.raw(&head, &[]).status, 403, "{origin}");
    }
    let local = format!("GET /api/session HTTP/1.1\r\nHost: localhost:{port}\r\nCookie: {cookie}\r\n\r\n");
    assert_eq!(client.raw(&local, &[]).status, 200);
}

#[test]
fn every_answer_binds_the_browser() {
    let folder = tempfile::tempdir().unwrap();
    let client = server(folder.path());
    for path in ["/api/session", "/nothing", "/api/nothing"] {
        let answer = client.get(path);
        let policy = answer.header("content-security-policy").unwrap_or_default();
        assert!(policy.contains("default-src 'none'") && !policy.contains("unsafe"), "{path}: {policy}");
        assert_eq!(answer.header("x-content-type-options"), Some("nosniff"));
        assert_eq!(answer.header("referrer-policy"), Some("no-referrer"));
    }
}

#[test]
fn no_path_leads_out_of_the_folders() {
    let outer = tempfile::tempdir().unwrap();
    let inner = outer.path().join("inner");
    std::fs::create_dir(&inner).unwrap();
    std::fs::write(outer.path().join("secret.obj"), "v 0 0 0\n").unwrap();
    let client = server(&inner);
    let folder = inner.to_string_lossy();
    for path in ["/etc", "/", "..", &format!("{folder}/.."), &format!("{folder}/../.."), "/proc/self", "%00", "a%00b"] {
        assert!([400, 404].contains(&client.get(&format!("/api/files?path={path}")).status), "{path}");
    }
    let secret = outer.path().join("secret.obj");
    for file in [secret.to_string_lossy().into_owned(), format!("{folder}/../secret.obj"), "/etc/passwd".into()] {
        assert_eq!(client.post("/api/open", json!({ "pipeline": file })).status, 404, "{file}");
        assert_eq!(client.post("/api/open", json!({ "source": file, "target": file })).status, 404, "{file}");
        assert_eq!(client.get(&format!("/api/written?path={file}")).status, 404, "{file}");
    }
    for name in ["../x.obj", "..", "", "a/b", "%2e%2e%2fx", ".hidden", "a%5Cb", "a%00b"] {
        assert_eq!(client.send_bytes("POST", &format!("/api/upload?name={name}"), b"x").status, 400, "{name}");
    }
    for path in ["/../Cargo.toml", "/..%2f..%2fCargo.toml", "/%2e%2e/secret", "//etc/passwd"] {
        assert_eq!(client.get(path).status, 404, "{path}");
    }
    for name in ["..%2Fx", "a%2Fb", "%2E%2E", "a.b"] {
        let body = json!({ "components": [] });
        assert_eq!(client.send("PUT", &format!("/api/masks/source/{name}/components"), &body).status, 400, "{name}");
    }
}

#[test]
fn bodies_are_bounded() {
    let folder = tempfile::tempdir().unwrap();
    let client = server(folder.path());
    let began = Instant::now();
    // A gigabyte is refused before it is sent.
    for (path, kind, length) in [
        ("/api/markers", "application/json", 1u64 << 30),
        ("/api/pipeline/set", "application/json", 5 << 20),
        ("/api/upload?name=a.obj", "application/octet-stream", 3 << 30),
    ] {
        let head = client.head("POST", path, &format!("Content-Type: {kind}\r\nContent-Length: {length}\r\n"));
        assert_eq!(client.raw(&head, &[]).status, 413, "{path}");
    }
    assert!(began.elapsed() < Duration::from_secs(5));
    // One that does not say its length is cut when it is too long.
    let head = client.head("POST", "/api/markers", "Content-Type: application/json\r\nTransfer-Encoding: chunked\r\n");
    let chunk = format!("100000\r\n{}\r\n", "x".repeat(0x10_0000));
    assert_eq!(client.raw(&head, chunk.repeat(6).as_bytes()).status, 413);
    let head = client.head("POST", "/api/markers", "Content-Type: text/plain\r\nContent-Length: 2\r\n");
    assert_eq!(client.raw(&head, b"{}").status, 415);
    let long = "x".repeat(100_000);
    assert!([0, 400, 414, 431].contains(&client.get(&format!("/api/files?path={long}")).status));
    assert_eq!(client.get("/api/session").status, 200);
}

#[test]
fn malformed_requests_are_told_apart_from_faults() {
    let folder = tempfile::tempdir().unwrap();
    let client = server(folder.path());
    let project = client.project();
    let bodies = [
        json!(null),
        json!([]),
        json!({}),
        json!({ "project": "x" }),
        json!({ "project": project, "base": -1, "id": "a", "ops": [] }),
        json!({ "project": project, "base": 1, "id": "", "ops": [] }),
        json!({ "project": project, "base": 1e300, "id": "a", "ops": [] }),
        json!({ "project": project, "base": 99, "id": "a", "ops": [] }),
        json!({ "project": project, "base": 1, "id": "a", "ops": [{ "op": "explode" }] }),
        json!({ "project": project, "base": 1, "id": "a", "ops": [{ "op": "move", "pair": 1, "side": "up", "point": null }] }),
    ];
    for body in bodies {
        let answer = client.post("/api/markers", body.clone());
        assert_eq!(answer.status, 400, "{body} {}", answer.json());
    }
    for (method, path) in [
        ("GET", "/api/mesh/up"),
        ("GET", "/api/jobs/x"),
        ("DELETE", "/api/jobs/7"),
        ("GET", "/api/x"),
        ("PATCH", "/api/run"),
    ] {
        let status = client.send(method, path, &json!({})).status;
        assert!((400..500).contains(&status), "{method} {path} {status}");
    }
    for text in ["GARBAGE\r\n\r\n", "GET /api/session HTTP/1.1\r\nHost: a\r\nHost: b\r\n\r\n", "\0\0\0\0\r\n\r\n"] {
        let status = client.raw(text, &[]).status;
        assert!(status == 0 || (400..500).contains(&status), "{text:?} {status}");
    }
    assert_eq!(client.get("/api/session").status, 200);
}

#[test]
fn two_hundred_connections_are_too_many_and_pass() {
    let folder = tempfile::tempdir().unwrap();
    let client = server(folder.path());
    let mut streams: Vec<TcpStream> = (0..200).map(|_| TcpStream::connect(client.address).unwrap()).collect();
    std::thread::sleep(Duration::from_millis(300));
    // Those that are too many were answered at once, and closed.
    let is_refused = |stream: &mut TcpStream| {
        stream.set_read_timeout(Some(Duration::from_millis(20))).unwrap();
        let mut start = [0; 12];
        stream.read(&mut start).is_ok_and(|count| start[..count].ends_with(b"503"))
    };
    let refused = streams.iter_mut().map(is_refused).filter(|refused| *refused).count();
    assert!((200 - 64 - 1..200).contains(&refused), "{refused}");
    drop(streams);
    let began = Instant::now();
    while client.get("/api/session").status != 200 {
        assert!(began.elapsed() < Duration::from_secs(5));
    }
}

#[test]
fn a_slow_head_is_cut() {
    let folder = tempfile::tempdir().unwrap();
    let client = server(folder.path());
    let mut stream = TcpStream::connect(client.address).unwrap();
    stream.write_all(b"GET /api/session HTTP/1.1\r\nHost: ").unwrap();
    stream.set_read_timeout(Some(Duration::from_secs(25))).unwrap();
    let answer = read_answer(&mut stream);
    assert!(answer.status == 0 || answer.status == 408, "{answer:?}");
}
