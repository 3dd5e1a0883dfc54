//! A skinned, animated glTF: a square tube of two bones that bends at its elbow.

use std::fs;

use serde_json::{Value, json};

use super::Project;

/// The rings of the tube, at y = 0, 0.5, 1, 1.5, 2; those above 1 hang on the second bone.
pub const RINGS: usize = 5;

/// The corners of the tube at rest, ring by ring.
pub fn corners() -> Vec<[f32; 3]> {
    let ring = |k: usize| [[0.2, -0.2], [0.2, 0.2], [-0.2, 0.2], [-0.2, -0.2]].map(|[x, z]| [x, 0.5 * k as f32, z]);
    (0..RINGS).flat_map(ring).collect()
}

/// Where a corner is when the elbow, at (0, 1, 0), is bent by `degrees` about z.
pub fn bent([x, y, z]: [f32; 3], degrees: f64) -> [f64; 3] {
    let [x, y, z] = [x, y, z].map(f64::from);
    if y <= 1.0 {
        return [x, y, z];
    }
    let (sin, cos) = degrees.to_radians().sin_cos();
    [cos * x - sin * (y - 1.0), 1.0 + sin * x + cos * (y - 1.0), z]
}

/// Writes `arm.gltf` and `arm.bin`: the mesh `arm`, the clip `Bend` that bends the elbow by 90° in a second, an image, a second set
/// of texture coordinates, and an extension that nobody knows.
pub fn write(project: &Project) {
    let json = json(project);
    project.write("arm.gltf", &json.to_string());
}

/// The JSON of `arm.gltf`, after `arm.bin` and `skin.png` are written.
pub fn json(project: &Project) -> Value {
    let corners = corners();
    let mut bytes = Bytes::default();
    let positions = bytes.floats("VEC3", corners.iter().flatten().copied());
    let uvs = bytes.floats("VEC2", corners.iter().flat_map(|[x, y, _]| [*x, *y]));
    let joints = bytes.accessor(
        "VEC4",
        5121,
        corners.len(),
        corners.iter().flat_map(|c| [u8::from(c[1] > 1.0), 0, 0, 0]).collect(),
    );
    let weights = bytes.floats("VEC4", corners.iter().flat_map(|_| [1.0, 0.0, 0.0, 0.0]));
    let indices: Vec<u16> = triangles().into_iter().flatten().collect();
    let indices = bytes.accessor("SCALAR", 5123, indices.len(), indices.iter().flat_map(|i| i.to_le_bytes()).collect());
    let identity = |y: f32| [1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1., 0., 0., y, 0., 1.];
    let bind = bytes.floats("MAT4", [identity(0.0), identity(-1.0)].into_iter().flatten());
    let times = bytes.floats("SCALAR", [0.0, 1.0]);
    let half = std::f32::consts::FRAC_PI_4;
    let turns = bytes.floats("VEC4", [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, half.sin(), half.cos()]);
    fs::write(project.path("arm.bin"), &bytes.data).expect("a file");
    // The smallest PNG: one pixel. Nothing decodes it here.
    fs::write(project.path("skin.png"), b"\x89PNG\r\n\x1a\n pixels").expect("a file");
    json!({
        "asset": { "version": "2.0" },
        "extensionsUsed": ["EXT_of_nobody"],
        "extensions": { "EXT_of_nobody": { "kept": [1, 2.5, "x"] } },
        "scene": 0,
        "scenes": [{ "nodes": [0, 1] }],
        "nodes": [
            { "name": "arm", "mesh": 0, "skin": 0, "translation": [5, 6, 7] },
            { "name": "shoulder", "children": [2] },
            { "name": "elbow", "translation": [0, 1, 0] },
        ],
        "meshes": [{ "name": "arm", "primitives": [{
            "attributes": { "POSITION": positions, "TEXCOORD_0": uvs, "TEXCOORD_1": uvs, "JOINTS_0": joints, "WEIGHTS_0": weights },
            "indices": indices, "material": 0,
        }] }],
        "materials": [{ "name": "skin", "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 }, "roughnessFactor": 0.25 } }],
        "textures": [{ "source": 0 }],
        "images": [{ "uri": "skin.png" }],
        "skins": [{ "joints": [1, 2], "inverseBindMatrices": bind }],
        "animations": [{ "name": "Bend",
            "samplers": [{ "input": times, "output": turns }],
            "channels": [{ "sampler": 0, "target": { "node": 2, "path": "rotation" } }],
        }],
        "buffers": [{ "uri": "arm.bin", "byteLength": bytes.data.len() }],
        "bufferViews": bytes.views,
        "accessors": bytes.accessors,
    })
}

/// The sides of the tube and its two ends, outwards.
pub fn triangles() -> Vec<[u16; 3]> {
    let mut triangles = vec![[0, 1, 2], [0, 2, 3]];
    for ring in 0..RINGS as u16 - 1 {
        for side in 0..4 {
            let [a, b] = [4 * ring + side, 4 * ring + (side + 1) % 4];
            triangles.extend([[a, a + 4, b + 4], [a, b + 4, b]]);
        }
    }
    let top = 4 * (RINGS as u16 - 1);
    triangles.extend([[top, top + 2, top + 1], [top, top + 3, top + 2]]);
    triangles
}

/// The JSON of a GLB.
#[track_caller]
pub fn json_of_glb(bytes: &[u8]) -> Value {
    assert_eq!(&bytes[..4], b"glTF");
    let length = u32::from_le_bytes(bytes[12..16].try_into().expect("four bytes")) as usize;
    serde_json::from_slice(&bytes[20..20 + length]).expect("JSON")
}

/// A buffer in the making.
#[derive(Default)]
struct Bytes {
    data: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Bytes {
    fn floats(&mut self, kind: &str, values: impl IntoIterator<Item = f32>) -> usize {
        let values: Vec<f32> = values.into_iter().collect();
        let width = match kind {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            "VEC4" => 4,
            _ => 16,
        };
        let index =
            self.accessor(kind, 5126, values.len() / width, values.iter().flat_map(|x| x.to_le_bytes()).collect());
        if kind != "MAT4" {
            let bound = |choose: fn(f32, f32) -> f32| -> Vec<f32> {
                (0..width)
                    .map(|i| values.iter().skip(i).step_by(width).copied().reduce(choose).expect("a value"))
                    .collect()
            };
            self.accessors[index]["min"] = json!(bound(f32::min));
            self.accessors[index]["max"] = json!(bound(f32::max));
        }
        index
    }

    fn accessor(&mut self, kind: &str, component: u32, count: usize, bytes: Vec<u8>) -> usize {
        self.views.push(json!({ "buffer": 0, "byteOffset": self.data.len(), "byteLength": bytes.len() }));
        self.data.extend(bytes);
        self.data.resize(self.data.len().next_multiple_of(4), 0);
        let view = self.views.len() - 1;
        self.accessors.push(json!({ "bufferView": view, "componentType": component, "count": count, "type": kind }));
        self.accessors.len() - 1
    }
}
