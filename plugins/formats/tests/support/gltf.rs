//! glTF files put together in tests.

use base64::{Engine, engine::general_purpose::STANDARD};
use mimesh_core::{
    Error,
    mesh::MeshSequence,
    stage::{BytesInput, ClipChoice, ClipTimes, Format, PoseChoice, Selection},
};
use mimesh_formats::Gltf;
use nalgebra::Point3;
use serde_json::{Value, json};

/// A file in the making: its JSON, and the one buffer.
#[derive(Clone)]
pub struct File {
    pub json: Value,
    pub bytes: Vec<u8>,
}

impl File {
    /// A file with nothing in it but a scene of node 0.
    pub fn new() -> Self {
        let json = json!({
            "asset": { "version": "2.0" },
            "accessors": [], "bufferViews": [], "nodes": [], "meshes": [],
            "scenes": [{ "nodes": [0] }],
        });
        Self { json, bytes: Vec::new() }
    }

    /// Adds a buffer view of `bytes`; its number.
    pub fn view(&mut self, bytes: &[u8]) -> usize {
        let offset = self.bytes.len();
        self.bytes.extend_from_slice(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let view = json!({ "buffer": 0, "byteOffset": offset, "byteLength": bytes.len() });
        self.push("bufferViews", view)
    }

    /// Adds an accessor of `bytes`; its number.
    pub fn accessor(&mut self, kind: &str, component_type: u32, count: usize, bytes: &[u8]) -> usize {
        let view = self.view(bytes);
        let accessor = json!({ "bufferView": view, "componentType": component_type, "count": count, "type": kind });
        self.push("accessors", accessor)
    }

    /// Adds an accessor of floats; its number.
    pub fn floats<const N: usize>(&mut self, values: &[[f64; N]]) -> usize {
        let kind = match N {
            1 => "SCALAR",
            3 => "VEC3",
            4 => "VEC4",
            _ => "MAT4",
        };
        let bytes: Vec<u8> = values.as_flattened().iter().flat_map(|&x| (x as f32).to_le_bytes()).collect();
        self.accessor(kind, 5126, values.len(), &bytes)
    }

    /// Adds an accessor of vectors of four bytes; its number.
    pub fn bytes4(&mut self, values: &[[u8; 4]]) -> usize {
        self.accessor("VEC4", 5121, values.len(), values.as_flattened())
    }

    /// Adds `value` to a list of the root; its number.
    pub fn push(&mut self, list: &str, value: Value) -> usize {
        if self.json[list].is_null() {
            self.json[list] = json!([]);
        }
        let list = self.json[list].as_array_mut().unwrap();
        list.push(value);
        list.len() - 1
    }

    /// Adds an animation called `name` that moves `path` of `node`; its number.
    pub fn clip(
        &mut self,
        name: &str,
        node: usize,
        path: &str,
        interpolation: &str,
        times: &[f64],
        output: usize,
    ) -> usize {
        let times: Vec<[f64; 1]> = times.iter().map(|&time| [time]).collect();
        let input = self.floats(&times);
        self.push(
            "animations",
            json!({
                "name": name,
                "channels": [{ "sampler": 0, "target": { "node": node, "path": path } }],
                "samplers": [{ "input": input, "output": output, "interpolation": interpolation }],
            }),
        )
    }

    /// The file as text with its buffer inside.
    pub fn text(&self) -> Vec<u8> {
        let mut json = self.json.clone();
        if json["buffers"].is_null() {
            let uri = format!("data:application/octet-stream;base64,{}", STANDARD.encode(&self.bytes));
            json["buffers"] = json!([{ "byteLength": self.bytes.len(), "uri": uri }]);
        }
        json.to_string().into_bytes()
    }

    /// What `selection` reads of the file.
    pub fn select(&self, selection: &Selection) -> Result<MeshSequence, Error> {
        Gltf::default().read(&BytesInput::new("a.gltf", self.text()), selection)
    }

    /// What is read of the file.
    pub fn read(&self) -> Result<MeshSequence, Error> {
        self.select(&Selection::default())
    }

    /// The positions of the poses of a clip at its keys.
    pub fn at_keys(&self, clip: &str) -> Vec<Vec<Point3<f64>>> {
        positions(&self.select(&clips(&[clip], ClipTimes::Keys, None)).unwrap())
    }
}

/// The selection of clips at certain times.
pub fn clips(names: &[&str], times: ClipTimes, range: Option<[f64; 2]>) -> Selection {
    let clips = names.iter().map(|name| (*name).to_owned()).collect();
    Selection { poses: PoseChoice::Clips(ClipChoice { clips, times, range }), ..Selection::default() }
}

/// The positions of all poses.
pub fn positions(sequence: &MeshSequence) -> Vec<Vec<Point3<f64>>> {
    sequence.poses.iter().map(|pose| pose.positions.get().unwrap().into_owned()).collect()
}

/// The names of all poses.
pub fn names(sequence: &MeshSequence) -> Vec<&str> {
    sequence.poses.iter().map(|pose| &pose.name[..]).collect()
}

/// Matrix `index` of `matrix` moved by x, y, z, column by column.
pub fn translation(x: f64, y: f64, z: f64) -> [f64; 16] {
    [1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1., 0., x, y, z, 1.]
}

/// The quaternion of a rotation about z.
pub fn about_z(degrees: f64) -> [f64; 4] {
    let half = degrees.to_radians() / 2.0;
    [0.0, 0.0, half.sin(), half.cos()]
}

/// A strip of three rows of two vertices, at y = 0, 1 and 2, whose middle row two joints share.
///
/// Joint 0 (node 2) stands at the origin, joint 1 (node 3) at y = 1 in it; both hang under node 1, and node 0 shows the mesh.
pub fn strip() -> File {
    let mut file = File::new();
    let position = file.floats(&STRIP);
    let triangles: Vec<u8> = [0, 1, 3, 0, 3, 2, 2, 3, 5, 2, 5, 4_u8].to_vec();
    let indices = file.accessor("SCALAR", 5121, 12, &triangles);
    let joints = file.bytes4(&[[0, 1, 0, 0]; 6]);
    let weights = [
        [1., 0., 0., 0.],
        [1., 0., 0., 0.],
        [0.5, 0.5, 0., 0.],
        [0.5, 0.5, 0., 0.],
        [0., 1., 0., 0.],
        [0., 1., 0., 0.],
    ];
    let weights = file.floats(&weights);
    let inverse = file.floats(&[translation(0., 0., 0.), translation(0., -1., 0.)]);
    let attributes = json!({ "POSITION": position, "JOINTS_0": joints, "WEIGHTS_0": weights });
    file.push("meshes", json!({ "name": "strip", "primitives": [{ "attributes": attributes, "indices": indices }] }));
    file.push("skins", json!({ "joints": [2, 3], "inverseBindMatrices": inverse }));
    // The node of a skinned mesh does not move it.
    file.push("nodes", json!({ "name": "skinned", "mesh": 0, "skin": 0, "translation": [9, 9, 9] }));
    file.push("nodes", json!({ "name": "armature", "children": [2] }));
    file.push("nodes", json!({ "name": "lower", "children": [3] }));
    file.push("nodes", json!({ "name": "upper", "translation": [0, 1, 0] }));
    file.json["scenes"] = json!([{ "nodes": [0, 1] }]);
    file
}

/// The stored vertices of [`strip`].
pub const STRIP: [[f64; 3]; 6] =
    [[-0.5, 0., 0.], [0.5, 0., 0.], [-0.5, 1., 0.], [0.5, 1., 0.], [-0.5, 2., 0.], [0.5, 2., 0.]];

/// Where the vertices of [`strip`] are when its upper joint is turned about z by `degrees`.
pub fn bent(degrees: f64) -> Vec<Point3<f64>> {
    let (sin, cos) = degrees.to_radians().sin_cos();
    let turned = |[x, y, z]: [f64; 3]| Point3::new(x * cos - (y - 1.0) * sin, 1.0 + x * sin + (y - 1.0) * cos, z);
    let share = [0.0, 0.0, 0.5, 0.5, 1.0, 1.0];
    STRIP.into_iter().zip(share).map(|(p, share)| Point3::from(p).lerp(&turned(p), share)).collect()
}
