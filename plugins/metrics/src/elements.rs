//! Edges and triangles of a surface that have a size at rest, and how it changes in a pose.

use mimesh_core::mesh::Surface;
use nalgebra::Point3;
use rayon::prelude::*;

/// The smallest length that is measured, relative to the diagonal: a file of six decimals rounds it by a tenth.
const MIN_LENGTH: f64 = 1e-5;

/// Edges (N = 2) or triangles (N = 3) of a surface, with their lengths or areas at rest.
pub struct Elements<const N: usize> {
    /// The vertices of each element.
    pub corners: Vec<[u32; N]>,
    /// The size of each element at rest.
    pub rest: Vec<f64>,
    /// The number of elements that were left out.
    pub left_out: usize,
    /// Smaller sizes count as this, so that an element that vanishes has a finite change.
    min_size: f64,
}

/// The corners of an edge or a triangle.
pub trait Corners: Sync {
    /// Length or area; not finite where a coordinate is not.
    fn size(&self) -> f64;
}

impl Corners for [Point3<f64>; 2] {
    fn size(&self) -> f64 {
        (self[1] - self[0]).norm()
    }
}

impl Corners for [Point3<f64>; 3] {
    fn size(&self) -> f64 {
        (self[1] - self[0]).cross(&(self[2] - self[0])).norm() / 2.0
    }
}

impl<const N: usize> Elements<N>
where
    [Point3<f64>; N]: Corners,
{
    /// The sizes at `posed`.
    pub fn sizes(&self, posed: &[Point3<f64>]) -> Vec<f64> {
        let size = |corners: &[u32; N]| corners.map(|v| posed[v as usize]).size();
        self.corners.par_iter().with_min_len(4096).map(size).collect()
    }

    /// `sizes` relative to rest; NaN where they are not finite.
    pub fn ratios(&self, sizes: &[f64]) -> Vec<f64> {
        // f64::max would hide NaN.
        let ratio =
            |(size, rest): (&f64, &f64)| if size.is_finite() { size.max(self.min_size) / rest } else { f64::NAN };
        sizes.iter().zip(&self.rest).map(ratio).collect()
    }

    /// The mean size at rest; 0 without elements.
    pub fn mean_rest(&self) -> f64 {
        self.rest.iter().sum::<f64>() / self.rest.len().max(1) as f64
    }

    fn new(
        surface: &Surface,
        all: &[[u32; N]],
        min_size: f64,
        thickness: impl Fn(&[Point3<f64>; N], f64) -> f64,
    ) -> Self {
        let min_thickness = MIN_LENGTH * surface.diagonal();
        let (mut corners, mut rest) = (Vec::with_capacity(all.len()), Vec::with_capacity(all.len()));
        for &element in all {
            let points = element.map(|v| surface.positions[v as usize]);
            let at_rest = points.size();
            if thickness(&points, at_rest) > min_thickness {
                corners.push(element);
                rest.push(at_rest);
            }
        }
        let left_out = all.len() - corners.len();
        Self { corners, rest, left_out, min_size }
    }
}

/// The edges of triangles, each once, without those shorter than [`MIN_LENGTH`] of the diagonal.
pub fn edges(surface: &Surface) -> Elements<2> {
    let min_size = MIN_LENGTH * surface.diagonal();
    Elements::new(surface, &surface.edges(), min_size, |_, length| length)
}

/// The triangles, without those of a height below [`MIN_LENGTH`] of the diagonal.
pub fn triangles(surface: &Surface) -> Elements<3> {
    let min_size = (MIN_LENGTH * surface.diagonal()).powi(2);
    Elements::new(surface, &surface.triangles, min_size, |[a, b, c], area| {
        let longest = (b - a).norm().max((c - b).norm()).max((a - c).norm());
        if longest > 0.0 { 2.0 * area / longest } else { 0.0 }
    })
}
