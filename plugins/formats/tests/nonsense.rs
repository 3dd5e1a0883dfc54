//! What cannot be meant is an error that names its place, or a warning.

mod support;

use mimesh_core::stage::Format;
use mimesh_formats::{Mdd, Obj, Off, Pc2, Ply, Stl};
use serde_json::{Value, json};
use support::{
    gltf::{File, strip},
    message, read,
};

const VERTICES: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

fn error(format: &dyn Format, name: &str, bytes: &[u8]) -> String {
    message(&read(format, name, bytes).unwrap_err())
}

#[test]
fn obj_coordinates_are_numbers_whose_squares_are_finite() {
    let error = |x: &str| error(&Obj::default(), "a.obj", format!("v {x} 0 0\n{VERTICES}f 1 2 3\n").as_bytes());
    assert!(
        error("1e308").starts_with("a.obj:1: vertex 1 has coordinate `1e308`: expected a number below 1e50\nscale")
    );
    assert!(error("nan").starts_with("a.obj:1: vertex 1 has coordinate `nan`: expected a finite number\nrepair"));
    let long = error(&"9".repeat(5000));
    assert!(long.len() < 250, "{long}");
}

#[test]
fn obj_attributes_that_lack_numbers_are_told() {
    let text = format!("{VERTICES}vt 0.5\nvt\nvn 0 1\nf 1/1/1 2/2/1 3/1/1\n");
    let warnings = read(&Obj::default(), "a.obj", text.as_bytes()).unwrap().warnings;
    assert_eq!(warnings, ["`vt` and `vn` lines lack 3 numbers, which were read as 0"]);
}

#[test]
fn ply_headers_and_entries_agree() {
    let text = |vertex: &str, faces: &str| {
        let header = "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n";
        format!("ply\nformat ascii 1.0\nelement vertex 3\n{vertex}\n{header}{faces}")
    };
    let error = |vertex: &str, faces: &str| error(&Ply::default(), "a.ply", text(vertex, faces).as_bytes());
    let xyz = "property float x\nproperty float y\nproperty float z";
    let without = error(&xyz.replace(" x", " a"), "3 0 1 2\n");
    let expected =
        "a.ply: the element `vertex` has no property `x`: expected numbers x, y and z, found `a`, `y`, `z`\nname";
    assert!(without.starts_with(expected), "{without}");
    let more = error(xyz, "3 0 1 2\n3 2 1 0\n");
    assert!(more.starts_with("a.ply:14: not a PLY: the file has more entries than the header counts\n"), "{more}");
    let twice = error(&xyz.replace(" x", " y"), "3 0 1 2\n");
    assert!(twice.starts_with("a.ply:5: not a PLY: a second property `y` of vertex\n"), "{twice}");
    let end = text(xyz, "3 0 1 2\n").replace("end_header", "end_header\nend_header");
    let end = message(&read(&Ply::default(), "a.ply", end.as_bytes()).unwrap_err());
    assert!(end.contains("a second `end_header`"), "{end}");
}

#[test]
fn stl_facets_are_whole_and_finite() {
    let facet = "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n";
    let error = |text: &str| error(&Stl::default(), "a.stl", text.as_bytes());
    let text = format!("solid a\n{facet}{facet}endsolid a\n");
    assert!(read(&Stl::default(), "a.stl", text.as_bytes()).is_ok());
    let broken = |old: &str, new: &str| error(&format!("solid a\n{facet}{}endsolid a\n", facet.replacen(old, new, 1)));
    assert!(broken("endfacet\n", "").contains("facet 1 (from 0) is not closed"));
    assert!(broken("endloop\n", "").contains("facet 1 (from 0) is not closed"));
    let without = broken("outer loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\n", "");
    assert!(without.contains("facet 1 (from 0) has no loop of three vertices"), "{without}");
    let nan = broken("vertex 1 0 0", "vertex nan 0 0");
    assert!(nan.starts_with("a.stl:12: facet 1 (from 0) has the coordinate `nan`: expected finite"), "{nan}");
    assert!(error(&format!("solid a\n{facet}facet normal 0 0 1\nouter loop\n")).contains("the file ends in facet 1"));
    assert!(error(&format!("mesh {}", "x".repeat(200))).contains("text that does not begin with `solid`"));
    assert!(
        error(&format!("solid {}", "x".repeat(200))).contains("begins with `solid` as text does, and has no facet")
    );
    let mut binary = [&[b' '; 80][..], &1_u32.to_le_bytes(), &[0; 50]].concat();
    binary[100..104].copy_from_slice(&f32::NAN.to_le_bytes());
    let nan = message(&read(&Stl::default(), "a.stl", &binary).unwrap_err());
    assert!(nan.starts_with("a.stl: facet 0 (from 0) has the coordinate NaN: expected finite numbers\n"), "{nan}");
}

#[test]
fn off_counts_and_numbers_are_checked() {
    let text = "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    let more = read(&Off::default(), "a.off", format!("{text}3 2 1 0\n").as_bytes()).unwrap().warnings;
    assert_eq!(more.len(), 1);
    assert!(more[0].starts_with("the file goes on after the 1 faces that its header counts (line 7: `3`)"), "{more:?}");
    let nan = error(&Off::default(), "a.off", text.replace("1 0 0", "nan 0 0").as_bytes());
    assert!(nan.starts_with("a.off:4: not an OFF: `nan` of vertex 1 (from 0) is no finite number\n"), "{nan}");
}

#[test]
fn point_caches_are_as_long_as_their_headers_say_and_finite() {
    let pc2 = |x: f32, more: usize| {
        let numbers = [x, 0.0, 0.0].map(f32::to_le_bytes).concat();
        let words =
            [1_i32.to_le_bytes(), 1_i32.to_le_bytes(), 0_f32.to_le_bytes(), 1_f32.to_le_bytes(), 1_i32.to_le_bytes()];
        [&b"POINTCACHE2\0"[..], &words.concat(), &numbers, &vec![0; more]].concat()
    };
    let told = read(&Pc2::default(), "a.pc2", &pc2(1.0, 12)).unwrap().warnings;
    assert_eq!(told.len(), 1);
    assert!(told[0].starts_with("12 bytes after the last sample are not read"), "{told:?}");
    let nan = error(&Pc2::default(), "a.pc2", &pc2(f32::NAN, 0));
    let expected = "a.pc2: sample 0 (from 0): vertex 0 (from 0) has coordinates NaN 0 0: expected finite numbers\n";
    assert!(nan.starts_with(expected), "{nan}");
    let counts = [2_i32, 1].map(i32::to_be_bytes).concat();
    let mdd = [&counts[..], &[1_f32, 0.5].map(f32::to_be_bytes).concat(), &[0; 24]].concat();
    let told = read(&Mdd::default(), "a.mdd", &mdd).unwrap().warnings;
    assert_eq!(told, ["the times of the frames do not ascend: they are read as 24 frames a second"]);
}

/// The warnings about [`strip`] after a change of its JSON.
fn told(change: impl FnOnce(&mut File)) -> Vec<String> {
    let mut file = strip();
    change(&mut file);
    file.read().unwrap().warnings
}

#[test]
fn a_sound_gltf_has_no_warnings() {
    assert_eq!(told(|_| ()), [""; 0]);
}

#[test]
fn what_a_gltf_cannot_mean_is_told() {
    let set = |path: &'static str, value: Value| move |file: &mut File| *file.json.pointer_mut(path).unwrap() = value;
    let key = |path: &'static str, key: &'static str, value: Value| {
        move |file: &mut File| file.json.pointer_mut(path).unwrap()[key] = value
    };
    let cases = [
        (
            told(key("/nodes/2", "rotation", json!([0, 0, 0, 0]))),
            "nodes whose rotation has no length are not rotated: `lower`",
        ),
        (told(key("/nodes/1", "skin", json!(7))), "nodes that name a skin which the file does not have: `armature`"),
        (
            told(key("/bufferViews/0", "byteStride", json!(0))),
            "buffer views with a `byteStride` of 0 are read as without gaps: `0`",
        ),
        (
            told(key("/bufferViews/0", "byteOffset", json!(-4))),
            "buffer views with a negative `byteOffset` are read from their start: `0`",
        ),
        (
            told(|file| {
                let corners: Vec<[f64; 1]> = [0., 1., 3.].map(|x| [x]).to_vec();
                let floats = file.floats(&corners);
                set("/meshes/0/primitives/0/indices", json!(floats))(file);
            }),
            "meshes whose indices are floats, which glTF does not allow: `skinned`",
        ),
        (
            told(|file| {
                let weights = file.floats(&[[0.25, 0.25, 0., 0.]; 6]);
                set("/meshes/0/primitives/0/attributes/WEIGHTS_0", json!(weights))(file);
            }),
            "the weights of joints at 6 vertices are negative or do not sum to 1: they are divided by their sum",
        ),
        (
            told(|file| {
                let flat = file.floats(&[[0.0; 16], support::gltf::translation(0., -1., 0.)]);
                set("/skins/0/inverseBindMatrices", json!(flat))(file);
            }),
            "joints whose inverse bind matrix is singular: `lower`",
        ),
        (
            told(|file| {
                let output = file.floats(&[[0., 0., 0.], [1., 0., 0.]]);
                file.clip("still", 2, "translation", "LINEAR", &[1.0, 1.0], output);
            }),
            "the clip `still` has no length: all its keys are at 1 s",
        ),
    ];
    for (warnings, expected) in cases {
        assert_eq!(warnings, [expected]);
    }
}
