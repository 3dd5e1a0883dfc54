//! Edges and triangles of a surface that have a size at rest, and how it changes in a pose.

use mimesh_core::mesh::Surface;
use nalgebra::Point3;
use rayon::prelude::*;

/// Sizes below this part of the diagonal are noise: a file of six decimals rounds such a length by a tenth.
pub const SMALLEST: f64 = 1e-5;

/// Edges (N = 2) or triangles (N = 3) with their lengths or areas at rest.
pub struct Elements<const N: usize> {
    /// Their vertices.
    pub corners: Vec<[u32; N]>,
    /// Their sizes at rest.
    pub rest: Vec<f64>,
    /// How many were left out.
    pub left_out: usize,
    size: fn(&[Point3<f64>; N]) -> f64,
    /// Smaller sizes count as this, so that what vanishes has a finite logarithm.
    floor: f64,
}

impl<const N: usize> Elements<N> {
    /// Logarithms of the sizes at `posed` relative to rest; NaN where a coordinate is not finite.
    pub fn logarithms(&self, posed: &[Point3<f64>]) -> Vec<f64> {
        let logarithm = |(corners, rest): (&[u32; N], &f64)| {
            let size = (self.size)(&corners.map(|v| posed[v as usize]));
            // f64::max would hide NaN.
            if size.is_finite() { (size.max(self.floor) / rest).ln() } else { f64::NAN }
        };
        self.corners.par_iter().zip(&self.rest).with_min_len(4096).map(logarithm).collect()
    }

    fn new(
        surface: &Surface,
        all: &[[u32; N]],
        size: fn(&[Point3<f64>; N]) -> f64,
        floor: f64,
        thickness: impl Fn(&[Point3<f64>; N], f64) -> f64,
    ) -> Self {
        let smallest = SMALLEST * surface.diagonal();
        let (mut corners, mut rest) = (Vec::with_capacity(all.len()), Vec::with_capacity(all.len()));
        for &element in all {
            let points = element.map(|v| surface.positions[v as usize]);
            let at_rest = size(&points);
            if thickness(&points, at_rest) > smallest {
                corners.push(element);
                rest.push(at_rest);
            }
        }
        let left_out = all.len() - corners.len();
        Self { corners, rest, left_out, size, floor }
    }
}

/// The edges of triangles, each once; those shorter than [`SMALLEST`] of the diagonal are left out.
pub fn edges(surface: &Surface) -> Elements<2> {
    let floor = SMALLEST * surface.diagonal();
    Elements::new(surface, &ends(surface), length, floor, |_, length| length)
}

/// The triangles; those of a height below [`SMALLEST`] of the diagonal are left out.
pub fn triangles(surface: &Surface) -> Elements<3> {
    let floor = (SMALLEST * surface.diagonal()).powi(2);
    Elements::new(surface, &surface.triangles, area, floor, |[a, b, c], area| {
        let longest = (b - a).norm().max((c - b).norm()).max((a - c).norm());
        if longest > 0.0 { 2.0 * area / longest } else { 0.0 }
    })
}

/// The edges of a surface, smaller vertex first, each once, sorted.
pub fn ends(surface: &Surface) -> Vec<[u32; 2]> {
    let mut ends: Vec<[u32; 2]> = Vec::with_capacity(3 * surface.triangle_count());
    for &[a, b, c] in &surface.triangles {
        ends.extend([[a, b], [b, c], [c, a]].into_iter().filter(|[u, v]| u != v).map(|[u, v]| [u.min(v), u.max(v)]));
    }
    ends.sort_unstable();
    ends.dedup();
    ends
}

fn length([a, b]: &[Point3<f64>; 2]) -> f64 {
    (b - a).norm()
}

fn area([a, b, c]: &[Point3<f64>; 3]) -> f64 {
    (b - a).cross(&(c - a)).norm() / 2.0
}
