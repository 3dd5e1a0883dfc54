//! Texture coordinates and normals of corners.

use std::collections::{HashMap, HashSet};

use gltf::json::{Accessor, Index};
use mimesh_core::mesh::CornerAttribute;
use nalgebra::{Matrix3, Matrix4, Vector3};

use super::{
    accessor::{self, numbers},
    asset::Asset,
};
use crate::gltf::document::Transforms;

/// Texture coordinates, collected over all primitives; those of an accessor are there once.
#[derive(Debug, Default)]
pub struct Textures {
    corners: CornerAttribute<[f64; 2]>,
    /// Where the coordinates of an accessor start.
    starts: HashMap<usize, u32>,
}

impl Textures {
    /// Where the coordinates of `accessor` for `count` vertices start; their origin becomes the lower left, as everywhere here.
    ///
    /// # Errors
    ///
    /// Those of the accessor, and another count than that of the vertices.
    pub fn start(&mut self, asset: &Asset, accessor: Index<Accessor>, count: usize) -> Result<u32, String> {
        check_count("texture coordinates", accessor::count(asset, accessor)?, count)?;
        if let Some(&first) = self.starts.get(&accessor.value()) {
            return Ok(first);
        }
        let values = numbers::<2>(asset, accessor)?;
        check_count("texture coordinates", values.len(), count)?;
        let first = self.corners.values.len() as u32;
        self.corners.values.extend(values.into_iter().map(|[u, v]| finite([u, 1.0 - v])));
        self.starts.insert(accessor.value(), first);
        Ok(first)
    }

    /// Adds the corners of triangles, whose coordinates start at `first`, or that have none.
    pub fn add(&mut self, first: Option<u32>, triangles: &[[u32; 3]]) {
        self.corners.indices.extend(triangles.as_flattened().iter().map(|v| first.map(|first| first + v)));
    }

    /// The attribute, if any corner has it.
    pub fn finish(self) -> Option<CornerAttribute<[f64; 2]>> {
        self.corners.indices.iter().any(Option::is_some).then_some(self.corners)
    }
}

/// Normals, collected over all primitives.
#[derive(Debug, Default)]
pub struct Normals {
    corners: CornerAttribute<[f64; 3]>,
    /// Where the normals of an accessor start, for each run of vertices that has them.
    starts: HashMap<(usize, usize), u32>,
}

impl Normals {
    /// Where the normals of `accessor` for `count` vertices start, in the scene as the transforms of their run turn them.
    ///
    /// # Errors
    ///
    /// Those of the accessor, and another count than that of the vertices.
    pub fn start(
        &mut self,
        asset: &Asset,
        accessor: Index<Accessor>,
        count: usize,
        (run, transforms): (usize, &Transforms),
    ) -> Result<u32, String> {
        if let Some(&first) = self.starts.get(&(run, accessor.value())) {
            return Ok(first);
        }
        let values = numbers::<3>(asset, accessor)?;
        check_count("normals", values.len(), count)?;
        let first = self.corners.values.len() as u32;
        match transforms {
            Transforms::Uniform(matrix) => {
                let turn = turn(matrix);
                self.corners.values.extend(values.into_iter().map(|normal| turned(turn.as_ref(), normal)));
            }
            Transforms::Skinned(matrices) => {
                let pairs = values.into_iter().zip(matrices);
                self.corners.values.extend(pairs.map(|(normal, matrix)| turned(turn(matrix).as_ref(), normal)));
            }
        }
        self.starts.insert((run, accessor.value()), first);
        Ok(first)
    }

    /// Adds the corners of triangles, whose normals start at `first`, or that have none.
    pub fn add(&mut self, first: Option<u32>, triangles: &[[u32; 3]]) {
        self.corners.indices.extend(triangles.as_flattened().iter().map(|v| first.map(|first| first + v)));
    }

    /// The attribute, if any corner has it.
    pub fn finish(self) -> Option<CornerAttribute<[f64; 3]>> {
        self.corners.indices.iter().any(Option::is_some).then_some(self.corners)
    }
}

/// Colours of vertices, collected over all primitives.
#[derive(Debug, Default)]
pub struct Colors {
    values: Vec<[f64; 4]>,
    /// What was read already: the accessor of primitives that share their vertices.
    read: HashSet<(usize, usize)>,
}

impl Colors {
    /// Reads those of `accessor` for `count` vertices from `first` on, as sRGB and opacity; other vertices are white.
    ///
    /// # Errors
    ///
    /// Those of the accessor, and another count than that of the vertices.
    pub fn add(
        &mut self,
        asset: &Asset,
        accessor: Index<Accessor>,
        (first, count): (usize, usize),
    ) -> Result<(), String> {
        if !self.read.insert((accessor.value(), first)) {
            return Ok(());
        }
        let opaque = |values: Vec<[f64; 3]>| values.into_iter().map(|[r, g, b]| [r, g, b, 1.0]).collect();
        let values = numbers::<4>(asset, accessor).or_else(|_| numbers::<3>(asset, accessor).map(opaque))?;
        check_count("colours", values.len(), count)?;
        self.values.resize(self.values.len().max(first + count), [1.0; 4]);
        let values =
            values.into_iter().map(|[r, g, b, opacity]| finite([srgb(r), srgb(g), srgb(b), opacity.clamp(0.0, 1.0)]));
        self.values.splice(first..first + count, values);
        Ok(())
    }

    /// The colours up to the last vertex that has one, if any has.
    pub fn finish(self) -> Option<Vec<[f64; 4]>> {
        (!self.values.is_empty()).then_some(self.values)
    }
}

/// A linear part of a colour as sRGB.
fn srgb(x: f64) -> f64 {
    let x = x.clamp(0.0, 1.0);
    if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 }
}

/// The matrix that normals follow; `None` if they stay.
fn turn(matrix: &Matrix4<f64>) -> Option<Matrix3<f64>> {
    let linear: Matrix3<f64> = matrix.fixed_view::<3, 3>(0, 0).into();
    (linear != Matrix3::identity()).then(|| linear.try_inverse().unwrap_or_else(Matrix3::identity).transpose())
}

fn turned(turn: Option<&Matrix3<f64>>, normal: [f64; 3]) -> [f64; 3] {
    finite(turn.map_or(normal, |turn| (turn * Vector3::from(normal)).normalize().into()))
}

fn check_count(what: &str, found: usize, expected: usize) -> Result<(), String> {
    if found == expected { Ok(()) } else { Err(format!("{found} {what} for {expected} vertices")) }
}

/// Exporters do write NaN for what they cannot compute; no stage depends on these.
fn finite<const N: usize>(values: [f64; N]) -> [f64; N] {
    if values.iter().all(|x| x.is_finite()) { values } else { [0.0; N] }
}
