//! Positions of the mesh for any state of nodes and morph targets.

use std::{collections::HashSet, ops::Range, sync::Arc};

use mimesh_core::{
    Result,
    mesh::{ComputePoses, check_finite},
};
use nalgebra::{Matrix3x4, Matrix4, Point3, Vector3};

use super::{
    asset::Asset,
    clips::{Clip, Weights},
    morphs::Moves,
    nodes::{Local, MAX_NUMBER, Nodes, name},
    skin::{Influences, Skin},
};
use crate::gltf::document::{RestingNode, Transforms};

/// Vertices under one node that the same morph targets and joints move.
#[derive(Debug)]
pub struct Run {
    /// The node.
    pub node: usize,
    /// The mesh of the node.
    pub mesh: usize,
    /// The vertices.
    pub vertices: Range<usize>,
    /// Their positions as the file stores them.
    pub stored: Vec<Point3<f64>>,
    /// The morph targets, by number.
    pub targets: Vec<Arc<Moves>>,
    /// The joints that move them in place of the node.
    pub skin: Option<(Arc<Skin>, Influences)>,
}

/// A shape that the file can take.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Shape {
    /// A clip and the seconds at which the nodes are as it has them.
    pub clip: Option<(usize, f64)>,
    /// The weights of the morph targets.
    pub morphs: Morphs,
}

/// The weights of morph targets.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Morphs {
    /// All 0.
    #[default]
    None,
    /// Those of the clip, else those that the file stores.
    OfClip,
    /// These targets of runs at 1, all others at 0; in the order of the runs.
    Only(Vec<(usize, usize)>),
}

/// The file's vertices, with all that moves them.
#[derive(Debug)]
pub struct Evaluator {
    /// The nodes.
    pub nodes: Nodes,
    /// The weights of morph targets that the file stores, for each node.
    pub weights: Vec<Weights>,
    /// The clips.
    pub clips: Vec<Clip>,
    /// The vertices, in order.
    pub runs: Vec<Run>,
    /// The poses.
    pub poses: Vec<Shape>,
}

impl Evaluator {
    /// The positions of a shape, #V × 3.
    ///
    /// A vertex is `T (v + Σ w d)`, with T that of its node in the scene, or `Σ w J B` over its joints J with their inverse bind
    /// matrices B: the node of a skinned mesh does not move it (glTF 2.0, 3.7.3).
    pub fn shape(&self, shape: &Shape) -> Vec<Point3<f64>> {
        let (worlds, weights) = self.state(shape);
        let mut positions = Vec::with_capacity(self.runs.last().map_or(0, |run| run.vertices.end));
        for (index, run) in self.runs.iter().enumerate() {
            let first = positions.len();
            positions.extend_from_slice(&run.stored);
            let positions = &mut positions[first..];
            for (target, weight) in self.targets(index, shape, &weights) {
                let Moves { vertices, displacements } = &*run.targets[target];
                for (&vertex, &displacement) in vertices.iter().zip(displacements) {
                    positions[vertex as usize] += Vector3::from(displacement) * weight;
                }
            }
            match &run.skin {
                None => {
                    let matrix = worlds[run.node].fixed_view::<3, 4>(0, 0).into();
                    positions.iter_mut().for_each(|position| *position = moved(&matrix, position));
                }
                Some((skin, influences)) => {
                    let joints = skin.matrices(&worlds);
                    for (vertex, position) in positions.iter_mut().enumerate() {
                        *position = moved(&influences.blend(vertex, &joints), position);
                    }
                }
            }
        }
        positions
    }

    /// The transforms of the vertices of each run from as they are stored to the scene, in a shape.
    pub fn transforms(&self, shape: &Shape) -> Vec<Transforms> {
        let (worlds, _) = self.state(shape);
        let of_run = |run: &Run| match &run.skin {
            None => Transforms::Uniform(worlds[run.node]),
            Some((skin, influences)) => {
                let joints = skin.matrices(&worlds);
                let blended = (0..run.vertices.len()).map(|vertex| influences.blend(vertex, &joints));
                Transforms::Skinned(blended.map(|matrix| matrix.fixed_resize::<4, 4>(0.0)).map(with_last_row).collect())
            }
        };
        self.runs.iter().map(of_run).collect()
    }

    /// Whether morph targets move each run in a shape.
    pub fn morphed(&self, shape: &Shape) -> Vec<bool> {
        let (_, weights) = self.state(shape);
        (0..self.runs.len()).map(|run| self.targets(run, shape, &weights).next().is_some()).collect()
    }

    /// Checks that the positions of a shape are finite.
    ///
    /// # Errors
    ///
    /// Names the node whose transform or weights are not, or are far too large.
    pub fn check(&self, asset: &Asset, shape: &Shape) -> std::result::Result<(), String> {
        let (worlds, weights) = self.state(shape);
        self.nodes.check(asset, &worlds)?;
        match weights.iter().position(|weights| !weights.iter().all(|weight| weight.abs() < MAX_NUMBER)) {
            None => Ok(()),
            Some(node) => Err(format!("{} has weights of morph targets that are not finite", name(asset, node))),
        }
    }

    /// The transforms of the nodes in a shape, and the weights of morph targets if the clip gives them.
    fn state(&self, shape: &Shape) -> (Vec<Matrix4<f64>>, Vec<Weights>) {
        let mut locals: Vec<Local> = self.nodes.locals.clone();
        let mut weights = self.weights.clone();
        if let Some((clip, seconds)) = shape.clip {
            self.clips[clip].apply(seconds, &mut locals, &mut weights);
        }
        (self.nodes.worlds(&locals), weights)
    }

    /// The nodes that stand elsewhere in a shape than the file stores.
    pub fn moved_nodes(&self, shape: &Shape) -> Vec<RestingNode> {
        let Some((clip, seconds)) = shape.clip else { return Vec::new() };
        let (mut locals, mut weights) = (self.nodes.locals.clone(), self.weights.clone());
        self.clips[clip].apply(seconds, &mut locals, &mut weights);
        let moved = locals.iter().zip(&self.nodes.locals).enumerate().filter(|(_, (local, stored))| local != stored);
        moved
            .filter_map(|(node, (local, _))| match local.in_parts() {
                Local::Parts { translation, rotation, scale } => {
                    Some(RestingNode { node, translation, rotation, scale })
                }
                Local::Matrix(_) => None,
            })
            .collect()
    }

    /// The nodes that move vertices, and those of them whose morph targets do.
    pub fn moving_nodes(&self) -> (HashSet<usize>, HashSet<usize>) {
        let (mut nodes, mut morphing) = (HashSet::new(), HashSet::new());
        for run in &self.runs {
            let joints = run.skin.as_ref().map(|(skin, _)| &skin.joints[..]);
            for &node in joints.unwrap_or(&[run.node]) {
                // Above a node that was seen before all are known.
                for node in self.nodes.with_ancestors(node) {
                    if !nodes.insert(node) {
                        break;
                    }
                }
            }
            if !run.targets.is_empty() {
                morphing.insert(run.node);
            }
        }
        (nodes, morphing)
    }

    /// The targets of a run whose weights are not 0.
    fn targets<'a>(
        &'a self,
        run: usize,
        shape: &'a Shape,
        weights: &'a [Weights],
    ) -> Box<dyn Iterator<Item = (usize, f64)> + 'a> {
        let Run { node, targets, .. } = &self.runs[run];
        match &shape.morphs {
            Morphs::None => Box::new(std::iter::empty()),
            Morphs::OfClip => {
                let weights = weights[*node].iter().copied().take(targets.len());
                Box::new(weights.enumerate().filter(|(_, weight)| *weight != 0.0))
            }
            Morphs::Only(only) => {
                let of_run = &only[only.partition_point(|(of, _)| *of < run)..];
                Box::new(of_run.iter().take_while(move |(of, _)| *of == run).map(|(_, target)| (*target, 1.0)))
            }
        }
    }
}

impl ComputePoses for Evaluator {
    fn positions(&self, index: usize) -> Result<Vec<Point3<f64>>> {
        let positions = self.shape(&self.poses[index]);
        // Of very many poses not all were looked at before.
        check_finite(&positions)?;
        Ok(positions)
    }
}

fn moved(matrix: &Matrix3x4<f64>, point: &Point3<f64>) -> Point3<f64> {
    Point3::from(matrix.fixed_columns::<3>(0) * point.coords + matrix.column(3))
}

fn with_last_row(mut matrix: Matrix4<f64>) -> Matrix4<f64> {
    matrix[(3, 3)] = 1.0;
    matrix
}
