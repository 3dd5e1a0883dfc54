//! Files that ask for much more than they are: work and memory grow with the bytes, or the file is refused with a reason.

mod support;

use std::time::Instant;

use mimesh_core::mesh::{Statistics, Surface};
use mimesh_formats::{Obj, Off, Ply};
use serde_json::json;
use support::{
    gltf::{File, positions},
    message, read,
};

/// Far above what linear work takes for these files, and far below what a square of it would.
const MAX_SECONDS: f64 = 20.0;

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

/// A square of two triangles under node 0.
fn square() -> File {
    let mut file = File::new();
    let position = file.floats(&[[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [1., 1., 0.]]);
    let indices = file.accessor("SCALAR", 5121, 6, &[0, 1, 2, 2, 1, 3]);
    file.push("meshes", json!({ "primitives": [{ "attributes": { "POSITION": position }, "indices": indices }] }));
    file.push("nodes", json!({ "mesh": 0 }));
    file
}

#[test]
fn very_many_faces_names_and_corners_take_time_in_proportion() {
    let start = Instant::now();
    let fan: String = (0..50_000).map(|i| format!("v 0 1 {i}\nf 1 2 {}\n", i + 4)).collect();
    let names: String = (0..50_000).map(|i| format!("o {i}\nusemtl {i}\nf 1 2 3\n")).collect();
    let polygon: String = (0..300_000).map(|i| format!(" {}", i % 3 + 1)).collect();
    for text in [fan, names, format!("f {polygon}\n")] {
        let mesh = read(&Obj::default(), "a.obj", format!("{TRIANGLE}{text}").as_bytes()).unwrap().rest;
        let topology = Surface::new(&mesh).unwrap().topology();
        assert!(topology.adjacent.len() <= 8 * mesh.polygons.corner_count());
        Statistics::new(&mesh).unwrap();
    }
    assert!(start.elapsed().as_secs_f64() < MAX_SECONDS);
}

#[test]
fn groups_times_parts_are_refused() {
    let groups: String = (0..10_000).map(|i| format!(" {i}")).collect();
    let text = format!("{TRIANGLE}g{groups}\n{}", "usemtl a\nf 1 2 3\nusemtl b\nf 1 2 3\n".repeat(1000));
    let error = message(&read(&Obj::default(), "a.obj", text.as_bytes()).unwrap_err());
    assert!(error.starts_with("a.obj:") && error.contains("10000 groups at once"), "{error}");
}

#[test]
fn counts_of_headers_are_held_against_the_bytes_before_room_is_made() {
    let ply = |count: &str, list: &str| {
        let header = "property float x\nproperty float y\nproperty float z\nelement face 1\nproperty list";
        format!(
            "ply\nformat binary_little_endian 1.0\nelement vertex {count}\n{header} {list} int vertex_indices\nend_header\n"
        )
    };
    let error = |bytes: &[u8]| message(&read(&Ply::default(), "a.ply", bytes).unwrap_err());
    let found = error(ply("4000000000", "uchar").as_bytes());
    let expected =
        "the header counts 4000000000 vertex entries of at least 12 bytes each, the file has 0 bytes for them";
    assert!(found.contains(expected), "{found}");
    let lists = [ply("0", "uint").as_bytes(), &0x8000_0000_u32.to_le_bytes()].concat();
    assert!(error(&lists).contains("the file ends in face 0"), "{}", error(&lists));
    let lists = [ply("0", "int").as_bytes(), &(-2_i32).to_le_bytes()].concat();
    assert!(error(&lists).contains("of face 0 (from 0) has the length -2"), "{}", error(&lists));
    let off = message(&read(&Off::default(), "a.off", b"OFF\n3000000000 1 0\n0 0 0\n").unwrap_err());
    assert!(off.contains("the file ends in vertex 1"), "{off}");
}

#[test]
fn a_mesh_under_very_many_nodes_is_refused_and_under_some_it_is_read() {
    let placed = |count: usize| {
        let mut file = square();
        file.json["nodes"] = json!(vec![json!({ "mesh": 0 }); count]);
        file.json["scenes"] = json!([{ "nodes": (0..count).collect::<Vec<_>>() }]);
        file.read()
    };
    assert_eq!(placed(10_000).unwrap().rest.positions.len(), 40_000);
    let error = message(&placed(300_000).unwrap_err());
    assert!(error.contains("is used so often that more than 8388608 numbers come of the"), "{error}");
}

#[test]
fn morph_targets_may_share_an_accessor_ten_thousand_times() {
    let mut file = square();
    let count = 10_000;
    let rise = file.floats(&[[0., 0., 1.]; 4]);
    file.json["meshes"][0]["primitives"][0]["targets"] = json!(vec![json!({ "POSITION": rise }); count]);
    let sequence = file.read().unwrap();
    assert_eq!(sequence.poses.len(), count);
    let last = sequence.poses[count - 1].positions.get().unwrap().into_owned();
    assert!(last.iter().all(|p| p.z == 1.0));
}

#[test]
fn nodes_share_the_weights_of_their_mesh() {
    let mut file = square();
    let rise = file.floats(&[[0., 0., 1.]; 4]);
    file.json["meshes"][0]["primitives"][0]["targets"] = json!([{ "POSITION": rise }]);
    file.json["meshes"][0]["weights"] = json!(vec![0.5; 20_000]);
    file.json["nodes"] = json!(vec![json!({ "mesh": 0 }); 20_000]);
    // As numbers of their own these would be three gigabytes.
    let sequence = file.read().unwrap();
    assert_eq!(positions(&sequence).len(), 1);
}
