//! What cannot be meant is an error that names its place, or a warning.

mod support;

use mimesh_core::stage::{BytesInput, Format, Selection};
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

#[test]
fn lines_words_and_numbers_of_an_obj_that_mean_nothing_are_told() {
    let told = |old: &str, new: &str| {
        let text = format!("{VERTICES}vt 0 0\nvn 0 0 1\nf 1 2 3\n");
        assert!(text.contains(old), "{old}");
        read(&Obj::default(), "a.obj", text.replacen(old, new, 1).as_bytes()).unwrap().warnings
    };
    let cases = [
        (
            "v 0 0 0",
            "v 0 0 0 1 2",
            "1 `v` lines have numbers behind their coordinates that are neither a weight nor a colour",
        ),
        ("v 0 0 0", "v 0 0 0 red 0 0", "1 `v` lines have a colour that is no number, which was read as 1"),
        (
            "f 1 2 3",
            "F 1 2 3\nf 1 2 3",
            "lines that begin with no word of an OBJ are not read: 1, the first `F` (line 6)",
        ),
        (
            "f 1 2 3",
            "f 1/0 2/0 3/0",
            "3 corners refer to texture coordinate or normal 0, where numbers start at 1: they have none",
        ),
    ];
    for (old, new, expected) in cases {
        assert_eq!(told(old, new), [expected]);
    }
    assert_eq!(told("f 1 2 3\n", "f 1 2 3\n\0\0\0"), [""; 0]);
    let latin = [VERTICES.as_bytes(), b"mtllib gr\xf6n.mtl\nf 1 2 3\n"].concat();
    let told = read(&Obj::default(), "a.obj", &latin).unwrap().warnings;
    assert!(told[0].starts_with("`mtllib` names files in another encoding than UTF-8"), "{told:?}");
}

#[test]
fn material_libraries_with_short_colours_are_told() {
    for (library, expected) in [
        ("newmtl a\nKd 1\n", "has no colour of three finite numbers in line 2: `Kd 1`"),
        ("newmtl a\nKd nan 0 0\n", "has no colour of three finite numbers in line 2"),
        ("nothing\n", "has no material"),
    ] {
        let text = format!("{VERTICES}mtllib a.mtl\nusemtl a\nf 1 2 3\n");
        let others = [("a.mtl".to_owned(), library.as_bytes().to_vec())].into();
        let input = BytesInput { others, ..BytesInput::new("a.obj", text) };
        let told = Obj::default().read(&input, &Selection::default()).unwrap().warnings;
        assert!(told.len() == 1 && told[0].contains(expected), "{told:?}");
    }
}

#[test]
fn ply_headers_say_what_they_can_mean() {
    let xyz = "property float x\nproperty float y\nproperty float z";
    let text = format!(
        "ply\nformat ascii 1.0\nelement vertex 3\n{xyz}\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n\
        0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"
    );
    let with = |old: &str, new: &str| read(&Ply::default(), "a.ply", text.replacen(old, new, 1).as_bytes());
    let error = |old, new| message(&with(old, new).unwrap_err());
    assert!(error("ascii 1.0", "ascii 2.0").starts_with("a.ply:2: not a PLY: version `2.0`, expected 1.0"));
    assert!(error("ascii 1.0", "ascii 1.0\nformat ascii 1.0").starts_with("a.ply:3: not a PLY: a second `format`"));
    let twice = "vertex_indices\nproperty list uchar int vertex_index";
    assert!(error("vertex_indices", twice).starts_with("a.ply:9: not a PLY: a second property `vertex_index` of face"));
    for kinds in ["float int", "uchar float"] {
        let told = with("uchar int", kinds).unwrap().warnings;
        let expected =
            "lists of face whose lengths or vertices are `float`, where whole numbers belong: `vertex_indices`";
        assert_eq!(told, [expected]);
    }
    let normals = format!("{xyz}\nproperty float nx\nproperty float ny\nproperty float nz");
    for number in ["nan", "inf", "1e308"] {
        let vertices = format!("0 0 0 {number} 0 1 1 0 0 0 0 1 0 1 0 0 0 1");
        let rows = text.replacen(xyz, &normals, 1).replace("0 0 0\n1 0 0\n0 1 0", &vertices);
        let told = read(&Ply::default(), "a.ply", rows.as_bytes()).unwrap().warnings;
        assert_eq!(told, ["1 texture coordinates or normals are not finite numbers and were read as 0"], "{number}");
    }
}

#[test]
fn stl_words_that_mean_nothing_are_told() {
    let facet = "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n";
    let text = format!("solid a\n{facet}endsolid a\n");
    let told = |text: &str| read(&Stl::default(), "a.stl", text.as_bytes()).unwrap().warnings;
    assert_eq!(told(&text), [""; 0]);
    assert_eq!(told(&text.repeat(2)), ["the file has 2 solids: they are read as one mesh"]);
    let open = text.replace("endsolid a\n", "") + &text;
    assert!(told(&open).contains(&"solids without an `endsolid` before the next: 1".to_owned()));
    let behind = told(&format!("{text}{facet}"));
    assert_eq!(behind, ["facets behind `endsolid`, which stand in no solid, are read too: 1"]);
    let four = told(&text.replacen("vertex 0 0 0", "vertex 0 0 0 7", 1));
    assert_eq!(four, ["words that have no place in an STL are skipped: 1, the first `7` in line 4"]);
    let error = |text: &str| error(&Stl::default(), "a.stl", text.as_bytes());
    assert!(error(&text.replace("facet normal 0 0 1\n", "")).contains("a loop outside of a facet"));
    let looped = "endloop\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 1\nendloop\n";
    assert!(error(&text.replacen("endloop\n", looped, 1)).contains("facet 0 (from 0) has two loops"));
}

#[test]
fn off_words_that_mean_nothing_are_told() {
    let text = "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    let told =
        |old: &str, new: &str| read(&Off::default(), "a.off", text.replacen(old, new, 1).as_bytes()).unwrap().warnings;
    let unreadable = ["1 colours or texture coordinates are not finite numbers and were read as 0"];
    let unknown = ["1 lines have numbers at their end that are no colour, and are not read"];
    assert_eq!(told("3 0 1 2", "3 0 1 2 red 0 0"), unreadable);
    assert_eq!(told("1 0 0", "1 0 0 nan 0 0"), unreadable);
    assert_eq!(told("3 0 1 2", "3 0 1 2 7 7"), unknown);
    assert_eq!(told("3 1 0", "3 1 0 9"), unknown);
    assert_eq!(told("3 0 1 2", "3 0 1 2 255 0 0"), [""; 0]);
}

#[test]
fn any_sample_of_a_point_cache_that_is_not_finite_is_told() {
    for wrong in 0..4 {
        let words =
            [1_i32.to_le_bytes(), 1_i32.to_le_bytes(), [0; 4], 1_f32.to_le_bytes(), 4_i32.to_le_bytes()].concat();
        let samples = (0..4).flat_map(|sample| [0.0, if sample == wrong { f32::INFINITY } else { 1.0 }, 0.0]);
        let bytes = [&b"POINTCACHE2\0"[..], &words, &samples.flat_map(f32::to_le_bytes).collect::<Vec<_>>()].concat();
        let found = read(&Pc2::default(), "a.pc2", &bytes);
        // The first is the rest too, which must be read.
        let text = found.map_or_else(|error| message(&error), |sequence| sequence.warnings.join("\n"));
        let expected = match wrong {
            0 => "sample 0 (from 0): ".to_owned(),
            other => format!("not finite, which cannot be read: 1, the first {other} (from 0)"),
        };
        assert!(text.contains(&expected), "{text}");
    }
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
            told(key("/nodes/3", "rotation", json!([0, 0, 0, 5]))),
            "nodes whose rotation is no unit quaternion are rotated by its direction: `upper`",
        ),
        (
            told(key("/nodes/1", "matrix", json!([1, 0, 0, 0.5, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]))),
            "nodes whose matrix ends in another row than 0 0 0 1, which is left out: `armature`",
        ),
        (
            told(key("/nodes/3", "matrix", json!([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 1, 0, 1]))),
            "nodes with a matrix beside translation, rotation or scale, of which the matrix counts: `upper`",
        ),
        (
            told(key("/nodes/3", "scale", json!([0, 0, 0]))),
            "joints that flatten what they move, with a scale of 0: `upper`",
        ),
        (told(key("/nodes/2", "name", json!("a\u{0}b"))), "names with characters that no text shows: `a\\0b`"),
        (
            told(|file| {
                let views = file.json["bufferViews"].as_array_mut().unwrap();
                views.push(json!({ "buffer": 0, "byteLength": 12, "byteStride": 13 }));
            }),
            "buffer views with a `byteStride` other than a multiple of 4 up to 252: `5`",
        ),
        (
            told(|file| {
                file.json["bufferViews"].as_array_mut().unwrap().push(json!({ "buffer": 0, "byteLength": 9999 }))
            }),
            "buffer views that reach beyond their buffer: `5`",
        ),
        (told(key("/meshes/0/primitives/0", "material", json!(-1))), "negative numbers stand for none: `material`"),
        (
            told(key("/meshes/0/primitives/0/attributes", "TANGENT", json!(99))),
            "attributes whose accessor the file does not have are left out: `TANGENT of skinned`",
        ),
        (
            told(|file| {
                file.json["meshes"][0]["primitives"][0]["attributes"] = {
                    let mut attributes = file.json["meshes"][0]["primitives"][0]["attributes"].clone();
                    attributes["WEIGHTS_1"] = attributes["WEIGHTS_0"].clone();
                    attributes
                }
            }),
            "meshes with joints without weights, or weights without joints, which are left out: `skinned`",
        ),
        (
            told(|file| {
                let output = file.floats(&[[0.0, 0.0, 0.0]; 3]);
                file.clip("jump", 2, "translation", "LINEAR", &[0.0, 1.0, 1.0], output);
            }),
            "clips that have several keys at one time, and jump there: `jump`",
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
