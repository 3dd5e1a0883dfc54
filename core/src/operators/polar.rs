use nalgebra::Matrix3;

/// F = R S with R a rotation (det R = 1) and S symmetric.
#[derive(Clone, Copy, Debug)]
pub struct Polar {
    /// R: the rotation nearest to F in the Frobenius norm.
    pub rotation: Matrix3<f64>,
    /// S = Rᵀ F; positive definite if det F > 0.
    pub stretch: Matrix3<f64>,
}

/// The polar decomposition of a finite F.
///
/// Scaled Newton iteration (Higham 1986), which doubles its digits a step; where F is singular, turned inside out or badly
/// scaled, by singular values instead, with the sign of the smallest one flipped where that makes R a rotation.
pub fn polar(f: &Matrix3<f64>) -> Polar {
    let rotation = newton(f).unwrap_or_else(|| nearest_rotation(f));
    let stretch = rotation.transpose() * f;
    Polar { rotation, stretch: (stretch + stretch.transpose()) / 2.0 }
}

fn newton(f: &Matrix3<f64>) -> Option<Matrix3<f64>> {
    let norm = f.norm();
    let f = f / norm;
    // Far from singular and not a reflection: the iteration then keeps the sign of the determinant.
    let far_from_singular = f.determinant() > 1e-6;
    if !far_from_singular {
        return None;
    }
    let mut r = f;
    for _ in 0..20 {
        let inverse_transposed = cofactors(&r) / r.determinant();
        let scale = (inverse_transposed.norm() / r.norm()).sqrt();
        let next = (r * scale + inverse_transposed / scale) * 0.5;
        let change = (next - r).norm();
        r = next;
        if change < 1e-9 {
            // One more unscaled step takes the remaining error, now squared, to rounding.
            return Some((r + cofactors(&r) / r.determinant()) * 0.5);
        }
    }
    None
}

/// det(F) F⁻ᵀ.
fn cofactors(f: &Matrix3<f64>) -> Matrix3<f64> {
    let (a, b, c) = (f.column(0), f.column(1), f.column(2));
    Matrix3::from_columns(&[b.cross(&c), c.cross(&a), a.cross(&b)])
}

fn nearest_rotation(f: &Matrix3<f64>) -> Matrix3<f64> {
    let svd = f.svd(true, true);
    let (Some(mut u), Some(v_t)) = (svd.u, svd.v_t) else { return Matrix3::identity() };
    if (u * v_t).determinant() < 0.0 {
        // nalgebra sorts singular values from large to small.
        let flipped = -u.column(2);
        u.set_column(2, &flipped);
    }
    u * v_t
}
