//! E4: orphan components keep the lengths of their Laplacian coordinates.

use mimesh_core::{linalg::Assembly, mesh::Surface, operators::cotangent_laplacian};
use nalgebra::{Matrix3, Point3, Vector3};
use nalgebra_sparse::CscMatrix;

use super::sideways::Sideways;

/// E4 of orphan components.
#[derive(Debug)]
pub struct Detail {
    laplacian: CscMatrix<f64>,
    /// Vertices of orphan components.
    vertices: Vec<u32>,
    /// ‖(L v)ᵢ‖ at rest.
    lengths: Vec<f64>,
    weight: f64,
}

impl Detail {
    /// Adds w4 LᵀL of orphan components to the matrix.
    pub fn new(
        target: &Surface,
        weight: f64,
        is_orphan: impl Fn(u32) -> bool,
        assembly: &mut Assembly,
    ) -> Option<Self> {
        let triangles: Vec<[u32; 3]> = target.triangles.iter().copied().filter(|t| is_orphan(t[0])).collect();
        if triangles.is_empty() || weight == 0.0 {
            return None;
        }
        let lower = cotangent_laplacian(&target.positions, &triangles);
        let mut full = nalgebra_sparse::CooMatrix::new(lower.nrows(), lower.ncols());
        for (i, j, &value) in lower.triplet_iter() {
            full.push(i, j, value);
            if i != j {
                full.push(j, i, value);
            }
        }
        let laplacian = CscMatrix::from(&full);
        let mut vertices: Vec<u32> = triangles.iter().flatten().copied().collect();
        vertices.sort_unstable();
        vertices.dedup();
        for &v in &vertices {
            let column = laplacian.col(v as usize);
            let indices: Vec<u32> = column.row_indices().iter().map(|&i| i as u32).collect();
            let rows: Vec<[f64; 1]> = column.values().iter().map(|&x| [x]).collect();
            assembly.add_outer(&indices, &rows, weight);
        }
        let lengths =
            coordinates(&laplacian, &vertices, |v| target.positions[v].coords).iter().map(Vector3::norm).collect();
        Some(Self { laplacian, vertices, lengths, weight })
    }

    /// δ̂ᵢ = (L x)ᵢ ‖(L v)ᵢ‖ / ‖(L x)ᵢ‖: the direction from now, the length from rest.
    pub fn goals(&self, now: &[Point3<f64>]) -> Vec<Vector3<f64>> {
        let coordinates = coordinates(&self.laplacian, &self.vertices, |v| now[v].coords);
        let goal = |(d, length): (&Vector3<f64>, &f64)| d.try_normalize(1e-300).unwrap_or_default() * *length;
        coordinates.iter().zip(&self.lengths).map(goal).collect()
    }

    /// Adds what draws to Laplacian coordinates `goals` to the right-hand side.
    pub fn add_rhs(&self, goals: &[Vector3<f64>], x: &mut [f64]) {
        let n = x.len() / 3;
        for (&v, goal) in self.vertices.iter().zip(goals) {
            let column = self.laplacian.col(v as usize);
            for (&i, &value) in column.row_indices().iter().zip(column.values()) {
                (0..3).for_each(|c| x[c * n + i] += self.weight * value * goal[c]);
            }
        }
    }

    /// The Laplacian coordinates at rest, turned by what `rotation` says of each vertex.
    pub fn turned(&self, rest: &[Point3<f64>], rotation: impl Fn(u32) -> Matrix3<f64>) -> Vec<Vector3<f64>> {
        let at_rest = coordinates(&self.laplacian, &self.vertices, |v| rest[v].coords);
        self.vertices.iter().zip(at_rest).map(|(&v, d)| rotation(v) * d).collect()
    }

    /// By how much the matrix is stiffer than E4 sideways of the directions at `now`.
    pub fn sideways(&self, now: &[Point3<f64>]) -> Vec<Sideways> {
        let now = coordinates(&self.laplacian, &self.vertices, |v| now[v].coords);
        now.into_iter().zip(&self.lengths).map(|(d, &length)| Sideways::new(d, length, self.weight)).collect()
    }

    /// Subtracts the product of what [`sideways`](Self::sideways) gave and `direction` (3 × unknowns, by coordinates).
    pub fn subtract_sideways(&self, sideways: &[Sideways], direction: &[f64], product: &mut [f64]) {
        let n = direction.len() / 3;
        let at = |v: usize| Vector3::new(direction[v], direction[n + v], direction[2 * n + v]);
        let of_direction = coordinates(&self.laplacian, &self.vertices, at);
        for ((&v, d), sideways) in self.vertices.iter().zip(of_direction).zip(sideways) {
            let force = sideways.of(d);
            let column = self.laplacian.col(v as usize);
            for (&i, &value) in column.row_indices().iter().zip(column.values()) {
                (0..3).for_each(|c| product[c * n + i] -= value * force[c]);
            }
        }
    }

    /// E4 at `now`.
    pub fn energy(&self, now: &[Point3<f64>]) -> f64 {
        let coordinates = coordinates(&self.laplacian, &self.vertices, |v| now[v].coords);
        let difference = |(d, length): (&Vector3<f64>, &f64)| (d.norm() - length).powi(2);
        self.weight * coordinates.iter().zip(&self.lengths).map(difference).sum::<f64>()
    }
}

/// (L x)ᵢ of some vertices, x being at `position` of each.
fn coordinates(
    laplacian: &CscMatrix<f64>,
    vertices: &[u32],
    position: impl Fn(usize) -> Vector3<f64>,
) -> Vec<Vector3<f64>> {
    let at = |&v: &u32| {
        let column = laplacian.col(v as usize);
        column.row_indices().iter().zip(column.values()).map(|(&i, &w)| position(i) * w).sum()
    };
    vertices.iter().map(at).collect()
}
