//! glTF: compressed files hold the meshes that were compressed.

mod support;

use base64::{Engine, engine::general_purpose::STANDARD};
use draco_core::{
    DataType, EncoderBuffer, EncoderOptions, FaceIndex, GeometryAttributeType, Mesh as Draco, MeshEncoder,
    PointAttribute, PointIndex,
};
use meshopt::{encode_filter_exp, encode_index_buffer, encode_index_sequence, encode_vertex_buffer};
use mimesh_core::mesh::Mesh;
use nalgebra::Point3;
use proptest::prelude::*;
use serde_json::json;
use support::{distance, gltf::File, grid};

/// The triangles of a grid.
fn flat() -> (Vec<[f32; 3]>, Vec<u32>) {
    let mesh = grid(8);
    let triangles =
        mesh.polygons.iter().flat_map(|quad| [quad[0], quad[1], quad[2], quad[0], quad[2], quad[3]]).collect();
    (mesh.positions.iter().map(|p| [p.x as f32, p.y as f32, p.z as f32]).collect(), triangles)
}

fn expected() -> Mesh {
    let (positions, triangles) = flat();
    let positions = positions.iter().map(|p| Point3::new(f64::from(p[0]), f64::from(p[1]), f64::from(p[2]))).collect();
    Mesh::from_triangles(positions, triangles.as_chunks().0)
}

/// A file whose two views are compressed in one buffer and have another, without data, to fall back on.
fn by_meshopt(positions: &[u8], filter: &str, indices: &[u8], mode: &str, extension: &str) -> File {
    let (vertices, corners) = (flat().0.len(), flat().1.len());
    let mut file = File::new();
    let bytes = [positions, indices].concat();
    let of = |offset: usize, length: usize, stride: usize, count: usize, mode: &str, filter: &str| {
        json!({
            "buffer": 1, "byteLength": stride * count, "byteOffset": if mode == "ATTRIBUTES" { 0 } else { 12 * vertices },
            "extensions": { extension: {
                "buffer": 0, "byteOffset": offset, "byteLength": length, "byteStride": stride, "count": count,
                "mode": mode, "filter": filter,
            } },
        })
    };
    file.push("bufferViews", of(0, positions.len(), 12, vertices, "ATTRIBUTES", filter));
    file.push("bufferViews", of(positions.len(), indices.len(), 4, corners, mode, "NONE"));
    file.push("accessors", json!({ "bufferView": 0, "componentType": 5126, "count": vertices, "type": "VEC3" }));
    file.push("accessors", json!({ "bufferView": 1, "componentType": 5125, "count": corners, "type": "SCALAR" }));
    file.push("meshes", json!({ "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1 }] }));
    file.push("nodes", json!({ "mesh": 0 }));
    let uri = format!("data:application/octet-stream;base64,{}", STANDARD.encode(&bytes));
    file.json["buffers"] =
        json!([{ "byteLength": bytes.len(), "uri": uri }, { "byteLength": 12 * vertices + 4 * corners }]);
    file.json["extensionsRequired"] = json!([extension]);
    file
}

#[test]
fn meshopt_is_undone() {
    let (positions, triangles) = flat();
    let vertices = encode_vertex_buffer(&positions).unwrap();
    let buffer = encode_index_buffer(&triangles, positions.len()).unwrap();
    let sequence = encode_index_sequence(&triangles, positions.len()).unwrap();
    for extension in ["EXT_meshopt_compression", "KHR_meshopt_compression"] {
        let mesh = by_meshopt(&vertices, "NONE", &sequence, "INDICES", extension).read().unwrap().rest;
        assert_eq!((mesh.positions, mesh.polygons), (expected().positions, expected().polygons));
    }
    // This codec may turn the corners of a triangle.
    let mesh = by_meshopt(&vertices, "NONE", &buffer, "TRIANGLES", "EXT_meshopt_compression").read().unwrap().rest;
    let sorted = |mesh: &Mesh| {
        let turned = |triangle: &[u32]| {
            let mut triangle = triangle.to_vec();
            let first = (0..3).min_by_key(|&i| triangle[i]).unwrap();
            triangle.rotate_left(first);
            triangle
        };
        mesh.polygons.iter().map(turned).collect::<Vec<_>>()
    };
    assert_eq!((sorted(&mesh), mesh.positions), (sorted(&expected()), expected().positions));
}

#[test]
fn filters_of_meshopt_are_undone() {
    let (positions, triangles) = flat();
    let filtered = encode_filter_exp(&positions, 20, meshopt::EncodeExpMode::Separate);
    let vertices = encode_vertex_buffer(&filtered).unwrap();
    let indices = encode_index_sequence(&triangles, positions.len()).unwrap();
    let mesh =
        by_meshopt(&vertices, "EXPONENTIAL", &indices, "INDICES", "EXT_meshopt_compression").read().unwrap().rest;
    // 20 bits of a number up to 1.
    assert!(distance(&mesh.positions, &expected().positions) < 2_f64.powi(-18));
}

#[test]
fn damaged_meshopt_is_named() {
    let (positions, triangles) = flat();
    let vertices = encode_vertex_buffer(&positions).unwrap();
    let indices = encode_index_sequence(&triangles, positions.len()).unwrap();
    let file = by_meshopt(&vertices[..40], "NONE", &indices, "INDICES", "EXT_meshopt_compression");
    let error = file.read().unwrap_err().to_string();
    assert!(error.starts_with("a.gltf: buffer view 0 cannot be decoded by EXT_meshopt_compression: "), "{error}");
    let mut file = by_meshopt(&vertices, "NONE", &indices, "INDICES", "EXT_meshopt_compression");
    file.json["bufferViews"][0]["extensions"]["EXT_meshopt_compression"]["count"] = json!(1_000_000_000_u64);
    let error = file.read().unwrap_err().to_string();
    assert!(error.contains("1000000000 entries of 12 bytes do not fit in"), "{error}");
}

fn draco_bytes() -> Vec<u8> {
    let (positions, triangles) = flat();
    let mut mesh = Draco::new();
    mesh.set_num_points(positions.len());
    mesh.set_num_faces(triangles.len() / 3);
    for (face, corners) in triangles.as_chunks::<3>().0.iter().enumerate() {
        mesh.set_face(FaceIndex(face as u32), corners.map(PointIndex));
    }
    let mut attribute = PointAttribute::new();
    attribute.init(GeometryAttributeType::Position, 3, DataType::Float32, false, positions.len());
    let bytes: Vec<u8> = positions.as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect();
    attribute.buffer_mut().write(0, &bytes);
    mesh.add_attribute(attribute);
    let mut encoder = MeshEncoder::new();
    encoder.set_mesh(mesh);
    let mut buffer = EncoderBuffer::new();
    let mut options = EncoderOptions::default();
    // Sequential, so that the order of vertices stays.
    options.set_encoding_method(0);
    encoder.encode(&options, &mut buffer).unwrap();
    buffer.data().to_vec()
}

fn by_draco(bytes: &[u8]) -> File {
    let mut file = File::new();
    let view = file.view(bytes);
    file.push("accessors", json!({ "componentType": 5126, "count": flat().0.len(), "type": "VEC3" }));
    file.push("accessors", json!({ "componentType": 5123, "count": flat().1.len(), "type": "SCALAR" }));
    let extension = json!({ "KHR_draco_mesh_compression": { "bufferView": view, "attributes": { "POSITION": 0 } } });
    let primitive = json!({ "attributes": { "POSITION": 0 }, "indices": 1, "extensions": extension });
    file.push("meshes", json!({ "name": "body", "primitives": [primitive] }));
    file.push("nodes", json!({ "mesh": 0 }));
    file
}

#[test]
fn draco_is_undone() {
    let mesh = by_draco(&draco_bytes()).read().unwrap().rest;
    assert_eq!(mesh.polygons, expected().polygons);
    // The encoder stores positions in steps; 11 bits of the diagonal are its coarsest default.
    assert!(distance(&mesh.positions, &expected().positions) < 2_f64.powi(-10));
}

#[test]
fn data_beside_draco_are_read_in_its_place() {
    let mut file = by_draco(b"nothing");
    let (positions, triangles) = flat();
    let bytes: Vec<u8> = positions.as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect();
    let indices: Vec<u8> = triangles.iter().flat_map(|&corner| (corner as u16).to_le_bytes()).collect();
    let (position, index) = (file.view(&bytes), file.view(&indices));
    file.json["accessors"][0]["bufferView"] = position.into();
    file.json["accessors"][1]["bufferView"] = index.into();
    assert_eq!(file.read().unwrap().rest.positions, expected().positions);
}

#[test]
fn damaged_draco_is_named() {
    let error = by_draco(b"nothing of use").read().unwrap_err().to_string();
    let place =
        "a.gltf: mesh `body`, primitive 0 is compressed with KHR_draco_mesh_compression and cannot be decoded: ";
    assert!(error.starts_with(place), "{error}");
    let mut file = by_draco(&draco_bytes());
    file.json["accessors"][0]["count"] = 63.into();
    assert!(file.read().unwrap_err().to_string().starts_with(place));
}

proptest! {
    #[test]
    fn no_damage_makes_a_decoder_panic(edits in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6)) {
        let damaged = |mut bytes: Vec<u8>| {
            edits.iter().for_each(|(at, byte)| { let at = at.index(bytes.len()); bytes[at] = *byte; });
            bytes
        };
        let (positions, triangles) = flat();
        let vertices = damaged(encode_vertex_buffer(&positions).unwrap());
        let sequence = damaged(encode_index_sequence(&triangles, positions.len()).unwrap());
        let buffer = damaged(encode_index_buffer(&triangles, positions.len()).unwrap());
        for (indices, mode) in [(sequence, "INDICES"), (buffer, "TRIANGLES")] {
            for filter in ["NONE", "EXPONENTIAL"] {
                if let Ok(sequence) = by_meshopt(&vertices, filter, &indices, mode, "EXT_meshopt_compression").read() {
                    sequence.rest.validate().unwrap();
                }
            }
        }
        if let Ok(sequence) = by_draco(&damaged(draco_bytes())).read() {
            sequence.rest.validate().unwrap();
        }
    }
}
