//! Ŝ_g of eq. 21, from which the rotation of a region is read, as a linear function of the maps.

use mimesh_core::{mesh::Surface, stage::Regions};
use nalgebra::{DMatrix, Matrix3, Vector3};

use crate::edges::Edges;

/// Covariances of the regions, for the local step: Ŝ_g = Σ w̃ᵢⱼ (pᵢ − pⱼ)(qᵢ − qⱼ)ᵀ over the spokes of region g, for q = p + M X.
#[derive(Clone, Debug)]
pub(crate) struct Covariances {
    /// Kᵀ, 4h × 3g: Ŝ_g changes by rows 3g to 3g + 2 of K X.
    pub of_maps: DMatrix<f64>,
    /// Ŝ_g at rest, symmetric.
    pub at_rest: Vec<Matrix3<f64>>,
}

impl Covariances {
    /// The covariances for Mᵀ = `rows`, 4h × #V.
    pub(crate) fn new(rows: &DMatrix<f64>, edges: &Edges, surface: &Surface, regions: &Regions) -> Self {
        let size = rows.nrows();
        let mut of_maps = DMatrix::zeros(size, 3 * regions.count);
        let mut at_rest = vec![Matrix3::zeros(); regions.count];
        let p = &surface.positions;
        let mut add = |region: u32, vertex: usize, c: Vector3<f64>| {
            let row = &rows.as_slice()[vertex * size..][..size];
            let columns = &mut of_maps.as_mut_slice()[3 * region as usize * size..][..3 * size];
            for (column, c) in columns.chunks_exact_mut(size).zip(&c) {
                column.iter_mut().zip(row).for_each(|(sum, m)| *sum += c * m);
            }
            // The c of a region sum to 0, so any origin will do.
            at_rest[region as usize] += c * (p[vertex] - p[0]).transpose();
        };
        // A vertex is in the spokes of its own region and in those of its neighbours, which mostly are the same.
        for (i, &own) in regions.of_vertex.iter().enumerate() {
            let mut in_own = edges.curvature[i];
            for &(j, w) in edges.of(i) {
                let spoke = (p[i] - p[j as usize]) * w;
                let region = regions.of_vertex[j as usize];
                if region == own { in_own += spoke } else { add(region, i, spoke) }
            }
            add(own, i, in_own);
        }
        Self { of_maps, at_rest }
    }
}
