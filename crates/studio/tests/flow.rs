//! The whole job by requests: open, look, correct, undo, change the pipeline, run.

mod common;

use std::{fs, path::Path};

use common::{Client, sample, serve, weights};
use mimesh_studio::Start;
use serde_json::{Value, json};

fn vertex(v: u64) -> Value {
    json!({ "vertex": v })
}

fn header(bytes: &[u8]) -> Value {
    assert_eq!(&bytes[..4], b"MSB1");
    let length = u32::from_le_bytes([bytes[4], bytes[5], bytes[6], bytes[7]]) as usize;
    serde_json::from_slice(&bytes[8..8 + length]).unwrap()
}

#[test]
fn two_files_become_a_pipeline_with_markers() {
    let folder = tempfile::tempdir().unwrap();
    sample(folder.path());
    let client = serve(folder.path(), None);
    assert_eq!(client.session()["project"], Value::Null);
    assert_eq!(client.get("/api/markers").status, 404);
    let listed = client.get("/api/files").json();
    let kinds: Vec<_> =
        listed["entries"].as_array().unwrap().iter().map(|entry| entry["kind"].as_str().unwrap()).collect();
    assert_eq!(kinds, ["mesh", "mesh", "mesh", "mesh", "pipeline"]);
    let file = |name: &str| folder.path().join(name);
    let session = client.post("/api/open", json!({ "source": file("a.obj"), "target": file("b.obj") }));
    assert_eq!(session.status, 200, "{}", session.json());
    assert_eq!(session.json()["name"], "b-from-a");
    assert_eq!(session.json()["target"]["vertices"], 642);
    // Looking makes no files.
    assert!(!file("b-from-a.yaml").exists() && !file("b-from-a.markers.yaml").exists());
    let mesh = client.get("/api/mesh/target");
    let lengths: Vec<_> = header(&mesh.body)["arrays"]
        .as_array()
        .unwrap()
        .iter()
        .map(|array| array["length"].as_u64().unwrap())
        .collect();
    assert_eq!(lengths, [3 * 642, 3 * 1280, 1280, 642, 2 * 1920]);
    // The first click does.
    let done = client.edit("1", json!([{ "op": "add", "name": "top", "source": vertex(3), "target": vertex(5) }]));
    assert_eq!(done.status, 200, "{}", done.json());
    let text = fs::read_to_string(file("b-from-a.yaml")).unwrap();
    assert!(text.contains("markers: b-from-a.markers.yaml"), "{text}");
    assert!(fs::read_to_string(file("b-from-a.markers.yaml")).unwrap().contains("\"top\""));
    // Opened again, work goes on where it stopped.
    let again = client.post("/api/open", json!({ "source": file("a.obj"), "target": file("b.obj") })).json();
    assert_ne!(again["project"], session.json()["project"]);
    assert_eq!(client.markers()["pairs"][0]["name"], "top");
    let stale =
        client.post("/api/markers", json!({ "project": session.json()["project"], "base": 1, "id": "x", "ops": [] }));
    assert_eq!(stale.status, 409);
}

fn opened(folder: &Path) -> Client {
    let pipeline = sample(folder);
    serve(folder, Some(Start::Pipeline(pipeline)))
}

#[test]
fn clicks_are_undone_merged_and_taken_in_from_the_disk() {
    let folder = tempfile::tempdir().unwrap();
    let client = opened(folder.path());
    for i in 0..3u64 {
        let name = format!("p{i}");
        client.edit(&name, json!([{ "op": "add", "name": name, "source": vertex(10 * i), "target": vertex(10 * i) }]));
    }
    let markers = client.markers();
    assert_eq!(markers["undo"], "add p2");
    let base = markers["revision"].clone();
    let late = client.post("/api/markers/undo", json!({ "base": 1 }));
    assert_eq!((late.status, late.json()["conflicts"][0]["op"].clone()), (409, json!(0)));
    let undone = client.post("/api/markers/undo", json!({ "base": base })).json();
    assert_eq!(
        (undone["markers"]["pairs"].as_array().unwrap().len(), undone["markers"]["redo"].clone()),
        (2, json!("add p2"))
    );
    // An editor changes the file.
    let file = folder.path().join("p.markers.yaml");
    let text = fs::read_to_string(&file).unwrap();
    fs::write(&file, text.replace("\"p1\"", "\"renamed\"")).unwrap();
    let seen = client.wait("/api/markers", |markers| markers["pairs"][1]["name"] == "renamed");
    assert_eq!((seen["pairs"][1]["id"].clone(), seen["undo"].clone()), (json!(2), json!("changes in the file")));
    // Something that cannot be read is set aside before it is overwritten.
    fs::write(&file, "markers: [").unwrap();
    client.wait("/api/markers", |markers| markers["disk"] == "changed_elsewhere");
    let done = client.edit("after", json!([{ "op": "rename", "pair": 1, "name": "first" }])).json();
    assert_eq!(done["markers"]["disk"], "saved");
    assert_eq!(fs::read_to_string(folder.path().join("p.markers.unreadable-1.yaml")).unwrap(), "markers: [");
    assert!(fs::read_to_string(&file).unwrap().contains("\"first\""));
}

#[test]
fn a_file_that_cannot_be_written_is_told_and_tried_again() {
    let folder = tempfile::tempdir().unwrap();
    let client = opened(folder.path());
    // A folder in the place of the file.
    fs::create_dir(folder.path().join("p.markers.yaml")).unwrap();
    let done = client.edit("1", json!([{ "op": "add", "source": vertex(1) }])).json();
    assert_eq!(done["markers"]["disk"], "failed", "{done}");
    fs::remove_dir(folder.path().join("p.markers.yaml")).unwrap();
    client.wait("/api/markers", |markers| markers["disk"] == "saved");
    assert!(fs::read_to_string(folder.path().join("p.markers.yaml")).unwrap().contains("target: null"));
}

#[test]
fn the_pipeline_is_changed_by_value_and_by_text() {
    let folder = tempfile::tempdir().unwrap();
    let client = opened(folder.path());
    let checked = client.wait("/api/pipeline", |pipeline| pipeline["checking"] == false);
    assert_eq!(checked["diagnostics"], json!([]), "{checked:#}");
    let set = |base: &Value, path: Value, value: Value| {
        client.post("/api/pipeline/set", json!({ "base": base, "path": path, "value": value }))
    };
    let answer = set(&checked["revision"], json!(["transfer", "type"]), json!("gradien"));
    assert_eq!(answer.status, 200);
    // What the text alone shows is told with the answer, whatever the check of the whole pipeline takes.
    assert_eq!(answer.json()["diagnostics"][0]["path"], json!(["transfer", "type"]), "{:#}", answer.json());
    let wrong = client.wait("/api/pipeline", |pipeline| {
        pipeline["checking"] == false && pipeline["revision"] == answer.json()["revision"]
    });
    let diagnostic = &wrong["diagnostics"][0];
    assert_eq!(diagnostic["path"], json!(["transfer", "type"]), "{diagnostic:#}");
    assert!(diagnostic["line"] == 5 && diagnostic["hint"].as_str().unwrap().contains("gradient"), "{diagnostic:#}");
    assert!(wrong["text"].as_str().unwrap().starts_with("# a comment\n"));
    let late = set(&checked["revision"], json!(["transfer", "type"]), json!("gradient"));
    assert_eq!((late.status, late.json()["conflict"]["revision"].clone()), (409, wrong["revision"].clone()));
    let body = json!({ "base": wrong["revision"], "text": "source: [" });
    let broken = client.send("PUT", "/api/pipeline", &body).json();
    assert!(broken["value"].is_null() && !broken["diagnostics"].as_array().unwrap().is_empty());
    assert_eq!(fs::read_to_string(folder.path().join("p.yaml")).unwrap(), "source: [");
    // What the schema says is what forms are made of.
    let schema = client.get("/api/schema").json();
    assert!(schema.to_string().contains("x-stage"));
}

#[test]
fn a_run_writes_what_the_pipeline_says() {
    let folder = tempfile::tempdir().unwrap();
    let client = opened(folder.path());
    for (i, v) in [0u64, 3, 5, 7, 9, 11].into_iter().enumerate() {
        let id = format!("c{i}");
        client.edit(&id, json!([{ "op": "add", "source": vertex(v), "target": vertex(v) }]));
    }
    let job = client.post("/api/run", json!({})).json();
    let path = format!("/api/jobs/{}", job["id"]);
    let done = client.wait(&path, |job| job["state"] != "running");
    assert_eq!(done["state"], "done", "{done:#}");
    let written = done["result"]["written"].as_array().unwrap();
    assert!(written.len() >= 3, "{written:?}");
    assert!(folder.path().join("out/b-a-1.obj").exists() || folder.path().join("out/b-1.obj").exists(), "{written:?}");
    // The sentences of the report, and what the run was of.
    let summary = &done["result"]["summary"];
    let total = summary["total"].as_str().unwrap();
    assert_eq!(total == "good", summary["things"] == 0, "{summary:#}");
    assert!(!summary["next_steps"].as_array().unwrap().is_empty(), "{summary:#}");
    let worst = done["result"]["worst"].as_array().unwrap();
    assert!(worst.iter().all(|one| one["meaning"].as_str().is_some_and(|text| !text.is_empty())), "{worst:#?}");
    assert_eq!(done["result"]["of"]["markers"], client.markers()["revision"]);
    assert_eq!(done["result"]["of"]["pipeline"], client.get("/api/pipeline").json()["revision"]);
    let url = written[0]["url"].as_str().unwrap();
    let file = client.get(url);
    assert_eq!((file.status, file.body.len() as u64), (200, written[0]["bytes"].as_u64().unwrap()));
    assert!(file.header("content-security-policy").unwrap().contains("sandbox"));
}

#[test]
fn masks_are_saved_beside_the_pipeline() {
    let folder = tempfile::tempdir().unwrap();
    let client = opened(folder.path());
    let bytes = weights(&(0..162).map(|i| i as f32 / 162.0).collect::<Vec<_>>());
    let mask = client.send_bytes("PUT", "/api/masks/source/left%20ear", &bytes);
    assert_eq!(mask.status, 200, "{}", mask.json());
    assert!(folder.path().join("left ear.source.mask.json").exists());
    let back = client.get("/api/masks/source/left%20ear").body;
    assert_eq!(back[back.len() - 4 * 162..], bytes[bytes.len() - 4 * 162..]);
    assert_eq!(client.send_bytes("PUT", "/api/masks/target/x", &bytes).status, 400, "of another number of vertices");
    let parts = client.session()["target"]["components"][0]["name"].clone();
    let hard = json!({ "components": [parts] });
    assert_eq!(client.send("PUT", "/api/masks/target/hard/components", &hard).status, 200);
    // A file that is there is replaced only where that is wanted.
    let again = client.send("PUT", "/api/masks/target/hard/components", &hard);
    assert_eq!((again.status, again.json()["error"]["code"].clone()), (409, json!("conflict")));
    assert_eq!(client.send("PUT", "/api/masks/target/hard/components?replace=true", &hard).status, 200);
    assert_eq!(client.send("PUT", "/api/masks/target/hard/components", &json!({ "components": ["no"] })).status, 400);
    let masks = client.get("/api/masks").json();
    assert_eq!(masks["masks"].as_array().unwrap().len(), 2);
    assert_eq!(
        client.send("DELETE", "/api/masks/target/hard", &json!({})).json()["masks"].as_array().unwrap().len(),
        1
    );
}

#[test]
fn uploads_are_opened() {
    let folder = tempfile::tempdir().unwrap();
    sample(folder.path());
    let client = serve(folder.path(), None);
    let upload = |name: &str| {
        let bytes = fs::read(folder.path().join(name)).unwrap();
        let answer = client.send_bytes("POST", &format!("/api/upload?name={name}"), &bytes);
        assert_eq!(answer.status, 200, "{}", answer.json());
        answer.json()["path"].clone()
    };
    let opened = client.post("/api/open", json!({ "source": upload("a.obj"), "target": upload("b.obj") }));
    assert_eq!(opened.status, 200, "{}", opened.json());
    let listed = client.get("/api/files").json();
    let uploads = &listed["roots"].as_array().unwrap().iter().find(|root| root["name"] == "Uploads").unwrap()["path"];
    let files = client.get(&format!("/api/files?path={}", uploads.as_str().unwrap())).json();
    assert_eq!(files["entries"].as_array().unwrap().len(), 2);
}

#[test]
fn what_to_do_next_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let client = opened(folder.path());
    client.edit("1", json!([{ "op": "add", "name": "half", "source": vertex(1) }]));
    let next = client.get("/api/markers/next").json();
    assert_eq!((next["kind"].clone(), next["source"].clone()), (json!("partner"), vertex(1)));
    client.edit("2", json!([{ "op": "status", "pair": next["pair"], "status": "skipped" }]));
    let next = client.get("/api/markers/next").json();
    assert_ne!(next["kind"], "partner", "{next}");
}

#[test]
fn points_and_settings_have_one_history() {
    let folder = tempfile::tempdir().unwrap();
    let client = opened(folder.path());
    let pipeline = || client.get("/api/pipeline").json();
    let orders = || (client.markers()["undo_order"].as_u64(), pipeline()["undo_order"].as_u64());
    assert_eq!(orders(), (None, None));
    client.edit("1", json!([{ "op": "add", "source": vertex(1), "target": vertex(1) }]));
    // The server names the file of markers, which is no step of the user's.
    assert!(pipeline()["text"].as_str().unwrap().contains("markers: p.markers.yaml"));
    assert!(pipeline()["undo"].is_null());
    let set = |path: Value, value: Value| {
        let body = json!({ "base": pipeline()["revision"], "path": path, "value": value });
        assert_eq!(client.post("/api/pipeline/set", body).status, 200);
    };
    set(json!(["transfer", "type"]), json!("biharmonic"));
    let (markers, settings) = orders();
    assert!(settings > markers, "{markers:?} {settings:?}");
    assert_eq!(pipeline()["undo"], "set transfer.type to biharmonic");
    assert_eq!(client.markers()["undo"], "add a pair");
    let undone = client.post("/api/pipeline/undo", json!({ "base": pipeline()["revision"] }));
    assert_eq!(undone.status, 200);
    let text = undone.json()["text"].as_str().unwrap().to_owned();
    assert!(text.contains("type: gradient") && text.contains("markers: p.markers.yaml"), "{text}");
    assert_eq!(undone.json()["redo"], "set transfer.type to biharmonic");
    assert_eq!(fs::read_to_string(folder.path().join("p.yaml")).unwrap(), text);
    // An old revision and an empty history are refused.
    assert_eq!(client.post("/api/pipeline/undo", json!({ "base": 1 })).status, 409);
    assert_eq!(client.post("/api/pipeline/undo", json!({ "base": pipeline()["revision"] })).status, 409);
    // A new step of one document ends what the other could do again.
    client.edit("2", json!([{ "op": "rename", "pair": 1, "name": "nose" }]));
    assert!(pipeline()["redo"].is_null());
}

#[test]
fn numbers_of_points_stay_when_others_go() {
    let folder = tempfile::tempdir().unwrap();
    let client = opened(folder.path());
    for v in 0..4 {
        client.edit(&format!("a{v}"), json!([{ "op": "add", "source": vertex(v), "target": vertex(v) }]));
    }
    client.edit("d", json!([{ "op": "delete", "pair": 2 }]));
    client.edit("n", json!([{ "op": "add", "source": vertex(9), "target": vertex(9) }]));
    let numbers = || {
        let pairs = client.markers()["pairs"].as_array().unwrap().clone();
        pairs.iter().map(|pair| pair["number"].as_u64().unwrap()).collect::<Vec<_>>()
    };
    assert_eq!(numbers(), [1, 3, 4, 5]);
    client.edit("m", json!([{ "op": "move", "pair": 3, "side": "target", "point": vertex(30) }]));
    assert_eq!(client.markers()["undo"], "move point 3");
    for _ in 0..3 {
        client.post("/api/markers/undo", json!({ "base": client.markers()["revision"] }));
    }
    assert_eq!(numbers(), [1, 2, 3, 4]);
}

#[test]
fn other_poses_of_the_same_meshes_leave_the_points_and_their_history() {
    let folder = tempfile::tempdir().unwrap();
    let client = opened(folder.path());
    client.edit("1", json!([{ "op": "add", "name": "nose", "source": vertex(1), "target": vertex(1) }]));
    let project = client.project();
    let set = |key: &str, value: Value| {
        let base = client.get("/api/pipeline").json()["revision"].clone();
        client.post("/api/pipeline/set", json!({ "base": base, "path": ["source", key], "value": value })).json()
    };
    set("poses", json!(["a-2.obj"]));
    assert_ne!(client.project(), project);
    assert_eq!(client.session()["poses"]["list"].as_array().unwrap().len(), 1);
    let markers = client.markers();
    assert_eq!((&markers["pairs"][0]["id"], &markers["undo"]), (&json!(1), &json!("add nose")));
    assert_eq!(client.get("/api/pipeline").json()["undo"], "set source.poses to [a-2.obj]");
    // What cannot be opened is told with the answer, and the meshes from before stay.
    let answer = set("rest", json!("missing.obj"));
    assert!(answer["diagnostics"][0]["message"].as_str().unwrap().contains("missing.obj"), "{answer:#}");
    assert_eq!(client.session()["poses"]["list"].as_array().unwrap().len(), 1);
}

#[test]
fn texts_of_forms_are_read_as_yaml() {
    let folder = tempfile::tempdir().unwrap();
    let client = opened(folder.path());
    let read = |text: &str| client.post("/api/yaml", json!({ "text": text }));
    assert_eq!(read("{ clip: Run, fps: 24 }").json()["value"], json!({ "clip": "Run", "fps": 24 }));
    assert_eq!(read("[a-{pose}.obj, \"b c\"]").json()["value"], json!(["a-{pose}.obj", "b c"]));
    assert_eq!(read("a.obj").json()["value"], "a.obj");
    assert!(read("a.obj").json()["problem"].is_null());
    let wrong = read("{ clip: Run").json();
    assert!(wrong["problem"].as_str().unwrap().starts_with("this is no YAML: "), "{wrong}");
}
