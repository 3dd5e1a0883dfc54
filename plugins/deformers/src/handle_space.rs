//! Positions as linear functions of the maps of handles: q = p + M X.
//!
//! X (4h × 3) are the maps minus the identity, each in the frame of its handle: row i of M holds for each handle k
//! Wᵢₖ [(pᵢ − cₖ) / sₖ, 1], where cₖ is the centre and sₖ the radius (root mean square) of what handle k moves. So a unit of X
//! moves vertices by about a unit of length, whichever entry it is, and nothing is lost where a mesh lies far from its origin.

use faer::{
    Accum, MatMut, MatRef, Par,
    linalg::matmul::{
        matmul,
        triangular::{self, BlockStructure},
    },
};
use mimesh_core::{Error, Result, stage::HandleWeights};
use nalgebra::{DMatrix, Matrix3, Point3, Vector3};
use pulp::{Arch, NullaryFnOnce};

use crate::edges::Edges;

/// How far the sum of a row of W may be from 1.
const MAX_ROW_SUM_ERROR: f64 = 1e-6;

/// M with the frames of the handles.
#[derive(Clone, Debug)]
pub(crate) struct HandleSpace {
    /// Mᵀ, 4h × #V: a column a vertex.
    rows: DMatrix<f64>,
    /// cₖ.
    pub centres: Vec<Point3<f64>>,
    /// sₖ.
    pub radii: Vec<f64>,
}

impl HandleSpace {
    /// # Errors
    ///
    /// [`Error::Shape`] if W does not have a row a vertex, [`Error::Data`] if it has no column, is not finite or a row does not
    /// sum to 1.
    pub(crate) fn new(rest: &[Point3<f64>], weights: &HandleWeights) -> Result<Self> {
        let w = &weights.matrix;
        check_weights(w, rest.len())?;
        let (all, radius) = centre_and_radius(rest.iter().map(|p| (p, 1.0))).unwrap_or((Point3::origin(), 0.0));
        let (mut centres, mut radii) = (Vec::new(), Vec::new());
        for column in w.column_iter() {
            let (centre, own) = centre_and_radius(rest.iter().zip(column.iter().copied())).unwrap_or((all, radius));
            centres.push(centre);
            // A handle that moves one vertex only has no extent of its own, and a mesh without extent none at all.
            radii.push(own.max(1e-3 * radius).max(f64::MIN_POSITIVE.sqrt()));
        }
        let mut rows = DMatrix::zeros(4 * w.ncols(), rest.len());
        for (k, (column, (c, s))) in w.column_iter().zip(centres.iter().zip(&radii)).enumerate() {
            for (i, (p, &weight)) in rest.iter().zip(column.iter()).enumerate() {
                if weight != 0.0 {
                    let x = (p - c) * (weight / s);
                    rows.as_mut_slice()[i * 4 * w.ncols() + 4 * k..][..4].copy_from_slice(&[x.x, x.y, x.z, weight]);
                }
            }
        }
        Ok(Self { rows, centres, radii })
    }

    /// 4h.
    pub(crate) fn size(&self) -> usize {
        self.rows.nrows()
    }

    /// Mᵀ.
    pub(crate) fn rows(&self) -> &DMatrix<f64> {
        &self.rows
    }

    /// Mᵀ (`factor` L + D), 4h × #V, with the diagonal D.
    pub(crate) fn laplacian(&self, edges: &Edges, factor: f64, diagonal: &[f64]) -> DMatrix<f64> {
        let mut result = DMatrix::zeros(self.size(), self.rows.ncols());
        Arch::new().dispatch(Laplacian { rows: &self.rows, edges, factor, diagonal, result: &mut result });
        result
    }

    /// Mᵀ D, 4h × #V, with the diagonal D.
    pub(crate) fn scaled(&self, diagonal: &[f64]) -> DMatrix<f64> {
        let mut result = self.rows.clone();
        result.column_iter_mut().zip(diagonal).for_each(|(mut column, d)| column *= *d);
        result
    }

    /// Mᵀ `other`ᵀ, of which the result is known to be symmetric, 4h × 4h.
    pub(crate) fn symmetric_product(&self, other: &DMatrix<f64>) -> DMatrix<f64> {
        symmetric_product(&self.rows, other)
    }

    /// Mᵀ D `field`, 4h × 3, with the diagonal D.
    pub(crate) fn project(&self, factors: &[f64], field: &[Vector3<f64>]) -> DMatrix<f64> {
        let weighted: Vec<f64> = factors.iter().zip(field).flat_map(|(d, x)| [d * x.x, d * x.y, d * x.z]).collect();
        let mut result = DMatrix::zeros(self.size(), 3);
        let field = MatRef::from_row_major_slice(&weighted, field.len(), 3);
        matmul(view_mut(&mut result), Accum::Replace, view(&self.rows), field, 1.0, Par::Seq);
        result
    }

    /// M X, #V.
    pub(crate) fn displacements(&self, x: &DMatrix<f64>) -> Vec<Vector3<f64>> {
        let mut result = DMatrix::zeros(3, self.rows.ncols());
        matmul(view_mut(&mut result), Accum::Replace, view(x).transpose(), view(&self.rows), 1.0, Par::Seq);
        result.column_iter().map(|column| column.fixed_rows::<3>(0).into_owned()).collect()
    }

    /// The map of handle `k` in the frame of the mesh: p ↦ p + Xₖᵀ [(p − cₖ) / sₖ; 1].
    pub(crate) fn map(&self, x: &DMatrix<f64>, k: usize) -> (Matrix3<f64>, Vector3<f64>) {
        let linear = x.fixed_view::<3, 3>(4 * k, 0).transpose() / self.radii[k];
        let shift = x.fixed_view::<1, 3>(4 * k + 3, 0).transpose() - linear * self.centres[k].coords;
        (Matrix3::identity() + linear, shift)
    }
}

/// `result` += Mᵀ (`factor` L + D).
struct Laplacian<'a> {
    rows: &'a DMatrix<f64>,
    edges: &'a Edges,
    factor: f64,
    diagonal: &'a [f64],
    result: &'a mut DMatrix<f64>,
}

// Inlined into the function that the processor's instructions are chosen for.
impl NullaryFnOnce for Laplacian<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { rows, edges, factor, diagonal, result } = self;
        let size = rows.nrows();
        let columns = result.as_mut_slice().chunks_exact_mut(size).zip(rows.as_slice().chunks_exact(size));
        for (i, ((out, own), d)) in columns.zip(diagonal).enumerate() {
            let mut sum = *d;
            for &(j, w) in edges.of(i) {
                let w = factor * w;
                sum += w;
                add(-w, &rows.as_slice()[j as usize * size..][..size], out);
            }
            add(sum, own, out);
        }
    }
}

/// `to` += `factor` × `row`.
#[inline(always)]
pub(crate) fn add(factor: f64, row: &[f64], to: &mut [f64]) {
    for (to, m) in to.iter_mut().zip(row) {
        *to += factor * m;
    }
}

/// `a` `b`ᵀ of two matrices with as many columns, known to be symmetric; half of it is computed.
pub(crate) fn symmetric_product(a: &DMatrix<f64>, b: &DMatrix<f64>) -> DMatrix<f64> {
    let mut result = DMatrix::zeros(a.nrows(), a.nrows());
    triangular::matmul(
        view_mut(&mut result),
        BlockStructure::TriangularLower,
        Accum::Replace,
        view(a),
        BlockStructure::Rectangular,
        view(b).transpose(),
        BlockStructure::Rectangular,
        1.0,
        Par::Seq,
    );
    result.fill_upper_triangle_with_lower_triangle();
    result
}

/// `a`ᵀ `b`.
pub(crate) fn transposed_product(a: &DMatrix<f64>, b: &DMatrix<f64>) -> DMatrix<f64> {
    let mut result = DMatrix::zeros(a.ncols(), b.ncols());
    matmul(view_mut(&mut result), Accum::Replace, view(a).transpose(), view(b), 1.0, Par::Seq);
    result
}

fn check_weights(w: &DMatrix<f64>, vertices: usize) -> Result<()> {
    Error::check_shape("rows of the weights (#V)", vertices, w.nrows())?;
    for i in 0..vertices {
        let sum = w.row(i).sum();
        let close = (sum - 1.0).abs() <= MAX_ROW_SUM_ERROR;
        if !close {
            return Err(Error::data(
                format!("the weights of vertex {i} (from 0) sum to {sum}: expected 1"),
                "divide each row of the weights by its sum; a vertex that no handle reaches needs a handle near it",
            ));
        }
    }
    Ok(())
}

fn centre_and_radius<'a>(points: impl Iterator<Item = (&'a Point3<f64>, f64)> + Clone) -> Option<(Point3<f64>, f64)> {
    // Weights that are not bounded may be negative.
    let total: f64 = points.clone().map(|(_, w)| w.abs()).sum();
    let has_weight = total > 0.0;
    if !has_weight {
        return None;
    }
    let centre = Point3::from(points.clone().map(|(p, w)| p.coords * w.abs()).sum::<Vector3<f64>>() / total);
    let square = points.map(|(p, w)| (p - centre).norm_squared() * w.abs()).sum::<f64>() / total;
    Some((centre, square.sqrt()))
}

fn view(matrix: &DMatrix<f64>) -> MatRef<'_, f64> {
    MatRef::from_column_major_slice(matrix.as_slice(), matrix.nrows(), matrix.ncols())
}

fn view_mut(matrix: &mut DMatrix<f64>) -> MatMut<'_, f64> {
    let (rows, columns) = matrix.shape();
    MatMut::from_column_major_slice_mut(matrix.as_mut_slice(), rows, columns)
}
