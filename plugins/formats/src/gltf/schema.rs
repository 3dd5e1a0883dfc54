//! The part of glTF's JSON that meshes, morph targets and the list of animations need.
//!
//! Textures, cameras and extensions of materials are not looked at, so that a file is never refused for them.
//! References are plain numbers: [`get`] checks each where it is followed.

use serde::Deserialize;
use serde_json::Value;

/// The root object.
#[derive(Debug, Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub struct Root {
    pub accessors: Vec<Accessor>,
    pub animations: Vec<Animation>,
    pub asset: Asset,
    pub buffers: Vec<Buffer>,
    pub buffer_views: Vec<BufferView>,
    pub extensions_required: Vec<String>,
    pub materials: Vec<Material>,
    pub meshes: Vec<Mesh>,
    pub nodes: Vec<Node>,
    pub scene: Option<usize>,
    pub scenes: Vec<Scene>,
    pub skins: Vec<Skin>,
}

/// The entry `index` of `list`, called `what` in messages.
pub fn get<'a, T>(list: &'a [T], index: usize, what: &str) -> Result<&'a T, String> {
    list.get(index).ok_or_else(|| format!("{what} {index} does not exist: there are {} (from 0)", list.len()))
}

/// The version of glTF.
#[derive(Debug, Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub struct Asset {
    pub version: String,
}

/// Bytes inside or beside the file.
#[derive(Debug, Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub struct Buffer {
    pub byte_length: usize,
    pub uri: Option<String>,
}

/// A run of bytes of a buffer.
#[derive(Debug, Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub struct BufferView {
    pub buffer: usize,
    pub byte_length: usize,
    pub byte_offset: usize,
    pub byte_stride: Option<usize>,
}

/// How to see numbers in a buffer view.
#[derive(Debug, Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub struct Accessor {
    pub buffer_view: Option<usize>,
    pub byte_offset: usize,
    pub component_type: u32,
    pub count: usize,
    pub normalized: bool,
    pub sparse: Option<Sparse>,
    #[serde(rename = "type")]
    pub kind: String,
}

/// Entries that differ from what an accessor has otherwise.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub struct Sparse {
    pub count: usize,
    pub indices: SparseArray,
    pub values: SparseArray,
}

/// Where the indices or values of a sparse accessor lie.
#[derive(Debug, Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub struct SparseArray {
    pub buffer_view: usize,
    pub byte_offset: usize,
    /// The type of the components, for indices only.
    pub component_type: u32,
}

/// The look of a primitive.
#[derive(Debug, Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub struct Material {
    pub name: Option<String>,
    pub pbr_metallic_roughness: MetallicRoughness,
}

/// Colour of a material.
#[derive(Debug, Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub struct MetallicRoughness {
    pub base_color_factor: Option<[f64; 4]>,
}

/// Primitives that belong together.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub struct Mesh {
    pub extras: Value,
    pub name: Option<String>,
    pub primitives: Vec<Primitive>,
    pub weights: Vec<f64>,
}

/// Triangles of one material.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub struct Primitive {
    pub attributes: Attributes,
    pub indices: Option<usize>,
    pub material: Option<usize>,
    pub mode: Option<u32>,
    pub targets: Vec<Attributes>,
}

/// Accessors of the attributes that matter here.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub struct Attributes {
    #[serde(rename = "POSITION")]
    pub position: Option<usize>,
    #[serde(rename = "NORMAL")]
    pub normal: Option<usize>,
    #[serde(rename = "TEXCOORD_0")]
    pub texture: Option<usize>,
}

/// A place in the scene.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub struct Node {
    pub children: Vec<usize>,
    pub matrix: Option<[f64; 16]>,
    pub mesh: Option<usize>,
    pub name: Option<String>,
    pub rotation: Option<[f64; 4]>,
    pub scale: Option<[f64; 3]>,
    pub skin: Option<usize>,
    pub translation: Option<[f64; 3]>,
}

/// The nodes to show.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub struct Scene {
    pub nodes: Vec<usize>,
}

/// The joints of a skinned mesh.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub struct Skin {
    pub joints: Vec<usize>,
}

/// Keyframes for nodes.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub struct Animation {
    pub channels: Vec<Channel>,
    pub name: Option<String>,
    pub samplers: Vec<Sampler>,
}

/// The property that a sampler moves.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub struct Channel {
    pub target: Target,
}

/// A property of a node.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub struct Target {
    pub node: Option<usize>,
    pub path: String,
}

/// Keyframes.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub struct Sampler {
    pub input: usize,
}
