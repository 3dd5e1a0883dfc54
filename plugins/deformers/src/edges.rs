//! The edges of a surface with their weights, as rows of the Laplacian.

use mimesh_core::{mesh::Surface, operators::cotangent_laplacian};
use nalgebra::Vector3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Weights of edges in E_arap.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum EdgeWeights {
    /// Cotangents, which make the rigidity independent of the triangulation; 0 where they are negative, opposite obtuse
    /// angles.
    #[default]
    Cotangent,
    /// Cotangents as they are, as in the paper. In a small region negative ones may prevail; its energy then has no least
    /// value at a rigid motion, but at one turned against it.
    SignedCotangent,
    /// All edges alike, as much as an edge between equilateral triangles.
    Uniform,
}

/// Weight of an edge between two equilateral triangles, ½ (cot 60° + cot 60°).
const EQUILATERAL: f64 = 0.577_350_269_189_625_8;

/// The edges, row by row of L: for each vertex its neighbours j with w̃ᵢⱼ.
#[derive(Clone, Debug)]
pub(crate) struct Edges {
    /// Where the neighbours of each vertex start, #V + 1.
    starts: Vec<usize>,
    neighbours: Vec<(u32, f64)>,
    /// For each vertex Σⱼ w̃ᵢⱼ (pᵢ − pⱼ), the row of L p.
    pub curvature: Vec<Vector3<f64>>,
}

impl Edges {
    pub(crate) fn new(surface: &Surface, weights: EdgeWeights) -> Self {
        let lower = cotangent_laplacian(&surface.positions, &surface.triangles);
        let mut rows = vec![Vec::new(); surface.vertex_count()];
        for (i, j, &value) in lower.triplet_iter().filter(|(i, j, _)| i > j) {
            let weight = match weights {
                EdgeWeights::Cotangent => (-value).max(0.0),
                EdgeWeights::SignedCotangent => -value,
                EdgeWeights::Uniform => EQUILATERAL,
            };
            rows[i].push((j as u32, weight));
            rows[j].push((i as u32, weight));
        }
        let p = &surface.positions;
        let curvature = rows
            .iter()
            .enumerate()
            .map(|(i, row)| row.iter().map(|&(j, w)| (p[i] - p[j as usize]) * w).sum())
            .collect();
        let starts = std::iter::once(0)
            .chain(rows.iter().scan(0, |end, row| {
                *end += row.len();
                Some(*end)
            }))
            .collect();
        Self { starts, neighbours: rows.concat(), curvature }
    }

    /// The neighbours of vertex `i` and the weights of the edges to them.
    pub(crate) fn of(&self, i: usize) -> &[(u32, f64)] {
        &self.neighbours[self.starts[i]..self.starts[i + 1]]
    }
}
