//! Frequent reasons why points lie off their mesh: another unit, other axes.

use std::fmt;

use nalgebra::Point3;

use crate::attacher::{Attacher, is_too_far};

/// Units and axes are guessed from this many points or more: fewer would fit by chance.
pub const MIN_POINTS: usize = 3;

/// A change of unit and axes, applied to positions before they are attached.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UnitAxes {
    /// The factor.
    pub factor: f64,
    /// The change of axes.
    pub axes: Axes,
}

/// A change of axes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axes {
    /// None.
    Same,
    /// From Z up to Y up: (x, z, −y).
    ZUpToYUp,
    /// From Y up to Z up: (x, −z, y).
    YUpToZUp,
    /// Y and Z exchanged: (x, z, y), which changes the hand.
    Exchanged,
}

/// Metres to centimetres or millimetres, decimetres, and back.
const FACTORS: [f64; 7] = [1.0, 100.0, 0.01, 1000.0, 0.001, 10.0, 0.1];
const AXES: [Axes; 4] = [Axes::Same, Axes::ZUpToYUp, Axes::YUpToZUp, Axes::Exchanged];

impl UnitAxes {
    /// No change.
    pub const IDENTITY: Self = Self { factor: 1.0, axes: Axes::Same };

    /// `p` in the other unit and axes.
    pub fn apply(self, p: &Point3<f64>) -> Point3<f64> {
        let turned = match self.axes {
            Axes::Same => *p,
            Axes::ZUpToYUp => Point3::new(p.x, p.z, -p.y),
            Axes::YUpToZUp => Point3::new(p.x, -p.z, p.y),
            Axes::Exchanged => Point3::new(p.x, p.z, p.y),
        };
        turned * self.factor
    }
}

impl fmt::Display for UnitAxes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let axes = match self.axes {
            Axes::Same => "",
            Axes::ZUpToYUp => "turned from Z up to Y up, (x, y, z) to (x, z, -y)",
            Axes::YUpToZUp => "turned from Y up to Z up, (x, y, z) to (x, -z, y)",
            Axes::Exchanged => "with Y and Z exchanged",
        };
        match (self.factor == 1.0, axes.is_empty()) {
            (true, true) => f.write_str("as they are"),
            (true, false) => f.write_str(axes),
            (false, true) => write!(f, "times {}", self.factor),
            (false, false) => write!(f, "times {} and {axes}", self.factor),
        }
    }
}

/// The unit and axes that bring all of `positions` to the surface; `None` if none do, or fewer than [`MIN_POINTS`] are given.
///
/// Among several that fit, it is the one with the smallest mean distance, and the plainer of equals.
pub fn detect(attacher: &Attacher<'_>, positions: &[Point3<f64>]) -> Option<UnitAxes> {
    if positions.len() < MIN_POINTS {
        return None;
    }
    let mut best: Option<(f64, UnitAxes)> = None;
    for unit_axes in AXES.iter().flat_map(|&axes| FACTORS.map(|factor| UnitAxes { factor, axes })) {
        let Some(distance) = total_distance(attacher, positions, unit_axes) else { continue };
        // A mean that differs in the last digits is no reason to prefer the less plain.
        if best.is_none_or(|(least, _)| distance < 0.999 * least - 1e-9) {
            best = Some((distance, unit_axes));
        }
    }
    best.map(|(_, unit_axes)| unit_axes)
}

/// The sum of the distances of `positions` from the surface; `None` if one of them lies too far off it.
fn total_distance(attacher: &Attacher<'_>, positions: &[Point3<f64>], unit_axes: UnitAxes) -> Option<f64> {
    let mut total = 0.0;
    for position in positions {
        let distance = attacher.attach(&unit_axes.apply(position)).distance;
        total += distance;
        if is_too_far(distance) {
            return None;
        }
    }
    Some(total)
}
