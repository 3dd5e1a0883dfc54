//! Skins: which joints move which vertices.

use std::{collections::HashMap, ops::Range};

use gltf::json::mesh::{Primitive, Semantic};
use nalgebra::{Matrix3x4, Matrix4, Point3};

use super::{
    accessor::{numbers, whole},
    asset::{Asset, get},
    primitive::attribute,
};

/// The joints of a skin.
#[derive(Debug)]
pub struct Skin {
    /// The nodes that are joints.
    pub joints: Vec<usize>,
    /// The transform from the mesh as it is stored to each joint.
    inverse_bind: Vec<Matrix4<f64>>,
}

impl Skin {
    /// Reads skin `index`; without inverse bind matrices they are the identity.
    ///
    /// # Errors
    ///
    /// Names what does not exist, or is not finite.
    pub fn new(asset: &Asset, index: usize) -> Result<Self, String> {
        let skin = get(&asset.root.skins, index, "skin")?;
        let named = |message: String| format!("skin {index}: {message}");
        let joints: Vec<usize> = skin.joints.iter().map(|joint| joint.value()).collect();
        for &joint in &joints {
            get(&asset.root.nodes, joint, "node").map_err(named)?;
        }
        let mut inverse_bind = vec![Matrix4::identity(); joints.len()];
        if let Some(accessor) = skin.inverse_bind_matrices {
            let matrices = numbers::<16>(asset, accessor).map_err(named)?;
            if matrices.len() < joints.len() {
                return Err(named(format!("{} inverse bind matrices for {} joints", matrices.len(), joints.len())));
            }
            for (place, matrix) in inverse_bind.iter_mut().zip(matrices) {
                *place = Matrix4::from_column_slice(&matrix);
            }
        }
        if let Some(joint) = inverse_bind.iter().position(|matrix| !matrix.iter().all(|x| x.is_finite())) {
            let joint = super::nodes::name(asset, joints[joint]);
            return Err(named(format!("the inverse bind matrix of {joint} is not finite")));
        }
        Ok(Self { joints, inverse_bind })
    }

    /// The joints whose inverse bind matrix is singular, so that it flattens what they move.
    pub fn singular(&self) -> impl Iterator<Item = usize> {
        let is_flat = |matrix: &Matrix4<f64>| {
            let linear = matrix.fixed_view::<3, 3>(0, 0);
            let lengths: f64 = linear.column_iter().map(|column| column.norm()).product();
            // Not above it, so that NaN is singular too.
            linear.determinant().is_nan() || linear.determinant().abs() <= MIN_DETERMINANT * lengths
        };
        self.joints.iter().zip(&self.inverse_bind).filter(move |(_, matrix)| is_flat(matrix)).map(|(joint, _)| *joint)
    }

    /// The joints whose inverse bind matrix is no affine transform.
    pub fn projective(&self) -> impl Iterator<Item = usize> {
        let pairs = self.joints.iter().zip(&self.inverse_bind);
        // One of zeros is singular, which is told.
        pairs.filter(|(_, matrix)| !is_affine(matrix) && matrix.amax() > 0.0).map(|(joint, _)| *joint)
    }

    /// The transforms from the stored mesh to the scene, one a joint, when the nodes are at `worlds`.
    pub fn matrices(&self, worlds: &[Matrix4<f64>]) -> Vec<Matrix3x4<f64>> {
        let pairs = self.joints.iter().zip(&self.inverse_bind);
        pairs.map(|(&joint, inverse)| (worlds[joint] * inverse).fixed_view::<3, 4>(0, 0).into()).collect()
    }
}

/// Weights of one place that differ by less are the same: a few rounding errors of f32.
const WEIGHT_NOISE: f64 = 1e-6;

/// Vertices of one place that are no seam are not all compared with each other.
const MAX_SHARED: usize = 64;

/// How joints move the vertices of a run.
#[derive(Debug)]
pub struct Influences {
    /// Where the influences of each vertex start, and the end of the last.
    starts: Vec<u32>,
    /// Joints of the skin, and weights whose sum is 1 for each vertex.
    influences: Vec<(u32, f64)>,
    /// The vertices whose weights are negative or do not sum to 1.
    pub uneven: usize,
}

/// Weights in eight bits, as many files have them, may miss their sum of 1 by a few hundredths.
const MAX_UNEVEN: f64 = 0.02;

/// The smallest determinant of a sound inverse bind matrix, relative to the lengths of its columns.
const MIN_DETERMINANT: f64 = 1e-12;

impl Influences {
    /// Reads `JOINTS_0`, `WEIGHTS_0`, `JOINTS_1` and so on of a primitive; `None` if it has none, and its node moves it.
    ///
    /// Weights are divided by their sum. A vertex without weights follows its first joint, as in three.js. Vertices that are `stored`
    /// (#V × 3) at one place and have the same weights up to noise, along seams, have exactly the same, so that seams stay closed.
    ///
    /// # Errors
    ///
    /// Says what does not fit the vertices or the skin's joints, or is not finite.
    pub fn read(
        asset: &Asset,
        primitive: &Primitive,
        skin: &Skin,
        stored: &[Point3<f64>],
    ) -> Result<Option<Self>, String> {
        let count = stored.len();
        let set = |number| {
            let joints = attribute(primitive, Semantic::Joints(number));
            joints.zip(attribute(primitive, Semantic::Weights(number)))
        };
        let mut sets = Vec::new();
        for (joints, weights) in (0..).map_while(set) {
            let (joints, weights) = (whole::<4>(asset, joints)?, numbers::<4>(asset, weights)?);
            if (joints.len(), weights.len()) != (count, count) {
                return Err(format!("{} joints and {} weights for {count} vertices", joints.len(), weights.len()));
            }
            sets.push((joints, weights));
        }
        if sets.is_empty() {
            return Ok(None);
        }
        let (mut starts, mut influences, mut uneven) = (vec![0], Vec::new(), 0);
        for vertex in 0..count {
            let all = sets.iter().flat_map(|(joints, weights)| joints[vertex].into_iter().zip(weights[vertex]));
            let mut all: Vec<(u32, f64)> = all.filter(|(_, weight)| *weight != 0.0).collect();
            // Sums do not depend on the order in the file.
            all.sort_by_key(|(joint, _)| *joint);
            let sum: f64 = all.iter().map(|(_, weight)| weight.abs()).sum();
            if !sum.is_finite() {
                return Err(format!("vertex {vertex} (from 0) has weights that are not finite"));
            }
            let plain: f64 = all.iter().map(|(_, weight)| weight).sum();
            uneven += usize::from((plain - 1.0).abs() > MAX_UNEVEN || plain < sum);
            let first = influences.len();
            if sum == 0.0 {
                influences.push((sets[0].0[vertex][0], 1.0));
            } else {
                influences.extend(all.into_iter().map(|(joint, weight)| (joint, weight / sum)));
            }
            if let Some((joint, _)) = influences[first..].iter().find(|(joint, _)| *joint as usize >= skin.joints.len())
            {
                let joints = skin.joints.len();
                return Err(format!("vertex {vertex} (from 0) follows joint {joint}: the skin has {joints} (from 0)"));
            }
            starts.push(influences.len() as u32);
        }
        let mut read = Self { starts, influences, uneven };
        read.share(stored);
        Ok(Some(read))
    }

    /// Gives vertices at one place the weights of the first, where they differ by noise.
    fn share(&mut self, stored: &[Point3<f64>]) {
        let mut first_at: HashMap<[u64; 3], Vec<usize>> = HashMap::new();
        for (vertex, position) in stored.iter().enumerate() {
            // -0 is 0.
            let firsts = first_at.entry(std::array::from_fn(|k| (position[k] + 0.0).to_bits())).or_default();
            let own = self.range(vertex);
            match firsts
                .iter()
                .take(MAX_SHARED)
                .map(|&first| self.range(first))
                .find(|first| self.differ_by_noise(first, &own))
            {
                Some(first) => self.influences.copy_within(first, own.start),
                None if firsts.len() < MAX_SHARED => firsts.push(vertex),
                None => {}
            }
        }
    }

    fn differ_by_noise(&self, a: &Range<usize>, b: &Range<usize>) -> bool {
        let (a, b) = (&self.influences[a.clone()], &self.influences[b.clone()]);
        a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.0 == b.0 && (a.1 - b.1).abs() <= WEIGHT_NOISE)
    }

    fn range(&self, vertex: usize) -> Range<usize> {
        self.starts[vertex] as usize..self.starts[vertex + 1] as usize
    }

    /// The transform of a vertex: that of its joints, weighted.
    pub fn blend(&self, vertex: usize, joints: &[Matrix3x4<f64>]) -> Matrix3x4<f64> {
        let influences = &self.influences[self.range(vertex)];
        // One joint alone moves a vertex exactly, without a sum.
        if let [(joint, weight)] = influences
            && *weight == 1.0
        {
            return joints[*joint as usize];
        }
        influences.iter().fold(Matrix3x4::zeros(), |sum, (joint, weight)| sum + joints[*joint as usize] * *weight)
    }
}

/// Whether the last row of a matrix is that of a transform, up to the rounding of products of 32-bit numbers.
pub fn is_affine(matrix: &Matrix4<f64>) -> bool {
    let row = matrix.row(3);
    row.iter().zip([0.0, 0.0, 0.0, 1.0]).all(|(x, expected)| (x - expected).abs() <= 1e-4)
}
