//! The bind pose: where meshes stood when they were bound to their bones.

use std::collections::HashMap;

use nalgebra::Matrix4;
use ufbx::{Mesh, Node, Scene, SkinDeformer};

use super::file::matrix;

/// Transforms of vertices.
#[derive(Debug)]
pub enum Transforms {
    /// One for all.
    Uniform(Matrix4<f64>),
    /// One a vertex, for skinned meshes.
    Skinned(Vec<Matrix4<f64>>),
}

impl Transforms {
    /// That of a vertex.
    pub fn of(&self, vertex: usize) -> &Matrix4<f64> {
        match self {
            Self::Uniform(matrix) => matrix,
            Self::Skinned(matrices) => &matrices[vertex],
        }
    }
}

/// Where bones stood when meshes were bound to them.
#[derive(Debug, Default)]
pub struct Bind {
    /// The transforms from bones to the world, by the bone's number in the scene.
    bones: HashMap<u32, Matrix4<f64>>,
}

impl Bind {
    /// Those of all skins; of a bone of several the first counts for what hangs on it.
    pub fn new(scene: &Scene) -> Self {
        let mut bones = HashMap::new();
        for cluster in &scene.skin_clusters {
            if let Some(bone) = &cluster.bone_node {
                bones.entry(bone.element.typed_id).or_insert_with(|| matrix(&cluster.bind_to_world));
            }
        }
        Self { bones }
    }

    /// The transforms of the vertices of a mesh under `node` to the world.
    pub fn transforms(&self, node: &Node, mesh: &Mesh) -> Transforms {
        let whole = self.of_node(node);
        let Some(skin) = skin(mesh) else { return Transforms::Uniform(whole) };
        let clusters = skin.clusters.iter();
        let clusters: Vec<Matrix4<f64>> =
            clusters.map(|cluster| matrix(&cluster.bind_to_world) * matrix(&cluster.geometry_to_bone)).collect();
        let of_vertex = |vertex: usize| {
            let weights = influences(skin, vertex);
            let total: f64 = weights.iter().map(|influence| influence.weight).sum();
            let blended = weights.iter().fold(Matrix4::zeros(), |sum: Matrix4<f64>, influence| {
                sum + clusters[influence.cluster_index as usize] * influence.weight
            });
            if total > 0.0 { blended / total } else { whole }
        };
        Transforms::Skinned((0..mesh.num_vertices).map(of_vertex).collect())
    }

    /// The transform of the geometry of a node to the world; a node below a bone goes with it.
    fn of_node(&self, node: &Node) -> Matrix4<f64> {
        let above = std::iter::successors(Some(node), |node| node.parent.as_deref());
        let mut bones = above.filter_map(|bone| Some((bone, self.bones.get(&bone.element.typed_id)?)));
        let stored = matrix(&node.geometry_to_world);
        let moved = bones.next().and_then(|(bone, bind)| Some(bind * matrix(&bone.node_to_world).try_inverse()?));
        moved.map_or(stored, |moved| moved * stored)
    }
}

/// The skin that moves a mesh; `ufbx` too evaluates only the first.
pub fn skin(mesh: &Mesh) -> Option<&SkinDeformer> {
    mesh.skin_deformers.iter().map(|skin| &**skin).next().filter(|skin| !skin.clusters.is_empty())
}

/// The influences of a vertex; none where the file gives none.
pub fn influences(skin: &SkinDeformer, vertex: usize) -> &[ufbx::SkinWeight] {
    let range = skin.vertices.get(vertex).map(|v| v.weight_begin as usize..(v.weight_begin + v.num_weights) as usize);
    range.and_then(|range| skin.weights.get(range)).unwrap_or_default()
}
