use super::newton::{Entries, LANES, newton};
use nalgebra::{Matrix3, Rotation3, Unit, Vector3};

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
/// Scaled Newton iteration (Higham 1986); where F is singular, turned inside out or badly scaled, by singular values instead, with the
/// axis of the smallest one flipped where that makes R a rotation.
pub fn polar(f: &Matrix3<f64>) -> Polar {
    let (found, is_found) = newton(&std::array::from_fn(|e| [f[e]]));
    let rotation = if is_found[0] { Matrix3::from_fn(|i, j| found[3 * j + i][0]) } else { nearest_rotation(f) };
    let stretch = rotation.transpose() * f;
    Polar { rotation, stretch: (stretch + stretch.transpose()) / 2.0 }
}

/// The rotations of many finite F: those of [`polar`] to the last bit, in a third of the time.
pub fn rotations(all: &[Matrix3<f64>]) -> Vec<Matrix3<f64>> {
    let several = |several: &[Matrix3<f64>]| {
        let lanes: Entries<LANES> =
            std::array::from_fn(|e| std::array::from_fn(|k| several.get(k).map_or(0.0, |f| f[e])));
        let (found, is_found) = newton(&lanes);
        let one = |k: usize| {
            if is_found[k] { Matrix3::from_fn(|i, j| found[3 * j + i][k]) } else { nearest_rotation(&several[k]) }
        };
        (0..several.len()).map(one).collect::<Vec<_>>()
    };
    all.chunks(LANES).flat_map(several).collect()
}

/// Uses one-sided Jacobi rotations, which turn the columns of F until they are orthogonal: F V = U Σ. Small singular values
/// keep their digits, where forming FᵀF would lose them.
fn nearest_rotation(f: &Matrix3<f64>) -> Matrix3<f64> {
    let (mut b, mut v) = (*f, Matrix3::identity());
    for _ in 0..30 {
        let mut turned = false;
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            turned |= orthogonalise(&mut b, &mut v, p, q);
        }
        if !turned {
            break;
        }
    }
    let mut order = [0, 1, 2];
    order.sort_by(|&i, &j| b.column(j).norm_squared().total_cmp(&b.column(i).norm_squared()));
    let [v1, v2, _] = order.map(|k| v.column(k).into_owned());
    // U is completed to a rotation from its two largest columns, and V alike: that flips the axis of the smallest stretch of a
    // reflection, and fills in where it is 0.
    let Some(u1) = b.column(order[0]).try_normalize(0.0) else { return Matrix3::identity() };
    let rest = b.column(order[1]) - u1 * u1.dot(&b.column(order[1]));
    let u2 = if rest.norm() > 1e-15 * b.column(order[0]).norm() {
        rest.normalize()
    } else {
        // Rank 1 leaves the turn about u1 open.
        shortest_turn(&v1, &u1) * v2
    };
    Matrix3::from_columns(&[u1, u2, u1.cross(&u2)]) * Matrix3::from_columns(&[v1, v2, v1.cross(&v2)]).transpose()
}

/// Turns columns p and q of b so that they are orthogonal, and those of v alike; whether there was anything to do.
fn orthogonalise(b: &mut Matrix3<f64>, v: &mut Matrix3<f64>, p: usize, q: usize) -> bool {
    let (p2, q2, pq) = (b.column(p).norm_squared(), b.column(q).norm_squared(), b.column(p).dot(&b.column(q)));
    if pq.abs() <= f64::EPSILON * (p2 * q2).sqrt() {
        return false;
    }
    let zeta = (q2 - p2) / (2.0 * pq);
    let t = zeta.signum() / (zeta.abs() + (1.0 + zeta * zeta).sqrt());
    let cos = 1.0 / (1.0 + t * t).sqrt();
    for m in [b, v] {
        let (x, y) = (m.column(p).into_owned(), m.column(q).into_owned());
        m.set_column(p, &((x - y * t) * cos));
        m.set_column(q, &((x * t + y) * cos));
    }
    true
}

/// The rotation by the smallest angle that takes unit vector `from` to unit vector `to`.
fn shortest_turn(from: &Vector3<f64>, to: &Vector3<f64>) -> Matrix3<f64> {
    if let Some(turn) = Rotation3::rotation_between(from, to) {
        return *turn.matrix();
    }
    let side = if from.x.abs() < 0.7 { Vector3::x() } else { Vector3::y() };
    *Rotation3::from_axis_angle(&Unit::new_normalize(from.cross(&side)), std::f64::consts::PI).matrix()
}
