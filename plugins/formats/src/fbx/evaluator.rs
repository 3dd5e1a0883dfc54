//! Positions of the mesh for any state of nodes and blend shapes.

use std::ops::Range;

use mimesh_core::{Result, mesh::ComputePoses};
use nalgebra::{Matrix4, Point3};
use ufbx::{EvaluateOpts, Mesh, Node, Scene, SceneRoot, Vec3};

use super::{
    bind::{Bind, Transforms, influences, skin},
    file::matrix,
};

/// The vertices of a mesh under a node.
#[derive(Debug)]
pub struct Run {
    /// The node, by its number in the scene.
    pub node: usize,
    /// The mesh, by its number in the scene.
    pub mesh: usize,
    /// The vertices.
    pub vertices: Range<usize>,
}

/// A shape that the file can take.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Shape {
    /// A clip and the seconds at which the nodes are as it has them; else the bind pose.
    pub clip: Option<(usize, f64)>,
    /// The weights of the blend shapes.
    pub blend: Blend,
}

/// The weights of blend shapes.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Blend {
    /// All 0.
    #[default]
    None,
    /// Those of the clip.
    OfClip,
    /// These channels of runs at full weight, all others at 0; in the order of the runs.
    Only(Vec<(usize, usize)>),
}

/// The file's vertices, with all that moves them.
pub struct Evaluator {
    /// The scene.
    pub scene: SceneRoot,
    /// From the file's unit and axes to ours.
    pub to_metres: Matrix4<f64>,
    /// The bind pose.
    pub bind: Bind,
    /// The vertices, in order.
    pub runs: Vec<Run>,
    /// The poses.
    pub poses: Vec<Shape>,
}

impl Evaluator {
    /// The positions of a shape, #V × 3: `T (v + Σ w d)`, with T of [`transforms`](Self::transforms).
    pub fn shape(&self, shape: &Shape) -> Vec<Point3<f64>> {
        let evaluated = self.evaluated(shape);
        let scene = evaluated.as_deref().unwrap_or(&self.scene);
        let mut positions = Vec::with_capacity(self.runs.last().map_or(0, |run| run.vertices.end));
        for (index, run) in self.runs.iter().enumerate() {
            let mesh = &scene.meshes[run.mesh];
            let mut stored: Vec<Vec3> = mesh.vertices.to_vec();
            match &shape.blend {
                Blend::None => {}
                Blend::OfClip => {
                    mesh.blend_deformers
                        .iter()
                        .for_each(|blend| ufbx::add_blend_vertex_offsets(blend, &mut stored, 1.0));
                }
                Blend::Only(channels) => {
                    let own = channels.iter().filter(|(run, _)| *run == index);
                    let shapes = own.filter_map(|(_, channel)| scene.blend_channels[*channel].target_shape.as_ref());
                    shapes.for_each(|shape| ufbx::add_blend_shape_vertex_offsets(shape, &mut stored, 1.0));
                }
            }
            let transforms = self.of_run(run, scene, evaluated.is_some());
            let placed = stored.iter().enumerate().map(|(vertex, v)| {
                let point = transforms.of(vertex) * Point3::new(v.x, v.y, v.z).to_homogeneous();
                Point3::new(point.x, point.y, point.z)
            });
            positions.extend(placed);
        }
        positions
    }

    /// The transforms of the vertices of each run from as they are stored to metres, in a shape.
    pub fn transforms(&self, shape: &Shape) -> Vec<Transforms> {
        let evaluated = self.evaluated(shape);
        let scene = evaluated.as_deref().unwrap_or(&self.scene);
        self.runs.iter().map(|run| self.of_run(run, scene, evaluated.is_some())).collect()
    }

    /// The scene at the time of a shape's clip.
    fn evaluated(&self, shape: &Shape) -> Option<SceneRoot> {
        let (clip, seconds) = shape.clip?;
        let anim = &self.scene.anim_stacks[clip].anim;
        let evaluated = ufbx::evaluate_scene(&self.scene, anim, seconds, EvaluateOpts::default());
        Some(evaluated.expect("evaluating a scene that was read fails only without memory"))
    }

    fn of_run(&self, run: &Run, scene: &Scene, is_evaluated: bool) -> Transforms {
        let (node, mesh) = (&scene.nodes[run.node], &scene.meshes[run.mesh]);
        let to_world = if is_evaluated { animated(node, mesh) } else { self.bind.transforms(node, mesh) };
        match to_world {
            Transforms::Uniform(matrix) => Transforms::Uniform(self.to_metres * matrix),
            Transforms::Skinned(mut matrices) => {
                matrices.iter_mut().for_each(|matrix| *matrix = self.to_metres * *matrix);
                Transforms::Skinned(matrices)
            }
        }
    }
}

impl ComputePoses for Evaluator {
    fn positions(&self, index: usize) -> Result<Vec<Point3<f64>>> {
        Ok(self.shape(&self.poses[index]))
    }
}

/// The transforms of the vertices of a mesh under `node` to the world, where the bones are.
fn animated(node: &Node, mesh: &Mesh) -> Transforms {
    let whole = &node.geometry_to_world;
    let Some(skin) = skin(mesh) else { return Transforms::Uniform(matrix(whole)) };
    let of_vertex = |vertex: usize| match influences(skin, vertex) {
        [] => matrix(whole),
        _ => matrix(&ufbx::get_skin_vertex_matrix(skin, vertex, whole)),
    };
    Transforms::Skinned((0..mesh.num_vertices).map(of_vertex).collect())
}
