//! Frequent reasons why points lie off their mesh: another unit, other axes.

use mimesh_core::spatial::{Axes, UpAxis};
use nalgebra::Point3;

pub use mimesh_core::spatial::UnitAxes;

use crate::attacher::{Attacher, MAX_DISTANCE, is_too_far};

/// Units and axes are guessed from this many points or more: fewer would fit by chance.
pub const MIN_POINTS: usize = 3;

/// Metres to centimetres or millimetres, decimetres, and back.
const FACTORS: [f64; 7] = [1.0, 100.0, 0.01, 1000.0, 0.001, 10.0, 0.1];
const AXES: [Axes; 4] = [
    Axes::Same,
    Axes::Up { from: UpAxis::Z, to: UpAxis::Y },
    Axes::Up { from: UpAxis::Y, to: UpAxis::Z },
    Axes::Exchanged,
];

/// The unit and axes that bring `positions` to the surface, the half turn between LPS and RAS among them if `half_turns`; `None` if
/// none do, or fewer than [`MIN_POINTS`] are given.
///
/// A third of the points may stay off the surface, but no fewer than [`MIN_POINTS`] lie on it: strays do not hide what the others say.
/// Among several that fit, it is the one with the smallest mean distance, and the plainer of equals. A stray counts no more than the
/// distance at which points are refused.
pub fn detect(attacher: &Attacher<'_>, positions: &[Point3<f64>], half_turns: bool) -> Option<UnitAxes> {
    if positions.len() < MIN_POINTS {
        return None;
    }
    let as_they_are = Distances::new(attacher, positions, UnitAxes::IDENTITY);
    let mut best: Option<(f64, UnitAxes)> = None;
    let turns = if half_turns { &[false, true][..] } else { &[false] };
    let all = turns.iter().flat_map(|&half_turn| AXES.map(|axes| UnitAxes { axes, half_turn, ..UnitAxes::IDENTITY }));
    for unit_axes in all.flat_map(|axes| FACTORS.map(|factor| UnitAxes { factor, ..axes })) {
        let found = Distances::new(attacher, positions, unit_axes);
        // Where points stay off, the others must lie much nearer than they do as they are.
        let is_better = found.far == 0 || unit_axes == UnitAxes::IDENTITY || 2.0 * found.median < as_they_are.median;
        // A mean that differs in the last digits is no reason to prefer the less plain.
        if found.are_near() && is_better && best.is_none_or(|(least, _)| found.total < 0.999 * least - 1e-9) {
            best = Some((found.total, unit_axes));
        }
    }
    best.map(|(_, unit_axes)| unit_axes)
}

/// How far positions lie off the surface under some unit and axes.
struct Distances {
    count: usize,
    /// The number of positions that would be refused.
    far: usize,
    /// The sum of the distances, each at most that at which positions are refused.
    total: f64,
    median: f64,
}

impl Distances {
    fn new(attacher: &Attacher<'_>, positions: &[Point3<f64>], unit_axes: UnitAxes) -> Self {
        let distances = positions.iter().map(|position| attacher.attach(&unit_axes.apply(position)).distance);
        let mut distances: Vec<f64> = distances.collect();
        distances.sort_by(f64::total_cmp);
        let far = distances.iter().filter(|distance| is_too_far(**distance)).count();
        let near: f64 = distances.iter().filter(|distance| !is_too_far(**distance)).sum();
        let median = distances.get(distances.len() / 2).copied().unwrap_or(f64::INFINITY);
        Self { count: positions.len(), far, total: near + far as f64 * MAX_DISTANCE, median }
    }

    /// Whether two thirds of the positions lie on the surface, and no fewer than [`MIN_POINTS`].
    fn are_near(&self) -> bool {
        let near = self.count - self.far;
        near >= MIN_POINTS && 3 * near >= 2 * self.count
    }
}
