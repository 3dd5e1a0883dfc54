//! The energy ½ wᵀ L M⁻¹ L w of weights over one group of vertices.

use mimesh_core::linalg::Assembly;
use nalgebra_sparse::CscMatrix;

/// Q = L M⁻¹ L of a group of vertices, with M relative to its mean: the mean times what it is in the unit of the file.
#[derive(Debug)]
pub struct Bilaplacian {
    /// Q, its lower triangle.
    pub matrix: CscMatrix<f64>,
    /// L, its lower triangle.
    pub laplacian: CscMatrix<f64>,
    /// The diagonal of M⁻¹.
    pub inverse_mass: Vec<f64>,
}

impl Bilaplacian {
    /// The energy by `laplacian`, the lower triangle of L, and `mass`, the diagonal of M.
    pub fn new(laplacian: &CscMatrix<f64>, mass: &[f64]) -> Self {
        let n = mass.len();
        let mut rows: Vec<(Vec<u32>, Vec<[f64; 1]>)> = vec![Default::default(); n];
        for (i, j, &value) in laplacian.triplet_iter() {
            let mut push = |i: usize, j: usize| {
                rows[i].0.push(j as u32);
                rows[i].1.push([value]);
            };
            push(i, j);
            if i != j {
                push(j, i);
            }
        }
        let inverse_mass: Vec<f64> = mass.iter().map(|m| 1.0 / m).collect();
        let mut assembly = Assembly::new(n);
        for ((indices, values), &inverse) in rows.iter().zip(&inverse_mass) {
            assembly.add_outer(indices, values, inverse);
        }
        Self { matrix: assembly.finish(), laplacian: laplacian.clone(), inverse_mass }
    }

    /// ½ xᵀ Q x and Q x, through L twice: the product with Q itself would lose the digits that smooth x share.
    pub fn energy_and_gradient(&self, x: &[f64]) -> (f64, Vec<f64>) {
        let lx = product(&self.laplacian, x);
        let scaled: Vec<f64> = lx.iter().zip(&self.inverse_mass).map(|(y, inverse)| y * inverse).collect();
        (0.5 * lx.iter().zip(&scaled).map(|(y, s)| y * s).sum::<f64>(), product(&self.laplacian, &scaled))
    }

    /// The values of Q, in the order of its entries, with the rows and columns of the unknowns that are `held` made those of the
    /// identity, so that the pattern stays the same for all choices.
    pub fn without(&self, held: &[bool]) -> Vec<f64> {
        without(&self.matrix, held)
    }
}

/// The values of a matrix, in the order of its entries, with the rows and columns of `held` made those of the identity.
pub fn without(matrix: &CscMatrix<f64>, held: &[bool]) -> Vec<f64> {
    let cut = |(i, j, &value): (usize, usize, &f64)| match (held[i] || held[j], i == j) {
        (false, _) => value,
        (true, true) => 1.0,
        (true, false) => 0.0,
    };
    matrix.triplet_iter().map(cut).collect()
}

/// A x of the symmetric matrix whose lower triangle is `lower`.
fn product(lower: &CscMatrix<f64>, x: &[f64]) -> Vec<f64> {
    let mut y = vec![0.0; x.len()];
    for (j, column) in lower.col_iter().enumerate() {
        let mut sum = 0.0;
        for (&i, &value) in column.row_indices().iter().zip(column.values()) {
            sum += value * x[i];
            if i != j {
                y[i] += value * x[j];
            }
        }
        y[j] += sum;
    }
    y
}
