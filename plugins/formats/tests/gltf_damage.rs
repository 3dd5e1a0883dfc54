//! glTF: damaged files say why, and nothing makes the reader panic.

mod support;

use mimesh_core::{
    mesh::MeshSequence,
    stage::{BytesInput, ClipTimes, Format, Selection},
    testkit::data::data,
};
use mimesh_formats::{Glb, Gltf};
use proptest::prelude::*;
use serde_json::json;
use support::{
    gltf::{File, about_z, clips, strip},
    message, read,
};

#[test]
fn damaged_and_unsupported_files_say_why() {
    let gltf = |json: &str| message(&read(&Gltf::default(), "a.gltf", json.as_bytes()).unwrap_err());
    let cases = [
        ("{}", "a.gltf: not a glTF: expected JSON with `\"asset\": { \"version\": \"2.0\" }`, found no keys\n"),
        ("nonsense", "a.gltf: not the JSON of a glTF: expected ident at line 1 column 2\n"),
        (r#"{"asset":{"version":"2.0"}}"#, "a.gltf: empty mesh: 0 vertices, 0 polygons\n"),
        (r#"{"asset":{"version":"2.0"},"scene":3}"#, "a.gltf: scene 3 does not exist: there are 0 (from 0)\n"),
        (
            r#"{"asset":{"version":"2.0"},"nodes":[{"children":[1]},{"children":[0]}],"scenes":[{"nodes":[0]}]}"#,
            "a.gltf: node 0 stands in a circle of nodes\n",
        ),
        (
            r#"{"asset":{"version":"2.0"},"nodes":[{"mesh":0}],"meshes":[{"name":"m","primitives":[{"attributes":{"POSITION":9}}]}]}"#,
            "a.gltf: mesh `m`, primitive 0: accessor 9 does not exist: there are 0 (from 0)\n",
        ),
        (r#"{"asset":{"version":"2.0"},"buffers":[{"byteLength":4}]}"#, "a.gltf: buffer 0 has no data\n"),
    ];
    for (json, expected) in cases {
        let found = gltf(json);
        assert!(found.starts_with(expected), "{found}");
    }
    let without_buffer = read(
        &Gltf::default(),
        "a.gltf",
        br#"{"asset":{"version":"2.0"},"buffers":[{"byteLength":4,"uri":"my%20data.bin"}]}"#,
    );
    assert!(message(&without_buffer.unwrap_err()).starts_with("my data.bin: cannot read: "));
}

#[test]
fn a_cut_real_file_is_an_error() {
    let Some(path) = data("khronos-gltf/Fox.glb") else { return };
    let bytes = std::fs::read(path).unwrap();
    for length in [0, 3, 4, 11, 12, 19, 20, 1000, bytes.len() / 2, bytes.len() - 1] {
        assert!(read(&Glb::default(), "fox.glb", &bytes[..length]).is_err());
    }
}

/// A skinned, morphing and animated file.
fn lively() -> File {
    let mut file = strip();
    let target = file.floats(&[[0.0, 0.0, 1.0]; 6]);
    file.json["meshes"][0]["primitives"][0]["targets"] = json!([{ "POSITION": target }]);
    let output = file.floats(&[about_z(0.0), about_z(90.0)]);
    file.clip("Turn", 3, "rotation", "LINEAR", &[0.0, 1.0], output);
    let output = file.floats(&[[0.0], [0.0], [0.0], [0.0], [1.0], [0.0]]);
    file.clip("Rise", 0, "weights", "CUBICSPLINE", &[0.0, 1.0], output);
    file
}

/// Whatever is read is whole and finite.
fn check(sequence: &MeshSequence) {
    sequence.rest.validate().unwrap();
    for pose in &sequence.poses {
        // Or an error that says why.
        let Ok(positions) = pose.positions.get() else { continue };
        assert_eq!(positions.len(), sequence.rest.positions.len());
        assert!(positions.iter().all(|p| p.coords.iter().all(|x| x.is_finite())));
    }
}

fn read_all(bytes: &[u8]) {
    for selection in [Selection { keep_document: true, ..Selection::default() }, clips(&[], ClipTimes::Keys, None)] {
        if let Ok(sequence) = Gltf::default().read(&BytesInput::new("a.gltf", bytes), &selection) {
            check(&sequence);
        }
    }
}

proptest! {
    #[test]
    fn no_damaged_number_makes_the_reader_panic(edits in prop::collection::vec((any::<prop::sample::Index>(), prop::sample::select(b"0123456789-.e".to_vec())), 1..6)) {
        let mut bytes = lively().text();
        let digits: Vec<_> = (0..bytes.len()).filter(|&at| bytes[at].is_ascii_digit()).collect();
        edits.iter().for_each(|(at, byte)| bytes[digits[at.index(digits.len())]] = *byte);
        read_all(&bytes);
    }

    #[test]
    fn no_damaged_data_makes_the_reader_panic(edits in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..20)) {
        let mut file = lively();
        edits.iter().for_each(|(at, byte)| { let at = at.index(file.bytes.len()); file.bytes[at] = *byte; });
        read_all(&file.text());
    }

    #[test]
    fn no_lost_entry_makes_the_reader_panic(paths in prop::collection::vec(any::<prop::sample::Index>(), 1..4), value in prop::sample::select(vec!["null", "-1", "7.5", "\"x\"", "[]", "{}", "1e300"])) {
        let mut file = lively();
        for path in paths {
            let mut pointers = Vec::new();
            list(&file.json, String::new(), &mut pointers);
            *file.json.pointer_mut(&pointers[path.index(pointers.len())]).unwrap() = serde_json::from_str(value).unwrap();
        }
        if file.json.get("bufferViews").is_some() {
            read_all(&file.json.to_string().into_bytes());
            if file.json["asset"].is_object() {
                read_all(&file.text());
            }
        }
    }
}

/// The pointers to all entries below `value`.
fn list(value: &serde_json::Value, path: String, pointers: &mut Vec<String>) {
    let entries: Vec<(String, &serde_json::Value)> = match value {
        serde_json::Value::Object(map) => map.iter().map(|(key, value)| (key.clone(), value)).collect(),
        serde_json::Value::Array(values) => {
            values.iter().enumerate().map(|(i, value)| (i.to_string(), value)).collect()
        }
        _ => Vec::new(),
    };
    for (key, value) in entries {
        let path = format!("{path}/{key}");
        pointers.push(path.clone());
        list(value, path, pointers);
    }
}
