//! An evaluation of a GLB that shares nothing with reader and writer: the `gltf` crate's numbers, matrices in f64.

use gltf::{Gltf, Node, mesh::Mode};
use mimesh_core::mesh::{CornerAttribute, Document, Mesh};
use nalgebra::{Matrix4, Point3, Quaternion, UnitQuaternion, Vector3};
use serde_json::Value;

use crate::gltf::document::{GltfDocument, Placement, Transforms};

/// A primitive of triangles under a node.
pub struct Shape {
    pub node: usize,
    pub mesh: usize,
    pub primitive: usize,
    pub position: usize,
    pub stored: Vec<Point3<f64>>,
    pub normals: Option<Vec<[f64; 3]>>,
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
                    influences.map(|(j, w)| (0..4).map(|i| joints[usize::from(j[i])] * f64::from(w[i])).sum()).collect()
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
                normals: reader.read_normals().map(|normals| normals.map(|n| n.map(f64::from)).collect()),
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

/// The mesh of a GLB at rest, with the document of the shapes that `choose` takes.
pub fn load_some(glb: &[u8], choose: impl Fn(&Shape) -> bool) -> Mesh {
    let (json, blob) = parts(glb);
    let mut mesh = Mesh::default();
    let mut normals = CornerAttribute::default();
    let mut placements: Vec<Placement> = Vec::new();
    let mut positions_of = Vec::new();
    for shape in shapes(glb).into_iter().filter(choose) {
        let key = (shape.node, shape.position);
        let place = match positions_of.iter().position(|other| *other == key) {
            Some(place) => {
                placements[place].primitives.push(shape.primitive);
                place
            }
            None => {
                let start = mesh.positions.len();
                mesh.positions.extend(shape.at(&[]));
                positions_of.push(key);
                placements.push(Placement {
                    node: shape.node,
                    mesh: shape.mesh,
                    primitives: vec![shape.primitive],
                    vertices: start..mesh.positions.len(),
                    stored: shape.stored.clone(),
                    scene_from_stored: Transforms::Skinned(shape.transforms.clone()),
                });
                placements.len() - 1
            }
        };
        let start = placements[place].vertices.start as u32;
        let first = normals.values.len() as u32;
        for (vertex, normal) in shape.normals.iter().flatten().enumerate() {
            let linear = shape.transforms[vertex].fixed_view::<3, 3>(0, 0).into_owned();
            let turned = linear.try_inverse().map(|inverse| (inverse.transpose() * Vector3::from(*normal)).normalize());
            normals.values.push(turned.unwrap_or_default().into());
        }
        for triangle in shape.corners.as_chunks::<3>().0 {
            mesh.polygons.push(&triangle.map(|corner| start + corner));
            normals.indices.extend(triangle.map(|corner| shape.normals.as_ref().map(|_| first + corner)));
        }
    }
    mesh.normals = normals.indices.iter().any(Option::is_some).then_some(normals);
    let document = GltfDocument { json, buffers: vec![blob], placements, ..GltfDocument::default() };
    mesh.document = Document::new(document);
    mesh
}

/// The mesh of a whole GLB at rest, with its document.
pub fn load(glb: &[u8]) -> Mesh {
    load_some(glb, |_| true)
}
