//! Files beside a mesh are read once, however often they are named, and names from files never make messages long.

mod support;

use std::{
    borrow::Cow,
    path::Path,
    sync::atomic::{AtomicUsize, Ordering},
};

use mimesh_core::{
    Result,
    stage::{BytesInput, ClipTimes, FileInput, Format, Selection},
};
use mimesh_formats::{Glb, Gltf, Obj};
use serde_json::{Value, json};
use support::{
    gltf::{File, clips, strip},
    message, read, write,
};

/// A file with others beside it that counts how often these are read.
#[derive(Debug, Default)]
struct Counting {
    file: BytesInput,
    reads: AtomicUsize,
}

impl FileInput for Counting {
    fn path(&self) -> &Path {
        &self.file.path
    }

    fn contents(&self) -> Result<Cow<'_, [u8]>> {
        self.file.contents()
    }

    fn referenced(&self, reference: &str) -> Result<Vec<u8>> {
        let contents = self.file.referenced(reference)?;
        self.reads.fetch_add(1, Ordering::Relaxed);
        Ok(contents)
    }
}

fn counting(name: &str, contents: &[u8], others: &[(&str, &[u8])]) -> Counting {
    let others = others.iter().map(|(name, contents)| ((*name).to_owned(), contents.to_vec())).collect();
    let file = BytesInput { others, ..BytesInput::new(name, contents) };
    Counting { file, ..Counting::default() }
}

#[test]
fn a_material_library_is_read_once_whatever_lines_name_it() {
    let text = format!(
        "{}v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\nf 1 2 3\n",
        "mtllib a.mtl\nmtllib  a.mtl a.mtl \n".repeat(250)
    );
    let input = counting("a.obj", text.as_bytes(), &[("a.mtl", b"newmtl red\nKd 1 0 0\n")]);
    let sequence = Obj::default().read(&input, &Selection::default()).unwrap();
    assert_eq!(sequence.rest.materials[0].base_color, [1.0, 0.0, 0.0, 1.0]);
    assert_eq!((sequence.warnings, input.reads.into_inner()), (vec![], 1));
}

/// [`strip`] whose one buffer is `a.bin`, named `count` times.
fn many_buffers(count: usize) -> (File, Vec<u8>) {
    let mut file = strip();
    let bytes = file.bytes.clone();
    file.json["buffers"] = json!(vec![json!({ "uri": "a.bin", "byteLength": bytes.len() }); count]);
    for (index, view) in file.json["bufferViews"].as_array_mut().unwrap().iter_mut().enumerate() {
        view["buffer"] = (index * (count - 1) / 8 % count).into();
    }
    (file, bytes)
}

#[test]
fn buffers_and_images_of_one_file_are_read_and_written_once() {
    let (file, bytes) = many_buffers(250);
    let mut json = file.json.clone();
    let png = b"\x89PNG\r\n\x1a\n and so on";
    json["images"] = json!(vec![json!({ "uri": "a.png" }); 100]);
    let input = counting("a.gltf", json.to_string().as_bytes(), &[("a.bin", &bytes), ("a.png", png)]);
    let keep = Selection { keep_document: true, ..Selection::default() };
    let sequence = Gltf::default().read(&input, &keep).unwrap();
    assert_eq!(sequence.rest.positions, strip().read().unwrap().rest.positions);
    assert_eq!(input.reads.into_inner(), 2);
    let written = write(&Glb::default(), &sequence.rest, &sequence.rest.positions);
    // Each of the 350 files would take some 600 bytes of its own, and the JSON of the images takes 100 bytes each.
    assert!(written.len() < json.to_string().len() + 20 * bytes.len(), "{}", written.len());
    let back = read(&Glb::default(), "a.glb", &written).unwrap();
    assert_eq!(back.rest.positions, sequence.rest.positions);
}

#[test]
fn names_and_values_of_a_file_never_make_errors_long() {
    let long = "n".repeat(5000);
    let error = |change: &dyn Fn(&mut Value)| {
        let mut file = strip();
        change(&mut file.json);
        let bytes = if file.json["buffers"].is_array() { file.json.to_string().into_bytes() } else { file.text() };
        message(&read(&Gltf::default(), "a.gltf", &bytes).unwrap_err())
    };
    let set = |pointer: &'static str, value: Value| {
        move |json: &mut Value| *json.pointer_mut(pointer).unwrap() = value.clone()
    };
    type Change<'a> = Box<dyn Fn(&mut Value) + 'a>;
    let wrong: [(&str, Change<'_>); 7] = [
        (
            "primitive 0",
            Box::new(|json| {
                json["nodes"][0]["name"] = long.as_str().into();
                json["meshes"][0]["primitives"][0]["indices"] = 99.into();
            }),
        ),
        (
            "`scale`",
            Box::new(|json| {
                json["nodes"][2]["name"] = long.as_str().into();
                json["nodes"][2]["scale"] = long.as_str().into();
            }),
        ),
        ("invalid type", Box::new(set("/meshes/0/primitives/0/indices", json!(long)))),
        ("version", Box::new(|json| json["asset"] = json!({ "version": long }))),
        (
            "buffer 0 lies at",
            Box::new(|json| json["buffers"] = json!([{ "byteLength": 1, "uri": format!("https://{long}") }])),
        ),
        ("expected the path of a file", Box::new(|json| json["buffers"] = json!([{ "byteLength": 1, "uri": long }]))),
        (
            "expected the path of a file",
            Box::new(|json| json["buffers"] = json!([{ "byteLength": 1, "uri": "a%00b" }])),
        ),
    ];
    for (expected, change) in &wrong {
        let found = error(change);
        assert!(found.len() < 500 && found.contains(expected), "{expected}: {found}");
    }
}

#[test]
fn clips_are_cut_into_a_bounded_number_of_poses_together() {
    let mut file = strip();
    let output = file.floats(&[[0., 0., 0.], [1., 0., 0.]]);
    // At 24 a second each clip has 600,001 poses.
    for name in ["first", "second"] {
        file.clip(name, 2, "translation", "LINEAR", &[0.0, 25_000.0], output);
    }
    let every = ClipTimes::PerSecond(24.0);
    assert_eq!(file.select(&clips(&["first"], every, None)).unwrap().poses.len(), 600_001);
    let error = message(&file.select(&clips(&[], every, None)).unwrap_err());
    assert!(error.contains("with the clip `second` the poses are more than 1000000: choose some clips"), "{error}");
    assert_eq!(file.select(&clips(&[], ClipTimes::Keys, None)).unwrap().poses.len(), 4);
}
