//! Random vectors, rotations and motions: what tests add to [`Random`].

use nalgebra::{Isometry3, Matrix3, Quaternion, Translation3, UnitQuaternion, Vector3};

pub use crate::random::Random;

impl Random {
    /// A vector with coordinates in −1 to 1.
    pub fn vector(&mut self) -> Vector3<f64> {
        Vector3::from_fn(|_, _| self.between(-1.0, 1.0))
    }

    /// A matrix with entries in −1 to 1.
    pub fn matrix(&mut self) -> Matrix3<f64> {
        Matrix3::from_fn(|_, _| self.between(-1.0, 1.0))
    }

    /// A rotation, all equally likely [Shoemake 1992].
    pub fn rotation(&mut self) -> UnitQuaternion<f64> {
        let (radius, first, second) = (self.unit(), self.angle(), self.angle());
        let (a, b) = ((1.0 - radius).sqrt(), radius.sqrt());
        let (i, j, k, w) = (a * first.sin(), a * first.cos(), b * second.sin(), b * second.cos());
        UnitQuaternion::new_normalize(Quaternion::new(w, i, j, k))
    }

    /// A rotation followed by a move of at most `distance` along each axis.
    pub fn rigid_motion(&mut self, distance: f64) -> Isometry3<f64> {
        Isometry3::from_parts(Translation3::from(self.vector() * distance), self.rotation())
    }

    fn angle(&mut self) -> f64 {
        self.between(0.0, std::f64::consts::TAU)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rotations_have_no_preferred_direction() {
        let mut random = Random::new(1);
        let count = 20_000;
        let sum: Vector3<f64> = (0..count).map(|_| random.rotation() * Vector3::x()).sum();
        // The mean of n unit vectors is about 1/√n long; five times that is far out.
        assert!(sum.norm() / f64::from(count) < 5.0 / f64::from(count).sqrt());
    }
}
