//! The animal as an implicit surface: its limbs, smoothly joined.

use nalgebra::{Point3, Vector3};

use super::{animals::Animal, chain::Chain};

/// The limb.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Limb {
    /// Trunk, neck and head; the others hang on it.
    Spine,
    /// A front leg.
    Front,
    /// A hind leg.
    Hind,
    /// The tail.
    Tail,
    /// An ear.
    Ear,
    /// A horn.
    Horn,
}

/// A limb of one side.
#[derive(Debug)]
pub struct Part {
    /// Which.
    pub limb: Limb,
    /// Whether it is on the animal's right.
    pub right: bool,
    /// Its centre line.
    pub chain: Chain,
    /// The s on the spine that it hangs on.
    pub attached: f64,
    /// Length over which its surface runs into that of the others, metres.
    blend: f64,
}

/// An animal's body in metres.
#[derive(Debug)]
pub struct Body {
    /// The spine first, then the others, left before right.
    pub parts: Vec<Part>,
    /// Humps: centre y and z, half sizes along x, y, z.
    pub humps: &'static [[f64; 5]],
}

impl Body {
    /// The body of `animal`.
    pub fn new(animal: &'static Animal) -> Self {
        // Fine enough that the segments of the centre line do not show on the surface.
        let per_knot = 16;
        let mut parts = vec![];
        let mut add = |limb, knots: &[[f64; 5]], attached: f64, blend: f64, paired: bool| {
            for right in [false, true].into_iter().take(1 + usize::from(paired)) {
                parts.push(Part { limb, right, chain: Chain::new(knots, per_knot, right), attached, blend });
            }
        };
        add(Limb::Spine, &animal.spine, 0.0, 0.0, false);
        add(Limb::Front, &animal.front, 4.8, 0.55 * animal.front[0][3], true);
        add(Limb::Hind, &animal.hind, 1.0, 0.55 * animal.hind[0][3], true);
        add(Limb::Tail, &animal.tail, 0.5, 0.9 * animal.tail[0][3], false);
        add(Limb::Ear, &animal.ear, 10.6, 0.6 * animal.ear[0][3], true);
        if let Some(horn) = &animal.horn {
            add(Limb::Horn, horn, 10.6, 0.6 * horn[0][3], true);
        }
        Self { parts, humps: animal.humps }
    }

    /// About the distance to the surface, negative inside; the surface is its zero set.
    ///
    /// Mirror images in x = 0 have bit-equal values.
    pub fn distance(&self, point: &Point3<f64>) -> f64 {
        let distance = |part: &Part| part.chain.distance(point).0;
        let mut result = self.trunk(point);
        let mut rest = &self.parts[1..];
        while let Some((first, others)) = rest.split_first() {
            let mut limb = distance(first);
            rest = others;
            if let Some((twin, others)) = others.split_first().filter(|(twin, _)| twin.limb == first.limb) {
                // Joined with each other first, both sides are treated alike.
                limb = smooth_min(limb, distance(twin), first.blend);
                rest = others;
            }
            result = smooth_min(result, limb, first.blend);
        }
        // Soles are flat, the ground is y = 0.
        smooth_max(result, -point.y, 0.015)
    }

    /// The distance to trunk, neck and head with the humps.
    pub fn trunk(&self, point: &Point3<f64>) -> f64 {
        let mut result = self.parts[0].chain.distance(point).0;
        for &[y, z, rx, ry, rz] in self.humps {
            let half = Vector3::new(rx, ry, rz);
            let away = point - Point3::new(0.0, y, z);
            let (unit, slope) = (away.component_div(&half), away.component_div(&half.component_mul(&half)));
            // First-order distance to an ellipsoid; at its centre, where there is no slope, the shortest half size.
            let distance = if slope.norm() > 1e-9 { unit.norm() * (unit.norm() - 1.0) / slope.norm() } else { -rx };
            result = smooth_min(result, distance, 0.2);
        }
        result
    }

    /// Half the thickness of the limb nearest to `point`.
    pub fn thickness(&self, point: &Point3<f64>) -> f64 {
        let nearest = self.parts.iter().map(|part| part.chain.distance(point));
        nearest.fold((f64::INFINITY, f64::INFINITY), |best, next| if next.0 < best.0 { next } else { best }).1
    }

    /// Gradient of [`distance`](Self::distance), by differences over the corners of a tetrahedron.
    pub fn gradient(&self, point: &Point3<f64>) -> Vector3<f64> {
        const STEP: f64 = 5e-4;
        let corners = [[1., -1., -1.], [-1., -1., 1.], [-1., 1., -1.], [1., 1., 1.]].map(Vector3::from);
        corners.iter().map(|corner| corner * self.distance(&(point + corner * STEP))).sum::<Vector3<f64>>()
            / (4.0 * STEP)
    }

    /// The point of the surface near `point`: Newton steps along the gradient.
    pub fn project(&self, mut point: Point3<f64>) -> Point3<f64> {
        for _ in 0..3 {
            let distance = self.distance(&point);
            if distance.abs() < 1e-6 {
                break;
            }
            // Where limbs meet the field is flatter than a distance; the bound keeps steps within reason.
            let gradient = self.gradient(&point);
            point -= gradient * (distance / gradient.norm_squared().max(0.1));
        }
        point
    }

    /// Smallest and largest corner of a box that holds the body.
    pub fn bounds(&self) -> (Point3<f64>, Point3<f64>) {
        let samples = || self.parts.iter().flat_map(|part| &part.chain.samples);
        let reach = |s: &super::chain::Sample| Vector3::new(s.width, s.depth, s.depth) * 1.2;
        let origin = self.parts[0].chain.samples[0].at;
        let mut low = samples().fold(origin, |low, s| low.inf(&(s.at - reach(s))));
        let mut high = samples().fold(origin, |high, s| high.sup(&(s.at + reach(s))));
        for &[y, z, rx, ry, rz] in self.humps {
            low = low.inf(&Point3::new(-rx, y - ry, z - rz));
            high = high.sup(&Point3::new(rx, y + ry, z + rz));
        }
        low.y = low.y.max(-0.02);
        (low, high)
    }
}

/// The larger of `a` and `b`, with the crease rounded off where they differ by less than `blend`.
pub fn smooth_max(a: f64, b: f64, blend: f64) -> f64 {
    -smooth_min(-a, -b, blend)
}

/// The smaller of `a` and `b`, with the crease rounded off where they differ by less than `blend`.
fn smooth_min(a: f64, b: f64, blend: f64) -> f64 {
    let share = (blend - (a - b).abs()).max(0.0);
    // For no blend there is no share either.
    if share > 0.0 { a.min(b) - share * share / (4.0 * blend) } else { a.min(b) }
}
