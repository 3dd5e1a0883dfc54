//! How terms whose directions are held are stiffer than they are.

use nalgebra::Vector3;

/// By how much a term w ‖d − ‖e‖ n‖², with n = d/‖d‖ held, is stiffer than w (‖d‖ − ‖e‖)² sideways of d.
#[derive(Clone, Copy, Debug)]
pub struct Sideways {
    direction: Vector3<f64>,
    stiffness: f64,
}

impl Sideways {
    /// No difference.
    pub const NONE: Self = Self { direction: Vector3::new(0.0, 0.0, 0.0), stiffness: 0.0 };

    /// For d = `now`, ‖e‖ = `length` and w = `weight`.
    ///
    /// The second derivative of the energy is 1 − ‖e‖/‖d‖ there, and counts as 0 where it is negative.
    pub fn new(now: Vector3<f64>, length: f64, weight: f64) -> Self {
        match now.try_normalize(1e-300) {
            Some(direction) => Self { direction, stiffness: weight * (length / now.norm()).min(1.0) },
            None => Self::NONE,
        }
    }

    /// The difference times a change of d.
    pub fn of(&self, change: Vector3<f64>) -> Vector3<f64> {
        (change - self.direction * self.direction.dot(&change)) * self.stiffness
    }
}
