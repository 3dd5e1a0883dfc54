//! Logarithms of rotations, and means of deformation gradients by them.

use nalgebra::{Matrix3, Quaternion, Rotation3, UnitQuaternion, Vector3};

use super::polar;

/// A deformation gradient F = R S, with R as a unit quaternion.
///
/// Of the two quaternions ±q of a rotation, the sign tells how the rotation was reached: q₁⁻¹ q₂ is the turn by up to a full
/// turn that leads from one to the other, where rotations alone know only the shorter way. [`logarithm`] keeps it.
#[derive(Clone, Copy, Debug)]
pub struct Turn {
    /// q, of either sign.
    pub quaternion: UnitQuaternion<f64>,
    /// S, symmetric.
    pub stretch: Matrix3<f64>,
}

impl Turn {
    /// The parts of a finite F, by its polar decomposition.
    pub fn of(f: &Matrix3<f64>) -> Self {
        let parts = polar(f);
        let rotation = Rotation3::from_matrix_unchecked(parts.rotation);
        Self { quaternion: UnitQuaternion::from_rotation_matrix(&rotation), stretch: parts.stretch }
    }

    /// F.
    pub fn gradient(&self) -> Matrix3<f64> {
        self.quaternion.to_rotation_matrix().into_inner() * self.stretch
    }

    /// The turn between `self` (`share` = 0) and `other` (`share` = 1) by the shorter way: rotations along a geodesic, stretches
    /// along a line.
    pub fn towards(&self, other: &Self, share: f64) -> Self {
        let way = logarithm(&(self.quaternion.inverse() * nearer(&other.quaternion, &self.quaternion)));
        Self {
            quaternion: self.quaternion * UnitQuaternion::from_scaled_axis(way * share),
            stretch: self.stretch * (1.0 - share) + other.stretch * share,
        }
    }
}

/// The logarithm of a rotation as axis times angle in radians, the angle from 0 to 2π by the sign of the quaternion.
pub fn logarithm(q: &UnitQuaternion<f64>) -> Vector3<f64> {
    let (imaginary, real) = (q.imag(), q.w);
    let sine = imaginary.norm();
    // A full turn has no axis; it is none.
    if sine < 1e-12 {
        return imaginary * 2.0 * real.signum();
    }
    imaginary * (2.0 * sine.atan2(real) / sine)
}

/// That of q and −q which lies nearer to `to`.
pub fn nearer(q: &UnitQuaternion<f64>, to: &UnitQuaternion<f64>) -> UnitQuaternion<f64> {
    if q.coords.dot(&to.coords) < 0.0 { UnitQuaternion::new_unchecked(-q.into_inner()) } else { *q }
}

/// The mean direction of quaternions whose signs agree; the first if they cancel out, the identity if there is none.
pub fn mean_quaternion(all: impl Iterator<Item = (f64, UnitQuaternion<f64>)>) -> UnitQuaternion<f64> {
    let (mut sum, mut first, mut total) = (Quaternion::new(0.0, 0.0, 0.0, 0.0), None, 0.0);
    for (weight, q) in all {
        first.get_or_insert(q);
        sum += q.into_inner() * weight;
        total += weight;
    }
    UnitQuaternion::try_new(sum, 1e-6 * total).or(first).unwrap_or_else(UnitQuaternion::identity)
}

/// The mean of deformation gradients with weights: of logarithms of rotations about their mean direction, and of stretches.
///
/// A mean of the matrices themselves shrinks where rotations differ, as cos(θ/2) between two that are θ apart. To first order
/// in the rotations both are the same. Without any weight it is the identity.
pub fn mean_gradient(gradients: &[(f64, Matrix3<f64>)]) -> Matrix3<f64> {
    let total: f64 = gradients.iter().map(|(weight, _)| weight).sum();
    match gradients {
        [(_, f)] => return *f,
        _ if total <= 0.0 => return Matrix3::identity(),
        _ => {}
    }
    let mut turns: Vec<(f64, Turn)> = gradients.iter().map(|(weight, f)| (weight / total, Turn::of(f))).collect();
    let first = turns[0].1.quaternion;
    turns.iter_mut().for_each(|(_, turn)| turn.quaternion = nearer(&turn.quaternion, &first));
    let middle = mean_quaternion(turns.iter().map(|&(weight, turn)| (weight, turn.quaternion)));
    let way = |turn: &Turn| logarithm(&(middle.inverse() * nearer(&turn.quaternion, &middle)));
    let mean: Vector3<f64> = turns.iter().map(|(weight, turn)| way(turn) * *weight).sum();
    let stretch = turns.iter().map(|(weight, turn)| turn.stretch * *weight).sum();
    Turn { quaternion: middle * UnitQuaternion::from_scaled_axis(mean), stretch }.gradient()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testkit::random::Random;

    fn about_z(degrees: f64) -> UnitQuaternion<f64> {
        UnitQuaternion::from_axis_angle(&Vector3::z_axis(), degrees.to_radians())
    }

    #[test]
    fn the_logarithm_goes_on_past_a_half_turn_with_the_sign_of_the_quaternion() {
        for degrees in [1e-9, 10.0, 179.0, 181.0, 350.0] {
            // `about_z` itself follows the half angle, which is positive up to a full turn.
            let found = logarithm(&about_z(degrees));
            assert!((found - Vector3::z() * f64::to_radians(degrees)).norm() < 1e-12, "{degrees}: {found}");
        }
        assert_eq!(logarithm(&UnitQuaternion::new_unchecked(-UnitQuaternion::identity().into_inner())).norm(), 0.0);
    }

    #[test]
    fn a_gradient_is_its_turn_and_the_mean_of_one_is_itself() {
        let mut random = Random::new(3);
        for _ in 0..50 {
            let f = random.rotation().to_rotation_matrix().into_inner()
                + Matrix3::from_fn(|_, _| random.between(-0.3, 0.3));
            // Rounding of one polar decomposition.
            assert!((Turn::of(&f).gradient() - f).norm() < 1e-12);
            assert!((mean_gradient(&[(0.5, f), (1.5, f)]) - f).norm() < 1e-12);
        }
    }

    #[test]
    fn between_two_rotations_lies_half_the_turn_and_not_a_collapse() {
        for degrees in [20.0, 90.0, 150.0, 179.0] {
            let (none, all) = (Matrix3::identity(), about_z(degrees).to_rotation_matrix().into_inner());
            let half = about_z(degrees / 2.0).to_rotation_matrix().into_inner();
            assert!((mean_gradient(&[(1.0, none), (1.0, all)]) - half).norm() < 1e-9, "{degrees}");
            let between = Turn::of(&none).towards(&Turn::of(&all), 0.5).gradient();
            assert!((between - half).norm() < 1e-9, "{degrees}");
        }
    }

    #[test]
    fn small_deformations_have_the_mean_of_their_matrices_to_first_order() {
        let mut random = Random::new(8);
        let size = 1e-4;
        let any = |random: &mut Random| Matrix3::identity() + Matrix3::from_fn(|_, _| random.between(-size, size));
        for _ in 0..20 {
            let all = [(0.2, any(&mut random)), (0.5, any(&mut random)), (0.3, any(&mut random))];
            let linear: Matrix3<f64> = all.iter().map(|(w, f)| f * *w).sum();
            // What is left is of second order.
            assert!((mean_gradient(&all) - linear).norm() < 10.0 * size * size);
        }
    }
}
