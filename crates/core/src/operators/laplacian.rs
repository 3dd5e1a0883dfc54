use nalgebra::Point3;
use nalgebra_sparse::CscMatrix;

use super::degenerate::is_degenerate;
use crate::linalg::Assembly;

/// The cotangent Laplacian L, #V × #V, positive semi-definite, as its lower triangle:
/// Lᵢⱼ = −½ (cot αᵢⱼ + cot βᵢⱼ), rows sum to 0.
///
/// It is without unit (Dirichlet energy ½ uᵀ L u) and equals Gᵀ A G of the [`gradients`](super::gradients). Degenerate
/// triangles are left out.
pub fn cotangent_laplacian(positions: &[Point3<f64>], triangles: &[[u32; 3]]) -> CscMatrix<f64> {
    let mut assembly = Assembly::new(positions.len());
    for t in triangles {
        let corners = t.map(|v| positions[v as usize]);
        if is_degenerate(&corners) {
            continue;
        }
        for k in 0..3 {
            let (apex, i, j) = (corners[k], (k + 1) % 3, (k + 2) % 3);
            let (u, v) = (corners[i] - apex, corners[j] - apex);
            let half_cotangent = 0.5 * u.dot(&v) / u.cross(&v).norm();
            assembly.add_outer(&[t[i], t[j]], &[[1.0], [-1.0]], half_cotangent);
        }
    }
    assembly.finish()
}
