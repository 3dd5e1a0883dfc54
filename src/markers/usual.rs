//! The usual reasons why points lie off their mesh: another unit, other axes.

use std::fmt;

use nalgebra::Point3;

use super::attach::{Attacher, FARTHEST};

/// What is done to positions before they are attached.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Usual {
    /// The factor.
    pub factor: f64,
    /// How the axes are exchanged.
    pub axes: Axes,
}

/// An exchange of axes.
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

impl Usual {
    /// Nothing.
    pub const NOTHING: Self = Self { factor: 1.0, axes: Axes::Same };

    /// Does it to `p`.
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

impl fmt::Display for Usual {
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

/// Metres to centimetres or millimetres, decimetres, and back.
const FACTORS: [f64; 7] = [1.0, 100.0, 0.01, 1000.0, 0.001, 10.0, 0.1];
const AXES: [Axes; 4] = [Axes::Same, Axes::ZUpToYUp, Axes::YUpToZUp, Axes::Exchanged];

/// What makes all of `positions` lie on the surface: among several, that with the smallest mean distance, and the plainer
/// one of equals.
pub fn fitting(attacher: &Attacher<'_>, positions: &[Point3<f64>]) -> Option<Usual> {
    let mut best: Option<(f64, Usual)> = None;
    for axes in AXES {
        for factor in FACTORS {
            let usual = Usual { factor, axes };
            let mut sum = 0.0;
            let fits = !positions.is_empty()
                && positions.iter().all(|position| {
                    let distance = attacher.attach(&usual.apply(position)).distance;
                    sum += distance;
                    distance <= FARTHEST
                });
            // A mean that differs in the last digits is no reason to prefer the less plain.
            if fits && best.is_none_or(|(least, _)| sum < 0.999 * least - 1e-9) {
                best = Some((sum, usual));
            }
        }
    }
    best.map(|(_, usual)| usual)
}
