use nalgebra::{Matrix3, Point3, Vector3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::operators::polar;

/// A similarity transform: p ↦ s R p + t with scale s > 0 and rotation R.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Similarity {
    /// s.
    pub scale: f64,
    /// R.
    pub rotation: Matrix3<f64>,
    /// t.
    pub translation: Vector3<f64>,
}

/// How the rest surfaces of a pair are turned to each other.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Orientation {
    /// As corresponding points say, rounded to quarter turns about the axes where that is within 30 degrees: two animals
    /// that both stand upright keep their own way of standing, and a Y-up file still meets a Z-up file.
    #[default]
    Auto,
    /// Not at all: both files have the same axes.
    Same,
    /// As corresponding points say, exactly.
    Fitted,
}

impl Similarity {
    /// Nothing moves.
    pub const IDENTITY: Self = Self {
        scale: 1.0,
        rotation: Matrix3::new(1., 0., 0., 0., 1., 0., 0., 0., 1.),
        translation: Vector3::new(0., 0., 0.),
    };

    /// The similarity that takes points `from` to points `to`, each pair counting by its weight, turned as `orientation` allows.
    ///
    /// The rotation is that of least squares and the scale the ratio of spreads (Horn 1987), which treats both sides alike:
    /// swapping them gives the inverse. Points of one side that lie on a line, to 1e-3 of its length, leave the rotation the
    /// identity; points that coincide leave the scale 1.
    pub fn fit(from: &[Point3<f64>], to: &[Point3<f64>], weights: &[f64], orientation: Orientation) -> Self {
        let total: f64 = weights.iter().sum();
        if total <= 0.0 {
            return Self::IDENTITY;
        }
        let mean = |points: &[Point3<f64>]| {
            points.iter().zip(weights).map(|(p, w)| p.coords * *w).sum::<Vector3<f64>>() / total
        };
        let (from_mean, to_mean) = (mean(from), mean(to));
        let mut covariance = Matrix3::zeros();
        let (mut from_spread, mut to_spread) = (0.0, 0.0);
        for ((p, q), w) in from.iter().zip(to).zip(weights) {
            let (p, q) = (p.coords - from_mean, q.coords - to_mean);
            covariance += q * p.transpose() * *w;
            from_spread += w * p.norm_squared();
            to_spread += w * q.norm_squared();
        }
        // Points that coincide have a spread of rounding.
        let coincide = |spread: f64, mean: &Vector3<f64>| spread <= total * (1e-12 * mean.norm()).powi(2);
        if coincide(from_spread, &from_mean) || coincide(to_spread, &to_mean) {
            return Self { translation: to_mean - from_mean, ..Self::IDENTITY };
        }
        let rotation = match orientation {
            Orientation::Same => Matrix3::identity(),
            Orientation::Fitted => best_rotation(&covariance),
            Orientation::Auto => rounded(best_rotation(&covariance)),
        };
        let scale = (to_spread / from_spread).sqrt();
        Self { scale, rotation, translation: to_mean - rotation * from_mean * scale }
    }

    /// s R p + t.
    pub fn apply(&self, p: &Point3<f64>) -> Point3<f64> {
        Point3::from(self.rotation * p.coords * self.scale + self.translation)
    }

    /// The transform that undoes this one.
    pub fn inverse(&self) -> Self {
        let rotation = self.rotation.transpose();
        let scale = 1.0 / self.scale;
        Self { scale, rotation, translation: -(rotation * self.translation) * scale }
    }

    /// Angle of R in degrees, 0 to 180.
    pub fn angle_degrees(&self) -> f64 {
        ((self.rotation.trace() - 1.0) / 2.0).clamp(-1.0, 1.0).acos().to_degrees()
    }
}

/// The rotation R that maximises tr(Rᵀ C); the identity if C has rank 1 or less, which leaves it open.
fn best_rotation(covariance: &Matrix3<f64>) -> Matrix3<f64> {
    let values = covariance.singular_values();
    // The covariance squares the width of a cloud.
    if values[1] <= 1e-6 * values[0] || values[0] == 0.0 {
        return Matrix3::identity();
    }
    polar(covariance).rotation
}

/// The nearest of the 24 rotations that map axes to axes if it is within 30 degrees, else `r` itself.
fn rounded(r: Matrix3<f64>) -> Matrix3<f64> {
    let candidates = axis_rotations();
    let closeness = |c: &Matrix3<f64>| (c.transpose() * r).trace();
    let best = candidates.iter().max_by(|a, b| closeness(a).total_cmp(&closeness(b))).copied().unwrap_or(r);
    let cos = (closeness(&best) - 1.0) / 2.0;
    if cos >= 30f64.to_radians().cos() { best } else { r }
}

/// The 24 rotations that map axes to axes, the identity first.
fn axis_rotations() -> Vec<Matrix3<f64>> {
    let axes = [Vector3::x(), Vector3::y(), Vector3::z(), -Vector3::x(), -Vector3::y(), -Vector3::z()];
    let mut result = Vec::with_capacity(24);
    for x in axes {
        for y in axes.into_iter().filter(|y| y.dot(&x) == 0.0) {
            result.push(Matrix3::from_columns(&[x, y, x.cross(&y)]));
        }
    }
    result
}

#[cfg(test)]
mod tests {
    use nalgebra::Rotation3;

    use super::*;

    fn cloud() -> Vec<Point3<f64>> {
        (0..20).map(|i| i as f64).map(|i| Point3::new(i.sin(), (2.3 * i).cos() * 2.0, (0.7 * i).sin() * 3.0)).collect()
    }

    #[test]
    fn a_similarity_is_found_again_and_undone_by_its_inverse() {
        let rotation = *Rotation3::from_euler_angles(0.9, -0.8, 2.0).matrix();
        let truth = Similarity { scale: 2.5, rotation, translation: Vector3::new(1.0, -20.0, 3.0) };
        let to: Vec<_> = cloud().iter().map(|p| truth.apply(p)).collect();
        let found = Similarity::fit(&cloud(), &to, &[1.0; 20], Orientation::Fitted);
        for p in cloud() {
            // Rounding at coordinates of about 20.
            assert!((found.apply(&p) - truth.apply(&p)).norm() < 1e-12);
            assert!((found.inverse().apply(&truth.apply(&p)) - p).norm() < 1e-12);
        }
    }

    #[test]
    fn a_small_turn_is_rounded_away_and_a_quarter_turn_is_kept() {
        let small = *Rotation3::from_euler_angles(0.2, 0.1, 0.0).matrix();
        assert_eq!(rounded(small), Matrix3::identity());
        let quarter = *Rotation3::from_euler_angles(-std::f64::consts::FRAC_PI_2, 0.1, 0.0).matrix();
        // y becomes -z... a turn of -90 degrees about x.
        assert_eq!(rounded(quarter), Matrix3::new(1., 0., 0., 0., 0., 1., 0., -1., 0.));
    }

    #[test]
    fn points_on_a_line_leave_the_rotation_alone() {
        let line: Vec<_> = (0..5).map(|i| Point3::new(i as f64, 0.0, 0.0)).collect();
        let up: Vec<_> = (0..5).map(|i| Point3::new(0.0, i as f64, 0.0)).collect();
        assert_eq!(Similarity::fit(&line, &up, &[1.0; 5], Orientation::Fitted).rotation, Matrix3::identity());
    }

    #[test]
    fn there_are_24_axis_rotations() {
        assert_eq!(axis_rotations().len(), 24);
        assert_eq!(axis_rotations()[0], Matrix3::identity());
        assert!(axis_rotations().iter().all(|r| r.determinant() == 1.0));
    }
}
