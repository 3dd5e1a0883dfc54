//! The animal as a robot: a box for every segment of its limbs, tapered as the limb is, its edges rounded off.

use std::collections::BTreeMap;

use nalgebra::{Matrix3, Point3, Vector3};

use super::{
    body::{Body, Limb, Part},
    chain::Chain,
    pieces::{Motion, Pieces, region},
};

/// A segment: name, from and to which s, whether the limb ends freely before and after it.
type Segment = (&'static str, f64, f64, [bool; 2]);

const SPINE: &[Segment] = &[
    ("pelvis", 0.0, 2.1, [true, false]),
    ("barrel", 2.1, 4.0, [false, false]),
    ("chest", 4.0, 6.1, [false, false]),
    ("neck_low", 6.1, 8.0, [false, false]),
    ("neck_high", 8.0, 9.9, [false, false]),
    ("head", 10.2, 13.0, [true, true]),
];
const FRONT: &[Segment] = &[
    ("shoulder", 0.6, 3.0, [false, false]),
    ("forearm", 3.0, 6.0, [false, false]),
    ("shin", 6.0, 9.0, [false, false]),
    ("hoof", 9.0, 12.0, [false, true]),
];
const HIND: &[Segment] = &[
    ("thigh", 0.6, 3.0, [false, false]),
    ("gaskin", 3.0, 6.0, [false, false]),
    ("shin", 6.0, 9.0, [false, false]),
    ("hoof", 9.0, 12.0, [false, true]),
];
const TAIL: &[Segment] = &[("tail_root", 0.6, 2.2, [false, false]), ("tail_end", 2.2, 4.0, [false, true])];
const EAR: &[Segment] = &[("ear", 0.4, 2.0, [false, true])];
const HORN: &[Segment] = &[("horn", 0.4, 2.0, [false, true])];

/// The boxes of `body`, quads with edges about `edge` long.
pub fn boxes(body: &Body, edge: f64) -> Pieces {
    let mut result = Pieces::default();
    for part in &body.parts {
        let side = if part.right { "right_" } else { "left_" };
        let (segments, prefix) = match part.limb {
            Limb::Spine => (SPINE, String::new()),
            Limb::Front => (FRONT, format!("{side}front_")),
            Limb::Hind => (HIND, format!("{side}hind_")),
            Limb::Tail => (TAIL, String::new()),
            Limb::Ear => (EAR, side.into()),
            Limb::Horn => (HORN, side.into()),
        };
        for segment in segments {
            let (positions, quads) = Rounded::around(part, segment).mesh(edge);
            // The region of the middle, so that all boxes of a limb have the limb's.
            let middle = part.chain.at((segment.1 + segment.2) / 2.0).at;
            let name = (format!("{prefix}{}", segment.0), region(body, &middle).0);
            result.push(name, positions, quads.iter().map(|q| &q[..]), Motion::Rigid);
        }
    }
    for (number, hump) in body.humps.iter().enumerate() {
        let name = if body.humps.len() > 1 { format!("hump_{}", number + 1) } else { "hump".into() };
        let (positions, quads) = Rounded::on(&body.parts[0].chain, hump).mesh(edge);
        result.push((name, "trunk".into()), positions, quads.iter().map(|q| &q[..]), Motion::Rigid);
    }
    result
}

/// A box with rounded edges, one end larger than the other.
struct Rounded {
    middle: Point3<f64>,
    /// Its own x, y and z: across the limb, in its plane, along it.
    axes: Matrix3<f64>,
    /// Half its length.
    half: f64,
    /// Half sizes in its x and y, at its start and at its end.
    ends: [[f64; 2]; 2],
}

impl Rounded {
    /// Around a segment of a limb.
    fn around(part: &Part, &(_, from, to, free): &Segment) -> Self {
        let chain = &part.chain;
        let (a, b) = (chain.at(from), chain.at(to));
        let along = (b.at - a.at).normalize();
        // Boxes end short of a joint, so that there is room to bend, and reach over a free end.
        let end = |s: &super::chain::Sample, free: bool| {
            let reach = s.depth.min(s.width);
            if free { 0.5 * reach } else { -0.12 * reach.min(0.1) }
        };
        let (mut start, mut stop) = (a.at - along * end(&a, free[0]), b.at + along * end(&b, free[1]));
        if part.limb == Limb::Front || part.limb == Limb::Hind {
            // The sole is where the ground is.
            stop.y = stop.y.max(0.0);
            start.y = start.y.max(0.0);
        }
        let across = (Vector3::x() - along * along.x).normalize();
        // A square holds as much as a circle does if its half side is this share of the radius.
        let share = std::f64::consts::PI.sqrt() / 2.0;
        let ends = [0.85 * from + 0.15 * to, 0.15 * from + 0.85 * to].map(|s| {
            let at = chain.at(s);
            [share * at.width, share * at.depth]
        });
        Self {
            middle: nalgebra::center(&start, &stop),
            axes: Matrix3::from_columns(&[across, along.cross(&across), along]),
            half: (stop - start).norm() / 2.0,
            ends,
        }
    }

    /// On the back, what of a hump rises above it.
    fn on(spine: &Chain, &[y, z, width, height, length]: &[f64; 5]) -> Self {
        let back = spine.samples.iter().min_by(|a, b| (a.at.z - z).abs().total_cmp(&(b.at.z - z).abs()));
        let from = back.map_or(y, |back| back.at.y + 0.95 * back.depth);
        let to = y + 0.96 * height;
        // Half sizes of an ellipsoid at a height, in shares of the largest.
        let share = |at: f64| (1.0 - ((at - y) / height).powi(2)).max(0.0).sqrt();
        let [low, high] = [0.85 * from + 0.15 * to, 0.25 * from + 0.75 * to].map(share);
        let axes = Matrix3::from_columns(&[Vector3::x(), -Vector3::z(), Vector3::y()]);
        let ends = [[low * width, low * length], [high * width, high * length]];
        Self { middle: Point3::new(0.0, (from + to) / 2.0, z), axes, half: (to - from) / 2.0, ends }
    }

    /// Vertices and quads, with edges about `edge` long.
    fn mesh(&self, edge: f64) -> (Vec<Point3<f64>>, Vec<[u32; 4]>) {
        let mean = |axis: usize| (self.ends[0][axis] + self.ends[1][axis]) / 2.0;
        let half = [mean(0), mean(1), self.half];
        let chamfer = 0.25 * half.into_iter().fold(f64::INFINITY, f64::min);
        // Along each axis: a row for the chamfer at both ends, the rest evenly.
        let counts = half.map(|half| (2.0 * (half - chamfer) / edge).round().max(1.0) as u32 + 2);
        let place = |axis: usize, i: u32| {
            let inside = half[axis] - chamfer;
            match i {
                0 => -half[axis],
                i if i == counts[axis] => half[axis],
                i => inside * (2.0 * f64::from(i - 1) / f64::from(counts[axis] - 2) - 1.0),
            }
        };
        let vertex = |index: [u32; 3]| {
            let extreme = |axis: usize| index[axis] == 0 || index[axis] == counts[axis];
            let sides = (0..3).filter(|&axis| extreme(axis)).count();
            // What lies on two or three sides moves onto the cylinder or the sphere inscribed there.
            let back = chamfer * (1.0 - 1.0 / (sides as f64).sqrt());
            let mut own = Vector3::from_fn(|axis, _| {
                let at = place(axis, index[axis]);
                if extreme(axis) { at - back * at.signum() } else { at }
            });
            let share = (own.z / self.half + 1.0) / 2.0;
            for axis in 0..2 {
                own[axis] *= (self.ends[0][axis] * (1.0 - share) + self.ends[1][axis] * share) / mean(axis);
            }
            self.middle + self.axes * own
        };
        let (mut numbers, mut positions, mut quads) = (BTreeMap::new(), vec![], vec![]);
        let mut number = |index: [u32; 3]| {
            *numbers.entry(index).or_insert_with(|| {
                positions.push(vertex(index));
                positions.len() as u32 - 1
            })
        };
        for (axis, high) in (0..3).flat_map(|axis| [(axis, false), (axis, true)]) {
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            for (i, j) in (0..counts[u]).flat_map(|i| (0..counts[v]).map(move |j| (i, j))) {
                let mut corner = |di: u32, dj: u32| {
                    let mut index = [0; 3];
                    index[axis] = if high { counts[axis] } else { 0 };
                    (index[u], index[v]) = (i + di, j + dj);
                    number(index)
                };
                let mut quad = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
                if !high {
                    quad.reverse();
                }
                quads.push(quad);
            }
        }
        (positions, quads)
    }
}
