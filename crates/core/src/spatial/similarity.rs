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
    /// that both stand upright keep their own way of standing, and a Y-up file still meets a Z-up file. The rotation is not
    /// rounded where that more than triples the mean squared distance of the points: one shape is then turned against the other.
    #[default]
    Auto,
    /// Not at all: both files have the same axes.
    Same,
    /// As corresponding points say, exactly.
    Fitted,
}

/// The rotation that an [`Orientation`] led to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Oriented {
    /// R.
    pub rotation: Matrix3<f64>,
    /// Which rotation R is.
    pub taken: Taken,
    /// Angle between the rotation of least squares and the nearest one that maps axes to axes, in degrees.
    pub degrees_from_axes: f64,
}

/// Which rotation was taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Taken {
    /// The identity, as asked for.
    Same,
    /// The nearest rotation that maps axes to axes.
    Axes,
    /// The rotation of least squares.
    Fitted,
}

impl Taken {
    /// The name in figures.
    pub fn name(self) -> &'static str {
        match self {
            Self::Same => "same",
            Self::Axes => "axes",
            Self::Fitted => "fitted",
        }
    }
}

/// Above this angle to the axes a rotation is never rounded, in degrees.
const MAX_ROUNDED_DEGREES: f64 = 30.0;

/// A rotation is rounded if that multiplies the mean squared distance of the points by at most this.
///
/// Pairs of other proportions or poses that stand alike have ratios of 1 to 2 (horse and camel, at 8 degrees: 1.7). A body
/// that is turned by 10 degrees against another has 5 or more.
const MAX_ROUNDED_RATIO: f64 = 3.0;

/// Squared distances below this part of the spread are rounding of coordinates.
const MIN_RELATIVE_MISFIT: f64 = 1e-12;

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
        let Some(pairs) = Spread::new(from, to, weights) else { return Self::IDENTITY };
        if pairs.coincide() {
            return Self { translation: pairs.to_mean - pairs.from_mean, ..Self::IDENTITY };
        }
        let oriented = pairs.orient(orientation);
        pairs.similarity(oriented.map_or_else(Matrix3::identity, |oriented| oriented.rotation))
    }

    /// The similarity that takes points `from` to points `to`, with the rotation `rotation`.
    pub fn with_rotation(from: &[Point3<f64>], to: &[Point3<f64>], weights: &[f64], rotation: Matrix3<f64>) -> Self {
        match Spread::new(from, to, weights) {
            Some(pairs) if !pairs.coincide() => pairs.similarity(rotation),
            Some(pairs) => Self { translation: pairs.to_mean - pairs.from_mean, ..Self::IDENTITY },
            None => Self::IDENTITY,
        }
    }

    /// The rotation that [`fit`](Self::fit) takes, and which it is; `None` if the points leave it open.
    pub fn orient(
        from: &[Point3<f64>],
        to: &[Point3<f64>],
        weights: &[f64],
        orientation: Orientation,
    ) -> Option<Oriented> {
        Spread::new(from, to, weights).filter(|pairs| !pairs.coincide())?.orient(orientation)
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
        angle_between(&self.rotation, &Matrix3::identity())
    }
}

/// The angle between two rotations in degrees, 0 to 180.
pub fn angle_between(a: &Matrix3<f64>, b: &Matrix3<f64>) -> f64 {
    (((a * b.transpose()).trace() - 1.0) / 2.0).clamp(-1.0, 1.0).acos().to_degrees()
}

/// Moments of weighted pairs of points.
struct Spread {
    from_mean: Vector3<f64>,
    to_mean: Vector3<f64>,
    /// C = Σ w (q − q̄) (p − p̄)ᵀ.
    covariance: Matrix3<f64>,
    from_spread: f64,
    to_spread: f64,
    total: f64,
    /// The number of pairs of one weight that would say as much: (Σ w)² / Σ w².
    count: f64,
}

impl Spread {
    fn new(from: &[Point3<f64>], to: &[Point3<f64>], weights: &[f64]) -> Option<Self> {
        let total: f64 = weights.iter().sum();
        if total <= 0.0 {
            return None;
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
        let count = total * total / weights.iter().map(|w| w * w).sum::<f64>();
        Some(Self { from_mean, to_mean, covariance, from_spread, to_spread, total, count })
    }

    /// Whether the points of one side coincide: their spread is rounding.
    fn coincide(&self) -> bool {
        let is_rounding = |spread: f64, mean: &Vector3<f64>| spread <= self.total * (1e-12 * mean.norm()).powi(2);
        is_rounding(self.from_spread, &self.from_mean) || is_rounding(self.to_spread, &self.to_mean)
    }

    fn similarity(&self, rotation: Matrix3<f64>) -> Similarity {
        let scale = (self.to_spread / self.from_spread).sqrt();
        Similarity { scale, rotation, translation: self.to_mean - rotation * self.from_mean * scale }
    }

    fn orient(&self, orientation: Orientation) -> Option<Oriented> {
        let fitted = best_rotation(&self.covariance)?;
        let (axes, degrees_from_axes) = nearest_axes(&fitted);
        let taken = match orientation {
            Orientation::Same => Taken::Same,
            Orientation::Fitted => Taken::Fitted,
            Orientation::Auto if degrees_from_axes > MAX_ROUNDED_DEGREES => Taken::Fitted,
            Orientation::Auto if self.rounding_misfits(&fitted, &axes) => Taken::Fitted,
            Orientation::Auto => Taken::Axes,
        };
        let rotation = match taken {
            Taken::Same => Matrix3::identity(),
            Taken::Axes => axes,
            Taken::Fitted => fitted,
        };
        Some(Oriented { rotation, taken, degrees_from_axes })
    }

    /// Whether `axes` in place of `fitted` worsens the fit more than other proportions explain.
    ///
    /// Mean squares are over degrees of freedom, because few points are always fitted well: n points have 3n, of which a
    /// similarity takes 7, and 4 if its rotation is given.
    fn rounding_misfits(&self, fitted: &Matrix3<f64>, axes: &Matrix3<f64>) -> bool {
        let free = |taken: f64| (3.0 * self.count - taken).max(0.0);
        let (fitted, axes) = (self.misfit(fitted), self.misfit(axes));
        axes > MIN_RELATIVE_MISFIT * self.to_spread && axes * free(7.0) > MAX_ROUNDED_RATIO * fitted * free(4.0)
    }

    /// Σ w ‖(q − q̄) − s R (p − p̄)‖².
    fn misfit(&self, rotation: &Matrix3<f64>) -> f64 {
        let scale = (self.to_spread / self.from_spread).sqrt();
        (2.0 * (self.to_spread - scale * (rotation.transpose() * self.covariance).trace())).max(0.0)
    }
}

/// The rotation R that maximises tr(Rᵀ C); `None` if C has rank 1 or less, which leaves it open.
fn best_rotation(covariance: &Matrix3<f64>) -> Option<Matrix3<f64>> {
    let values = covariance.singular_values();
    // The covariance squares the width of a cloud.
    if values[1] <= 1e-6 * values[0] || values[0] == 0.0 {
        return None;
    }
    Some(polar(covariance).rotation)
}

/// The nearest of the 24 rotations that map axes to axes, and the angle to it in degrees.
fn nearest_axes(r: &Matrix3<f64>) -> (Matrix3<f64>, f64) {
    let candidates = axis_rotations();
    let closeness = |c: &Matrix3<f64>| (c.transpose() * r).trace();
    let best = candidates.iter().max_by(|a, b| closeness(a).total_cmp(&closeness(b))).copied().unwrap_or(*r);
    (best, ((closeness(&best) - 1.0) / 2.0).clamp(-1.0, 1.0).acos().to_degrees())
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

    /// The cloud turned by `degrees` about z, and each point moved by up to `noise` of its size, the same at every angle.
    fn turned(degrees: f64, noise: f64) -> Vec<Point3<f64>> {
        let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), degrees.to_radians());
        let other = |i: usize, p: &Point3<f64>| {
            let i = i as f64;
            p + Vector3::new((5.1 * i).sin(), (3.7 * i).cos(), (1.9 * i).sin()) * noise
        };
        cloud().iter().enumerate().map(|(i, p)| turn * other(i, p)).collect()
    }

    fn oriented(to: &[Point3<f64>]) -> Oriented {
        Similarity::orient(&cloud(), to, &[1.0; 20], Orientation::Auto).expect("a cloud of three dimensions")
    }

    #[test]
    fn a_shape_that_is_turned_keeps_its_rotation_at_every_angle() {
        for degrees in [1.0, 10.0, 20.0, 29.0, 45.0] {
            let found = oriented(&turned(degrees, 0.0));
            let truth = *Rotation3::from_axis_angle(&Vector3::z_axis(), f64::to_radians(degrees)).matrix();
            assert_eq!(found.taken, Taken::Fitted, "{degrees}");
            // Rounding of sums of 20 terms.
            assert!((found.rotation - truth).norm() < 1e-12, "{degrees}: {}", found.rotation);
            assert!((found.degrees_from_axes - degrees).abs() < 1e-6, "{degrees}");
        }
        for degrees in [0.0, 90.0] {
            let found = oriented(&turned(degrees, 0.0));
            assert_eq!(found.taken, Taken::Axes, "{degrees}: exactly, not but for rounding");
            assert!(found.degrees_from_axes < 1e-5);
        }
    }

    #[test]
    fn a_small_turn_of_another_shape_is_rounded_away_and_a_quarter_turn_is_kept() {
        // The points differ by about a radius, of which a turn by 8 degrees explains little.
        for (degrees, axes) in [(8.0, 0.0), (98.0, 90.0)] {
            let found = oriented(&turned(degrees, 0.7));
            assert_eq!(found.taken, Taken::Axes, "{degrees}");
            let truth = *Rotation3::from_axis_angle(&Vector3::z_axis(), f64::to_radians(axes)).matrix();
            assert!((found.rotation - truth).norm() < 1e-12, "{degrees}");
        }
        assert_eq!(
            oriented(&turned(28.0, 0.2)).taken,
            Taken::Fitted,
            "points differ far less than the turn moves them"
        );
        assert_eq!(oriented(&turned(45.0, 0.7)).taken, Taken::Fitted, "never beyond 30 degrees");
    }

    #[test]
    fn few_points_are_fitted_well_by_chance_and_do_not_say_that_a_shape_is_turned() {
        let from = &cloud()[..3];
        let to: Vec<_> = turned(5.0, 0.5)[..3].to_vec();
        let of_three = Similarity::orient(from, &to, &[1.0; 3], Orientation::Auto).expect("a triangle");
        assert_eq!(of_three.taken, Taken::Axes);
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
