//! glTF: files are read that break rules without need, and extensions matter only where they change geometry.

mod support;

use mimesh_core::{mesh::MeshSequence, testkit::data::data};
use mimesh_formats::Glb;
use nalgebra::Point3;
use serde_json::{Value, json};
use support::{
    gltf::{File, names, strip},
    message, read_file,
};

fn triangle() -> File {
    let mut file = File::new();
    let position = file.floats(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    file.push("meshes", json!({ "name": "body", "primitives": [{ "attributes": { "POSITION": position } }] }));
    file.push("nodes", json!({ "mesh": 0 }));
    file
}

type Edit = fn(&mut Value);

fn edited(edit: impl Fn(&mut File)) -> Result<MeshSequence, mimesh_core::Error> {
    let mut file = triangle();
    edit(&mut file);
    file.read()
}

#[test]
fn what_does_not_matter_may_be_wrong() {
    let edits: [(&str, Edit); 12] = [
        ("null weights", |json| json["meshes"][0]["weights"] = Value::Null),
        ("null bounds", |json| json["accessors"][0]["min"] = json!([null, "x", 3])),
        ("float counts", |json| json["accessors"][0]["count"] = json!(3.0)),
        ("float lengths", |json| json["bufferViews"][0]["byteLength"] = json!(36.0)),
        ("no material", |json| json["meshes"][0]["primitives"][0]["material"] = json!(-1)),
        ("null children", |json| json["nodes"][0]["children"] = json!([null])),
        ("a number as a name", |json| json["nodes"][0]["name"] = json!(7)),
        ("broken looks", |json| {
            json["materials"] = json!([{ "alphaMode": 3, "pbrMetallicRoughness": "none" }]);
            json["textures"] = json!([{ "source": "a" }]);
            json["images"] = json!([7]);
            json["cameras"] = json!([{}]);
            json["extensions"] = json!({ "VRM": { "meta": null } });
        }),
        ("a camera without use", |json| json["nodes"][0]["camera"] = json!(99)),
        ("lists without entries", |json| {
            json["animations"] = json!([{ "name": "empty" }]);
            json["skins"] = json!([{}]);
        }),
        ("a version with a patch", |json| json["asset"]["version"] = json!("2.0.1")),
        ("a length with padding", |json| json["bufferViews"][0]["byteLength"] = json!(39)),
    ];
    let expected = triangle().read().unwrap().rest;
    for (case, edit) in edits {
        let sequence = edited(|file| edit(&mut file.json)).unwrap_or_else(|error| panic!("{case}: {error}"));
        assert_eq!(sequence.rest.positions, expected.positions, "{case}");
        assert_eq!(sequence.rest.polygons, expected.polygons, "{case}");
    }
}

#[test]
fn missing_scenes_show_all_nodes() {
    let sequence = edited(|file| drop(file.json.as_object_mut().unwrap().remove("scenes"))).unwrap();
    assert_eq!(sequence.rest.positions.len(), 3);
}

#[test]
fn bare_words_in_the_json_do_not_matter() {
    let text = String::from_utf8(triangle().text()).unwrap();
    let text = text.replace(r#""count":3"#, r#""count":3,"max":[NaN,Infinity,-Infinity]"#);
    assert!(text.contains("NaN"));
    assert!(support::read(&Glb::default(), "a.gltf", text.as_bytes()).is_ok());
}

#[test]
fn required_extensions_count_where_geometry_uses_them() {
    let requires = |names: &[&str], edit: Edit| {
        edited(|file| {
            file.json["extensionsRequired"] = json!(names);
            edit(&mut file.json);
        })
    };
    // Nothing uses it, or looks do.
    for name in ["ACME_magic", "KHR_node_visibility", "KHR_materials_unlit", "VRMC_vrm", "KHR_draco_mesh_compression"] {
        let sequence = requires(&[name], |json| json["materials"] = json!([{ "extensions": { "ACME_magic": {} } }]));
        assert_eq!(sequence.unwrap().warnings, Vec::<String>::new(), "{name}");
    }
    let nodes = requires(&["ACME_magic", "KHR_lights_punctual"], |json| {
        json["nodes"][0]["extensions"] =
            json!({ "ACME_magic": {}, "KHR_lights_punctual": {}, "EXT_mesh_gpu_instancing": {} });
    });
    let expected = "extensions of nodes are not followed: `ACME_magic`, `EXT_mesh_gpu_instancing`";
    assert_eq!(nodes.unwrap().warnings, [expected]);
    let places: [Edit; 3] = [
        |json| json["meshes"][0]["primitives"][0]["extensions"] = json!({ "ACME_magic": {} }),
        |json| json["accessors"][0]["extensions"] = json!({ "ACME_magic": {} }),
        |json| json["bufferViews"][0]["extensions"] = json!({ "ACME_magic": {} }),
    ];
    for place in places {
        let expected = "a.gltf: mesh `body`, primitive 0 requires the extension ACME_magic, which is not supported\n\
                        export it without the extension";
        assert_eq!(message(&requires(&["ACME_magic"], place).unwrap_err()), expected);
        assert!(requires(&[], place).is_ok());
    }
}

#[test]
fn a_compressed_primitive_without_data_is_no_mesh_of_zeros() {
    let error = edited(|file| {
        file.json["accessors"][0].as_object_mut().unwrap().remove("bufferView");
        file.json["meshes"][0]["primitives"][0]["extensions"] = json!({ "ACME_zip": {} });
    });
    let text = message(&error.unwrap_err());
    let expected =
        "a.gltf: mesh `body`, primitive 0 is compressed with ACME_zip, which is not supported\nexport it without";
    assert!(text.starts_with(expected), "{text}");
}

/// What reports of others' troubles hold, with the right answer of each.
#[test]
fn small_files_of_reports_are_read() {
    let read = |name: &str| data(&format!("reports/{name}")).map(|path| read_file(&Glb::default(), &path));
    for name in ["g_jsonnull.glb", "g_jsonnan.glb", "g_req_nodevis.glb", "g_ok.vrm", "g_ok.glb"] {
        let Some(sequence) = read(name) else { return };
        assert_eq!((sequence.rest.positions.len(), sequence.poses.len()), (384, 2), "{name}");
        assert_eq!(sequence.warnings, Vec::<String>::new(), "{name}");
    }
    let poses = |name| names(&read(name).unwrap()).into_iter().map(str::to_owned).collect::<Vec<_>>();
    assert_eq!(poses("g_prim_names.glb"), ["vrc.v_aa", "vrc.blink_L"]);
    assert_eq!(poses("g_two_unnamed.glb").len(), 2);
    assert!(poses("g_two_unnamed.glb").iter().all(|name| name.ends_with("-target-0")));
    let warnings = read("g_nodeweights.glb").unwrap().warnings;
    assert_eq!(warnings, ["the rest pose has all morph targets at 0, unlike the file's default: `body`"]);
    // The eye is a blob about the place where its joint puts it.
    let eyes = read("g_skin_two.glb").unwrap().rest;
    let eye = eyes.parts.last().unwrap();
    let corners = &eyes.polygons.corners()[3 * eye.polygons.start..3 * eye.polygons.end];
    let positions: Vec<Point3<f64>> = corners.iter().map(|&v| eyes.positions[v as usize]).collect();
    let (low, high) = mimesh_core::mesh::bounding_box(&positions);
    let centre = nalgebra::center(&low, &high);
    assert!((centre - Point3::new(0.3, 1.0, 0.9)).norm() < 0.1, "{centre}");
    let path = data("reports/g_draco_used.glb").unwrap();
    let bytes = std::fs::read(path).unwrap();
    let error = message(&support::read(&Glb::default(), "g_draco_used.glb", &bytes).unwrap_err());
    assert!(error.contains("KHR_draco_mesh_compression") && error.contains("gltf-transform"), "{error}");
}

#[test]
fn a_glb_may_count_what_is_not_there() {
    let file = strip();
    let mut json = file.json.clone();
    json["buffers"] = json!([{ "byteLength": file.bytes.len() }]);
    let mut json = json.to_string().into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let glb = |header: usize, chunk: usize, bytes: &[u8]| {
        let number = |n: usize| (n as u32).to_le_bytes();
        let head = [&b"glTF"[..], &number(2), &number(header), &number(json.len()), b"JSON", &json];
        [&head.concat()[..], &number(chunk), b"BIN\0", bytes].concat()
    };
    let (bytes, length) = (&file.bytes[..], file.bytes.len());
    let total = 28 + json.len() + length;
    let read = |glb: Vec<u8>| support::read(&Glb::default(), "a.glb", &glb);
    let expected = file.read().unwrap().rest.positions;
    // A header that counts more, a chunk that counts its padding, and bytes after the end.
    for glb in [
        glb(total + 99, length, bytes),
        glb(total, length + 3, bytes),
        [glb(total, length, bytes), vec![1; 50]].concat(),
    ] {
        assert_eq!(read(glb).unwrap().rest.positions, expected);
    }
    let cut = read(glb(total, length, &bytes[..length - 1])).unwrap_err().to_string();
    assert!(cut.starts_with("a.glb: buffer 0 is cut short: expected"), "{cut}");
    let cut = read(glb(total, length, &bytes[..length - 4])).unwrap_err().to_string();
    assert!(cut.starts_with("a.glb: GLB is cut short: a chunk of"), "{cut}");
}
