//! All bytes in one buffer: of other files, of compressed views, of images.

use mimesh_core::mesh::Document;
use nalgebra::Vector3;
use serde_json::{Value, json};

use super::{
    build::{Builder, write},
    evaluate::{load, parts, shapes},
};
use crate::{Glb, gltf::document::GltfDocument};

/// A square as a GLB.
fn square() -> Vec<u8> {
    let mut file = Builder::new(json!({
        "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0] }], "nodes": [{ "mesh": 0 }],
    }));
    let primitive = file.square(1.0);
    file.json["meshes"] = json!([{ "primitives": [primitive] }]);
    file.glb()
}

/// What is written for the square when `change` has made another document of its own; all of it goes up by 1.
fn written(change: impl Fn(&mut GltfDocument)) -> (Vec<u8>, Vec<String>) {
    let glb = square();
    let mut mesh = load(&glb);
    let posed: Vec<_> = mesh.positions.iter().map(|p| p + Vector3::z()).collect();
    // The same document again: that of the mesh cannot be changed.
    let GltfDocument { json, buffers, .. } = mesh.document.get().unwrap();
    let mut document = GltfDocument { json: json.clone(), buffers: buffers.clone(), ..GltfDocument::default() };
    change(&mut document);
    let again = load(&glb);
    let placements = take_placements(again.document);
    document.placements = placements;
    mesh.document = Document::new(document);
    let (after, warnings) = write(&Glb::default(), &mesh, &[("up", None, posed.clone())]);
    let found = shapes(&after);
    assert_eq!((found[0].at(&[]), found[0].with(0)), (mesh.positions, posed));
    (after, warnings)
}

fn take_placements(document: Document) -> Vec<crate::gltf::document::Placement> {
    use crate::gltf::document::{Placement, Transforms};
    let copy = |placement: &Placement| Placement {
        node: placement.node,
        mesh: placement.mesh,
        primitives: placement.primitives.clone(),
        vertices: placement.vertices.clone(),
        stored: placement.stored.clone(),
        scene_from_stored: match &placement.scene_from_stored {
            Transforms::Uniform(matrix) => Transforms::Uniform(*matrix),
            Transforms::Skinned(matrices) => Transforms::Skinned(matrices.clone()),
        },
    };
    document.get::<GltfDocument>().unwrap().placements.iter().map(copy).collect()
}

#[test]
fn buffers_of_other_files_follow_the_first() {
    let (after, warnings) = written(|document| {
        // A first buffer of three bytes; positions and normals, and the indices, in files of their own.
        let all = document.buffers.remove(0);
        document.buffers = vec![vec![7, 8, 9].into(), all[..96].to_vec().into(), all[96..].to_vec().into()];
        document.json["buffers"] = json!([
            { "byteLength": 3, "name": "mine" }, { "byteLength": 96, "uri": "a.bin" }, { "byteLength": 12, "uri": "b.bin" },
        ]);
        for (index, view) in document.json["bufferViews"].as_array_mut().unwrap().iter_mut().enumerate() {
            let second = index == 2;
            view["buffer"] = (1 + usize::from(second)).into();
            view["byteOffset"] = if second { 0 } else { 48 * index }.into();
        }
    });
    assert_eq!(warnings, [""; 0]);
    let (json, bytes) = parts(&after);
    assert_eq!(json["buffers"].as_array().unwrap().len(), 1);
    assert_eq!(json["buffers"][0]["name"], "mine");
    assert_eq!(bytes[..4], [7, 8, 9, 0]);
}

#[test]
fn compressed_views_are_written_out() {
    for other_use in [false, true] {
        let (after, warnings) = written(|document| {
            let all = document.buffers.remove(0);
            document.buffers = vec![vec![1; 8].into(), Vec::new().into()];
            let fallback = json!({ "EXT_meshopt_compression": { "fallback": true } });
            document.json["buffers"] = json!([{ "byteLength": 8 }, { "byteLength": 108, "extensions": fallback }]);
            let packed = json!({ "buffer": 0, "byteOffset": 0, "byteLength": 8, "byteStride": 12, "mode": "ATTRIBUTES", "count": 4 });
            let views = document.json["bufferViews"].as_array_mut().unwrap();
            for (index, view) in views.iter_mut().enumerate() {
                let start = view["byteOffset"].as_u64().unwrap() as usize;
                let length = view["byteLength"].as_u64().unwrap() as usize;
                document.decompressed.insert(index, all[start..start + length].to_vec());
                view["buffer"] = 1.into();
                view["extensions"] = json!({ "EXT_meshopt_compression": packed });
            }
            if other_use {
                let extensions = json!({ "EXT_meshopt_compression": packed });
                views.push(json!({ "buffer": 1, "byteLength": 48, "extensions": extensions }));
            }
            document.json["extensionsUsed"] = json!(["EXT_meshopt_compression", "KHR_materials_unlit"]);
            document.json["extensionsRequired"] = json!(["EXT_meshopt_compression"]);
        });
        let json = parts(&after).0;
        if other_use {
            // A view that was not unpacked still needs extension and fallback buffer.
            assert_eq!(json["extensionsRequired"], json!(["EXT_meshopt_compression"]));
            assert_eq!(json["bufferViews"][3]["buffer"], 1);
            assert_eq!(json["buffers"].as_array().unwrap().len(), 2);
        } else {
            assert_eq!(warnings, ["compressed parts of the file are written uncompressed"]);
            assert_eq!(json["extensionsUsed"], json!(["KHR_materials_unlit"]));
            assert_eq!(json.get("extensionsRequired"), None);
            assert_eq!(json["buffers"].as_array().unwrap().len(), 1);
        }
        let is_packed = |view: &&Value| view.get("extensions").is_some();
        assert_eq!(json["bufferViews"].as_array().unwrap().iter().filter(is_packed).count(), usize::from(other_use));
    }
}

#[test]
fn images_of_other_files_are_taken_in_as_what_they_are() {
    let png = b"\x89PNG\r\n\x1a\nrest".to_vec();
    let images: [(&str, &[u8]); 4] = [
        ("image/png", &png),
        ("image/jpeg", b"\xff\xd8\xff\xe0"),
        ("image/webp", b"RIFF1234WEBPVP8 "),
        ("image/ktx2", b"\xabKTX 20\xbb\r\n\x1a\n"),
    ];
    let (after, warnings) = written(|document| {
        document.images = images.iter().enumerate().map(|(i, (_, bytes))| (i, bytes.to_vec().into())).collect();
        document.images.push((5, b"who knows".to_vec().into()));
        document.json["images"] = json!([
            { "uri": "a.png", "name": "skin" }, { "uri": "b.jpg" }, { "uri": "c.webp", "mimeType": "image/png" }, { "uri": "d" },
            { "uri": "missing.png" }, { "uri": "odd" }, { "uri": "data:image/png;base64,AAAA" },
        ]);
    });
    assert_eq!(warnings, ["image 5 is of an unknown kind and stays a file of its own"]);
    let (json, buffer) = parts(&after);
    for (image, (kind, bytes)) in json["images"].as_array().unwrap().iter().zip(images) {
        assert_eq!((image.get("uri"), &image["mimeType"]), (None, &json!(kind)));
        let view = &json["bufferViews"][image["bufferView"].as_u64().unwrap() as usize];
        let start = view["byteOffset"].as_u64().unwrap() as usize;
        assert_eq!(&buffer[start..start + view["byteLength"].as_u64().unwrap() as usize], bytes);
    }
    assert_eq!(json["images"][0]["name"], "skin");
    let others =
        [json!({ "uri": "missing.png" }), json!({ "uri": "odd" }), json!({ "uri": "data:image/png;base64,AAAA" })];
    assert_eq!(json["images"].as_array().unwrap()[4..], others);
}
