//! An evaluation of a GLB that shares nothing with reader and writer: the `gltf` crate's numbers, matrices in f64.

use gltf::{Gltf, Node, mesh::Mode};
use mimesh_core::{
    mesh::Mesh,
    stage::{BytesInput, Format, Selection},
};
use nalgebra::{Matrix4, Point3, Quaternion, UnitQuaternion, Vector3};
use serde_json::Value;

use crate::Glb;

/// A primitive of triangles under a node.
pub struct Shape {
    pub node: usize,
    pub mesh: usize,
    pub primitive: usize,
    pub position: usize,
    pub stored: Vec<Point3<f64>>,
    pub transforms: Vec<Matrix4<f64>>,
    pub targets: Vec<Vec<Vector3<f64>>>,
    pub corners: Vec<u32>,
}

impl Shape {
    /// Positions in the scene with morph targets at `weights`.
    pub fn at(&self, weights: &[f64]) -> Vec<Point3<f64>> {
        let moved = |vertex: usize| {
            let moves = self.targets.iter().zip(weights).map(|(target, weight)| target[vertex] * *weight);
            (self.transforms[vertex] * (self.stored[vertex] + moves.sum::<Vector3<f64>>()).to_homogeneous())
                .xyz()
                .into()
        };
        (0..self.stored.len()).map(moved).collect()
    }

    /// Positions in the scene with target `index` alone.
    pub fn with(&self, index: usize) -> Vec<Point3<f64>> {
        let weights: Vec<f64> = (0..self.targets.len()).map(|i| f64::from(u8::from(i == index))).collect();
        self.at(&weights)
    }
}

/// The JSON and the binary chunk of a GLB.
pub fn parts(glb: &[u8]) -> (Value, Vec<u8>) {
    let json = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
    (serde_json::from_slice(&glb[20..20 + json]).unwrap(), glb.get(28 + json..).unwrap_or_default().to_vec())
}

/// All triangles in the scene of a GLB, at rest.
pub fn shapes(glb: &[u8]) -> Vec<Shape> {
    let file = Gltf::from_slice_without_validation(glb).unwrap();
    let blob = parts(glb).1;
    let mut worlds = vec![Matrix4::identity(); file.nodes().len()];
    let scene = file.default_scene().or_else(|| file.scenes().next()).unwrap();
    let mut order = Vec::new();
    for node in scene.nodes() {
        place(&node, &Matrix4::identity(), &mut worlds, &mut order);
    }
    let nodes: Vec<_> = file.nodes().collect();
    let mut shapes = Vec::new();
    for index in order {
        let Some(mesh) = nodes[index].mesh() else { continue };
        for primitive in mesh.primitives().filter(|primitive| primitive.mode() == Mode::Triangles) {
            let reader = primitive.reader(|buffer| (buffer.index() == 0).then_some(&blob[..]));
            let stored: Vec<_> = reader.read_positions().unwrap().map(|p| Point3::from(p).cast::<f64>()).collect();
            let transforms = match nodes[index].skin() {
                None => vec![worlds[index]; stored.len()],
                Some(skin) => {
                    let inverses = skin.reader(|_| Some(&blob[..])).read_inverse_bind_matrices().unwrap();
                    let joints = skin.joints().zip(inverses);
                    let joints: Vec<_> = joints
                        .map(|(joint, inverse)| worlds[joint.index()] * Matrix4::from(inverse).cast::<f64>())
                        .collect();
                    let weights = reader.read_weights(0).unwrap().into_f32();
                    let influences = reader.read_joints(0).unwrap().into_u16().zip(weights);
                    // Exporters leave weights whose sum is not 1; viewers divide by it.
                    let blend = |(joint, weights): ([u16; 4], [f32; 4])| -> Matrix4<f64> {
                        let sum: f64 = weights.iter().map(|weight| f64::from(*weight)).sum();
                        (0..4).map(|i| joints[usize::from(joint[i])] * (f64::from(weights[i]) / sum)).sum()
                    };
                    influences.map(blend).collect()
                }
            };
            let targets = reader.read_morph_targets().map(|(moves, _, _)| {
                let zeros = || vec![Vector3::zeros(); stored.len()];
                moves.map_or_else(zeros, |moves| moves.map(|d| Vector3::from(d).cast::<f64>()).collect())
            });
            shapes.push(Shape {
                node: index,
                mesh: mesh.index(),
                primitive: primitive.index(),
                position: primitive.get(&gltf::Semantic::Positions).unwrap().index(),
                targets: targets.collect(),
                corners: match reader.read_indices() {
                    Some(indices) => indices.into_u32().collect(),
                    None => (0..stored.len() as u32).collect(),
                },
                stored,
                transforms,
            });
        }
    }
    shapes
}

fn place(node: &Node, parent: &Matrix4<f64>, worlds: &mut [Matrix4<f64>], order: &mut Vec<usize>) {
    let (t, [x, y, z, w], s) = node.transform().decomposed();
    let rotation = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z).cast::<f64>());
    let translation = Matrix4::new_translation(&Vector3::from(t).cast::<f64>());
    let scale = Matrix4::new_nonuniform_scaling(&Vector3::from(s).cast::<f64>());
    worlds[node.index()] = parent * translation * rotation.to_homogeneous() * scale;
    order.push(node.index());
    for child in node.children() {
        place(&child, &worlds[node.index()].clone(), worlds, order);
    }
}

/// The named parts of a GLB, all if there is no name, with the document for a writer.
pub fn load_parts(glb: &[u8], parts: &[&str]) -> Mesh {
    let meshes = parts.iter().map(|&name| name.to_owned()).collect();
    let selection = Selection { meshes, keep_document: true, ..Selection::default() };
    Glb::default().read(&BytesInput::new("a.glb", glb), &selection).unwrap().rest
}

/// The mesh of a whole GLB, with the document for a writer.
pub fn load(glb: &[u8]) -> Mesh {
    load_parts(glb, &[])
}
