//! Ŝ_g of eq. 21, from which the rotation of a region is read, as a linear function of the maps.

use mimesh_core::{mesh::Surface, stage::Regions};
use nalgebra::{DMatrix, Matrix3, Vector3};
use pulp::{Arch, NullaryFnOnce};

use crate::{edges::Edges, handle_space::add};

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
        Arch::new().dispatch(Sums { rows, edges, surface, regions, of_maps: &mut of_maps, at_rest: &mut at_rest });
        Self { of_maps, at_rest }
    }
}

/// Sums up the covariances.
struct Sums<'a> {
    rows: &'a DMatrix<f64>,
    edges: &'a Edges,
    surface: &'a Surface,
    regions: &'a Regions,
    of_maps: &'a mut DMatrix<f64>,
    at_rest: &'a mut [Matrix3<f64>],
}

// Inlined into the function that the processor's instructions are chosen for.
impl NullaryFnOnce for Sums<'_> {
    type Output = ();

    #[inline(always)]
    fn call(mut self) {
        let Self { edges, surface, regions, .. } = self;
        let p = &surface.positions;
        // A vertex is in the spokes of its own region and in those of its neighbours, which mostly are the same.
        for (i, &own) in regions.of_vertex.iter().enumerate() {
            let mut in_own = edges.curvature[i];
            for &(j, w) in edges.of(i) {
                let spoke = (p[i] - p[j as usize]) * w;
                let region = regions.of_vertex[j as usize];
                if region == own { in_own += spoke } else { self.add(region, i, spoke) }
            }
            self.add(own, i, in_own);
        }
    }
}

impl Sums<'_> {
    /// Adds `c` × the vertex to a region.
    #[inline(always)]
    fn add(&mut self, region: u32, vertex: usize, c: Vector3<f64>) {
        let (p, size) = (&self.surface.positions, self.rows.nrows());
        let row = &self.rows.as_slice()[vertex * size..][..size];
        let columns = &mut self.of_maps.as_mut_slice()[3 * region as usize * size..][..3 * size];
        for (column, c) in columns.chunks_exact_mut(size).zip(&c) {
            add(*c, row, column);
        }
        // The c of a region sum to 0, so any origin will do.
        self.at_rest[region as usize] += c * (p[vertex] - p[0]).transpose();
    }
}
