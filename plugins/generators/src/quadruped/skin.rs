//! The rule by which the body follows its limbs: the known motion that a transfer should reproduce.
//!
//! Each limb c carries a rotation R(s) that varies smoothly along its centre line C(s) around the joints, and its
//! posed line is the integral C′(s) = C′(0) + ∫ R dC. A point with parameter s follows the limb as D_c(v) = C′(s) +
//! R(s) (v − C(s)); it moves by the mean of D_c over the limbs, with weights that depend on its distance to each
//! limb's surface in units of that limb's thickness. All of it is relative to knots and thicknesses, so
//! corresponding points of two animals move alike.

use nalgebra::{Point3, Rotation3, Vector3};
use rayon::prelude::*;

use super::{
    body::{Body, Limb, Part},
    gait::{Bend, Gait},
};

/// The s on the spine that the body turns about.
const SPINE_ROOT: f64 = 3.5;

/// How each vertex hangs on the limbs: part, its parameter there, weight; weights of a vertex sum to 1.
#[derive(Debug)]
pub struct Skin<'a> {
    body: &'a Body,
    rest: &'a [Point3<f64>],
    bindings: Vec<Vec<(usize, f64, f64)>>,
}

impl<'a> Skin<'a> {
    /// Binds the vertices `rest` on the surface of `body`.
    pub fn new(body: &'a Body, rest: &'a [Point3<f64>]) -> Self {
        let bindings = rest.par_iter().map(|point| bind(body, point)).collect();
        Self { body, rest, bindings }
    }

    /// The vertices at `time`, 0 to 1 through the stride of `gait`.
    pub fn pose(&self, gait: Gait, time: f64) -> Vec<Point3<f64>> {
        let spine = PosedLine::spine(&self.body.parts[0], gait, time);
        let others =
            self.body.parts[1..].iter().map(|part| PosedLine::hung(part, &self.body.parts[0], &spine, gait, time));
        let others: Vec<PosedLine> = others.collect();
        let line = |part: usize| if part == 0 { &spine } else { &others[part - 1] };
        let mean = |(point, bindings): (&Point3<f64>, &Vec<(usize, f64, f64)>)| {
            let moved =
                bindings.iter().map(|&(p, s, weight)| line(p).carry(&self.body.parts[p], s, point).coords * weight);
            Point3::from(moved.sum::<Vector3<f64>>())
        };
        self.rest.par_iter().zip(&self.bindings).map(mean).collect()
    }
}

/// The limbs that carry `point`.
fn bind(body: &Body, point: &Point3<f64>) -> Vec<(usize, f64, f64)> {
    let mut result: Vec<(usize, f64, f64)> = vec![];
    for (index, part) in body.parts.iter().enumerate() {
        let spine = part.limb == Limb::Spine;
        let (distance, thickness) = if spine { (body.trunk(point), 0.0) } else { part.chain.distance(point) };
        // Further from the limb than this it has no say. The spine's is short, so that it ends where legs come free
        // of it.
        let reach = if spine { 0.4 * part.chain.at(SPINE_ROOT).depth } else { 1.3 * thickness };
        // Far from a limb its thickness is not known.
        if reach.is_finite() && distance < reach {
            let weight = smooth_step(1.0 - distance.max(0.0) / reach);
            result.push((index, part.chain.soft_parameter(point), weight));
        }
    }
    if result.is_empty() {
        // Only where limbs run into each other widely: the nearest alone.
        let distance = |i: &usize| body.parts[*i].chain.distance(point).0;
        let nearest = (0..body.parts.len()).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(0);
        result.push((nearest, body.parts[nearest].chain.soft_parameter(point), 1.0));
    }
    let total: f64 = result.iter().map(|r| r.2).sum();
    result.iter_mut().for_each(|r| r.2 /= total);
    result
}

/// A limb's line in a pose.
#[derive(Debug)]
struct PosedLine {
    /// Rotation of what the limb hangs on.
    base: Rotation3<f64>,
    bends: Vec<Bend>,
    /// The parameter s from which the bends of the spine count, backwards with the other sign; `None` for other limbs.
    origin: Option<f64>,
    /// The sign with which a swing turns about x.
    sign: f64,
    /// C′ at the samples of the limb.
    at: Vec<Point3<f64>>,
}

impl PosedLine {
    fn spine(part: &Part, gait: Gait, time: f64) -> Self {
        let root = part.chain.at(SPINE_ROOT).at;
        let base = Rotation3::from_axis_angle(&Vector3::x_axis(), -gait.pitch(time).to_radians());
        let at = root + Vector3::y() * (gait.rise(time) * root.y);
        // Facing forward, what lies beyond a bend rises by a turn against x.
        Self::integrate(part, base, gait.bends(Limb::Spine, false, time), Some(SPINE_ROOT), -1.0, at)
    }

    fn hung(part: &Part, spine: &Part, posed: &Self, gait: Gait, time: f64) -> Self {
        let root = part.chain.samples[0].at;
        let base = posed.rotation(part.attached);
        let at = posed.carry(spine, part.attached, &root);
        // A leg hangs down: a turn against x brings its foot forward. A tail points back and an ear up: a turn along
        // x lifts the one and brings the other forward.
        let sign = if matches!(part.limb, Limb::Front | Limb::Hind) { -1.0 } else { 1.0 };
        Self::integrate(part, base, gait.bends(part.limb, part.right, time), None, sign, at)
    }

    fn integrate(
        part: &Part,
        base: Rotation3<f64>,
        bends: Vec<Bend>,
        origin: Option<f64>,
        sign: f64,
        from: Point3<f64>,
    ) -> Self {
        let samples = &part.chain.samples;
        let mut line = Self { base, bends, origin, sign, at: vec![from; samples.len()] };
        let (start, within) = part.chain.locate(origin.unwrap_or(0.0));
        let step = |line: &Self, i: usize| {
            let middle = (part.chain.parameter(i) + part.chain.parameter(i + 1)) / 2.0;
            line.rotation(middle) * (samples[i + 1].at - samples[i].at)
        };
        line.at[start] = from - step(&line, start) * within;
        for i in start + 1..samples.len() {
            line.at[i] = line.at[i - 1] + step(&line, i - 1);
        }
        for i in (0..start).rev() {
            line.at[i] = line.at[i + 1] - step(&line, i);
        }
        line
    }

    /// R(s).
    fn rotation(&self, s: f64) -> Rotation3<f64> {
        let (mut swing, mut sway) = (0.0, 0.0);
        for bend in &self.bends {
            let turned = |s: f64| if bend.over > 0.0 { smooth_step((s - bend.at) / bend.over + 0.5) } else { 1.0 };
            let share = turned(s) - self.origin.map_or(0.0, turned);
            swing += share * bend.swing;
            sway += share * bend.sway;
        }
        let turn = |axis, degrees: f64| Rotation3::from_axis_angle(&axis, degrees.to_radians());
        self.base * turn(Vector3::y_axis(), sway) * turn(Vector3::x_axis(), self.sign * swing)
    }

    /// D(v) of a point with parameter `s`.
    fn carry(&self, part: &Part, s: f64, point: &Point3<f64>) -> Point3<f64> {
        let (i, t) = part.chain.locate(s);
        let posed = self.at[i] + (self.at[i + 1] - self.at[i]) * t;
        posed + self.rotation(s) * (point - part.chain.at(s).at)
    }
}

/// 0 up to 0, 1 from 1, with two continuous derivatives.
fn smooth_step(t: f64) -> f64 {
    let t = t.clamp(0.0, 1.0);
    t * t * t * (t * (6.0 * t - 15.0) + 10.0)
}

#[cfg(test)]
mod tests {
    use super::{super::animals, *};

    #[test]
    fn standing_still_gives_the_rest_shape() {
        let body = Body::new(&animals::CAMEL);
        let rest: Vec<_> =
            [[0.0, 1.96, 0.06], [0.15, 1.2, 0.4], [0.0, 1.05, 0.2], [-0.2, 0.66, -0.54]].map(Point3::from).into();
        for (posed, rest) in Skin::new(&body, &rest).pose(Gait::None, 0.3).iter().zip(&rest) {
            // Sums along some two hundred samples round to about this.
            assert!((posed - rest).norm() < 1e-12);
        }
    }

    #[test]
    fn a_limb_that_bends_keeps_the_length_of_its_line() {
        let body = Body::new(&animals::HORSE);
        let spine = PosedLine::spine(&body.parts[0], Gait::Gallop, 0.4);
        for part in body.parts.iter().filter(|part| part.limb != Limb::Spine) {
            let line = PosedLine::hung(part, &body.parts[0], &spine, Gait::Gallop, 0.4);
            let posed = line.at.windows(2).map(|pair| (pair[1] - pair[0]).norm());
            let rest = part.chain.samples.windows(2).map(|pair| (pair[1].at - pair[0].at).norm());
            posed.zip(rest).for_each(|(posed, rest)| assert!((posed - rest).abs() < 1e-12));
        }
    }

    #[test]
    fn a_gallop_bends_every_joint_of_a_leg_and_moves_the_hoof_by_half_the_leg() {
        let body = Body::new(&animals::HORSE);
        let hoof = [Point3::new(0.135, 0.05, 0.475)];
        let skin = Skin::new(&body, &hoof);
        let reach = (0..12).map(|frame| skin.pose(Gait::Gallop, f64::from(frame) / 12.0)[0].z);
        let (back, front) = reach.fold((f64::MAX, f64::MIN), |(low, high), z| (low.min(z), high.max(z)));
        assert!(front - back > 0.55, "{back} {front}");
    }
}
