//! What a writer needs to give a glTF back as it was, with new morph targets.

use std::{
    collections::BTreeMap,
    ops::{Deref, Range},
    sync::Arc,
};

use nalgebra::{Matrix4, Point3};
use serde_json::Value;

/// A glTF as it was read.
#[derive(Debug, Default)]
pub struct GltfDocument {
    /// The JSON of the file, with nothing taken out; numbers that JSON does not know are null.
    pub json: Value,
    /// The contents of its buffers.
    pub buffers: Vec<Buffer>,
    /// The contents of the images in files of their own, by the number of the image.
    pub images: Vec<(usize, Arc<Vec<u8>>)>,
    /// The contents of the buffer views that are compressed in the file, by the number of the view.
    pub decompressed: BTreeMap<usize, Vec<u8>>,
    /// The contents of the accessors that a primitive's compression holds, without gaps, by the number of the accessor.
    pub unpacked: BTreeMap<usize, Vec<u8>>,
    /// Where the vertices of the mesh come from, in their order.
    pub placements: Vec<Placement>,
    /// The nodes that stand elsewhere at rest than the file stores, where the rest is a time of a clip.
    pub resting: Vec<RestingNode>,
}

impl GltfDocument {
    /// The names of what the file has and a mesh has no place for.
    pub fn beyond_mesh(&self) -> Vec<&'static str> {
        let list = |key: &str| self.json[key].as_array().is_some_and(|list| !list.is_empty());
        let primitives = || {
            let meshes = self.json["meshes"].as_array().into_iter().flatten();
            meshes.flat_map(|mesh| mesh["primitives"].as_array().into_iter().flatten())
        };
        let attribute = |name: &str| primitives().any(|primitive| primitive["attributes"].get(name).is_some());
        let found = [
            ("skins", list("skins")),
            ("animations", list("animations")),
            (
                "morph targets",
                primitives().any(|primitive| primitive["targets"].as_array().is_some_and(|t| !t.is_empty())),
            ),
            ("textures", list("images")),
            ("further colours of vertices", attribute("COLOR_1")),
            ("further texture coordinates", attribute("TEXCOORD_1")),
        ];
        found.into_iter().filter(|(_, is_there)| *is_there).map(|(name, _)| name).collect()
    }
}

/// The contents of a buffer: the first bytes of a file, which several buffers may name.
#[derive(Clone, Debug, Default)]
pub struct Buffer {
    /// The bytes of the file.
    pub file: Arc<Vec<u8>>,
    /// How many of them are the buffer's.
    pub length: usize,
    /// Zeros behind them, which the glTF counts and the file lacks.
    pub padding: usize,
}

impl From<Vec<u8>> for Buffer {
    fn from(bytes: Vec<u8>) -> Self {
        Self { length: bytes.len(), file: Arc::new(bytes), padding: 0 }
    }
}

impl Deref for Buffer {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        &self.file[..self.length]
    }
}

/// The bytes of all `buffers`, those that several share once.
pub fn bytes_of(buffers: &[Buffer]) -> usize {
    let files: BTreeMap<_, usize> =
        buffers.iter().map(|buffer| (Arc::as_ptr(&buffer.file), buffer.file.len())).collect();
    files.values().sum()
}

/// A node where it is at rest.
#[derive(Clone, Debug, PartialEq)]
pub struct RestingNode {
    /// The node.
    pub node: usize,
    /// Its translation in its parent.
    pub translation: [f64; 3],
    /// Its rotation, a quaternion x, y, z, w.
    pub rotation: [f64; 4],
    /// Its scale along its axes.
    pub scale: [f64; 3],
}

/// A run of vertices of the mesh: those of primitives that share them, under one node.
#[derive(Debug)]
pub struct Placement {
    /// The node.
    pub node: usize,
    /// The mesh of the node.
    pub mesh: usize,
    /// The primitives of the mesh, by number, that share the vertices.
    pub primitives: Vec<usize>,
    /// The vertices.
    pub vertices: Range<usize>,
    /// The vertices as the file stores them, #V × 3: before morph targets, joints and the node move them.
    pub stored: Vec<Point3<f64>>,
    /// The transforms from the stored mesh to the scene, at rest.
    pub scene_from_stored: Transforms,
}

/// The transforms of vertices.
#[derive(Debug)]
pub enum Transforms {
    /// One for all.
    Uniform(Matrix4<f64>),
    /// One a vertex, for skinned meshes.
    Skinned(Vec<Matrix4<f64>>),
}
