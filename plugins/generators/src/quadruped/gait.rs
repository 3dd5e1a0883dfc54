//! Gaits: the angles of the joints through a stride, the same for every animal.

use std::f64::consts::TAU;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::body::Limb;

/// How the animal moves.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Gait {
    /// A transverse gallop, left foreleg leading.
    #[default]
    Gallop,
    /// A walk: hind left, fore left, hind right, fore right.
    Walk,
    /// Stands still: no poses.
    None,
}

/// A turn of everything beyond a place of a limb, smoothed over a part of the limb.
#[derive(Clone, Copy, Debug)]
pub struct Bend {
    /// Where: the knot at the middle.
    pub at: f64,
    /// Over how many knots it takes place; 0 for all of the limb.
    pub over: f64,
    /// Degrees by which what lies beyond swings forward (for the spine and the tail: upward).
    pub swing: f64,
    /// Degrees by which it swings to the animal's left.
    pub sway: f64,
}

/// Eight angles through a stride, degrees, at phases 0, 1/8, … 7/8; phase 0 is when the hoof touches the ground.
type Stride = [f64; 8];

/// Shoulder or hip, elbow or stifle, knee or hock, fetlock; forward is positive.
type Leg = [Stride; 4];

const GALLOP_FRONT: Leg = [
    [30., 10., -14., -30., -20., 4., 26., 36.],
    [2., 0., -2., 4., 24., 34., 20., 6.],
    [0., 0., 0., -12., -55., -70., -40., -8.],
    [8., 20., 16., -12., -38., -34., -18., 0.],
];
const GALLOP_HIND: Leg = [
    [34., 18., -6., -28., -26., -2., 24., 38.],
    [-10., -6., 0., 6., -26., -46., -36., -18.],
    [8., 6., 0., -10., 30., 46., 30., 12.],
    [6., 20., 16., -14., -40., -34., -16., 0.],
];
const WALK_FRONT: Leg = [
    [20., 11., 1., -9., -18., -12., 6., 20.],
    [0., 0., 0., 0., 4., 18., 16., 4.],
    [0., 0., 0., 0., -8., -42., -30., -4.],
    [2., 8., 10., 6., -14., -26., -12., 0.],
];
const WALK_HIND: Leg = [
    [20., 12., 2., -9., -18., -10., 8., 21.],
    [-6., -4., -2., 0., -4., -24., -24., -10.],
    [5., 4., 2., 0., 2., 24., 20., 8.],
    [2., 8., 10., 6., -14., -26., -10., 0.],
];

impl Gait {
    /// How far the body rises at `time` (0 to 1 through the stride), in heights of its back.
    pub fn rise(self, time: f64) -> f64 {
        match self {
            Self::Gallop => 0.035 * wave(time, 0.62),
            Self::Walk => 0.008 * wave(2.0 * time, 0.25),
            Self::None => 0.0,
        }
    }

    /// How the limb `limb` bends at `time`, from its root outwards.
    pub fn bends(self, limb: Limb, right: bool, time: f64) -> Vec<Bend> {
        if self == Self::None {
            return vec![];
        }
        let gallop = self == Self::Gallop;
        let by_gait = |in_gallop: f64, in_walk: f64| if gallop { in_gallop } else { in_walk };
        let bend = |at, over, swing, sway| Bend { at, over, swing, sway };
        let stride_wave = |lag: f64| if gallop { wave(time, lag) } else { wave(2.0 * time, lag) };
        match limb {
            Limb::Front | Limb::Hind => {
                let (leg, touches) = match (limb, right, gallop) {
                    (Limb::Hind, true, true) => (&GALLOP_HIND, 0.0),
                    (Limb::Hind, false, true) => (&GALLOP_HIND, 0.12),
                    (_, true, true) => (&GALLOP_FRONT, 0.34),
                    (_, false, true) => (&GALLOP_FRONT, 0.48),
                    (Limb::Hind, false, false) => (&WALK_HIND, 0.0),
                    (Limb::Hind, true, false) => (&WALK_HIND, 0.5),
                    (_, false, false) => (&WALK_FRONT, 0.25),
                    (_, true, false) => (&WALK_FRONT, 0.75),
                };
                let angle = |joint: usize| periodic(&leg[joint], time - touches);
                let joints = [(0.7, 2.2), (3.0, 1.8), (6.0, 1.7), (9.0, 1.5)];
                (0..4).map(|j| bend(joints[j].0, joints[j].1, angle(j), 0.0)).collect()
            }
            // Loin, base of the neck, poll: what lies ahead of the joint turns against what lies behind.
            Limb::Spine => vec![
                bend(2.2, 2.6, by_gait(9.0, 1.0) * stride_wave(0.32), by_gait(0.0, 3.0) * wave(time, 0.1)),
                bend(
                    6.6,
                    2.6,
                    by_gait(-10.0, 0.0) + by_gait(8.0, 4.0) * stride_wave(0.15),
                    by_gait(0.0, -4.0) * wave(time, 0.1),
                ),
                bend(
                    9.9,
                    1.6,
                    by_gait(16.0, 2.0) - by_gait(7.0, 4.0) * stride_wave(0.2),
                    by_gait(0.0, 2.0) * wave(time, 0.1),
                ),
            ],
            Limb::Tail => vec![
                bend(
                    0.5,
                    1.0,
                    by_gait(38.0, 4.0) + by_gait(8.0, 2.0) * wave(time, 0.3),
                    by_gait(6.0, 9.0) * wave(time, 0.0),
                ),
                bend(
                    2.2,
                    2.6,
                    by_gait(-12.0, 0.0) + by_gait(12.0, 3.0) * wave(time, 0.45),
                    by_gait(8.0, 10.0) * wave(time, 0.2),
                ),
            ],
            Limb::Ear => {
                vec![bend(0.0, 0.0, by_gait(-22.0, -4.0) + 5.0 * wave(time, if right { 0.3 } else { 0.1 }), 0.0)]
            }
            Limb::Horn => vec![],
        }
    }

    /// How much the whole body pitches up in front at `time`, degrees.
    pub fn pitch(self, time: f64) -> f64 {
        if self == Self::Gallop { 5.0 * wave(time, 0.9) } else { 0.0 }
    }
}

/// A cosine of period 1 with its crest at `crest`.
fn wave(time: f64, crest: f64) -> f64 {
    ((time - crest) * TAU).cos()
}

/// The value of a stride at `phase`, by a periodic Catmull-Rom spline.
fn periodic(values: &Stride, phase: f64) -> f64 {
    let place = phase.rem_euclid(1.0) * 8.0;
    let (index, t) = (place as usize % 8, place.fract());
    let value = |offset: usize| values[(index + offset + 7) % 8];
    let (before, a, b, after) = (value(0), value(1), value(2), value(3));
    let (from, to) = ((b - before) / 2.0, (after - a) / 2.0);
    let (t2, t3) = (t * t, t * t * t);
    a * (2.0 * t3 - 3.0 * t2 + 1.0) + from * (t3 - 2.0 * t2 + t) + b * (3.0 * t2 - 2.0 * t3) + to * (t3 - t2)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stride_passes_through_its_angles_and_closes() {
        let stride = &GALLOP_HIND[1];
        for (k, angle) in stride.iter().enumerate() {
            assert!((periodic(stride, k as f64 / 8.0) - angle).abs() < 1e-12);
        }
        assert!((periodic(stride, 0.999_999) - stride[0]).abs() < 1e-3);
        assert!((periodic(stride, -0.25) - periodic(stride, 0.75)).abs() < 1e-12);
    }
}
