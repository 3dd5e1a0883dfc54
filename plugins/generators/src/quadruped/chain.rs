//! A limb: a smooth centre line with an elliptic cross-section.

use nalgebra::{Point3, Vector3};

/// The centre line of a limb with its half sizes, sampled densely.
///
/// The parameter s counts knots, so that equal s are corresponding places on every animal. The line lies nearly in a
/// plane x = constant; the cross-section has half size `depth` in that plane and `width` along x.
#[derive(Clone, Debug)]
pub struct Chain {
    /// Samples in order of s, evenly spaced in s.
    pub samples: Vec<Sample>,
    /// Samples an interval between knots.
    per_knot: usize,
    /// Box around the limb, its thickness included.
    low: Point3<f64>,
    high: Point3<f64>,
    /// Balls around runs of [`SEGMENTS_PER_BALL`] segments, thickness included: centre, radius, smallest slope of the distance.
    balls: Vec<(Point3<f64>, f64, f64)>,
}

/// A place on the centre line.
#[derive(Clone, Copy, Debug)]
pub struct Sample {
    /// The point on the line.
    pub at: Point3<f64>,
    /// Half size in the plane of the line.
    pub depth: f64,
    /// Half size along x.
    pub width: f64,
}

/// Beyond this distance (metres) from a limb's box the distance to the box stands in for that to the limb.
const MAX_EXACT_DISTANCE: f64 = 0.25;

/// Segments that share a ball.
const SEGMENTS_PER_BALL: usize = 8;

impl Chain {
    /// The line through `knots` (x, y, z, depth, width; metres), mirrored at x = 0 if `mirrored`.
    pub fn new(knots: &[[f64; 5]], per_knot: usize, mirrored: bool) -> Self {
        let side = if mirrored { -1.0 } else { 1.0 };
        let knot = |i: usize| nalgebra::SVector::<f64, 5>::from(knots[i]);
        let last = knots.len() - 1;
        let samples: Vec<Sample> = (0..=last * per_knot)
            .map(|i| {
                let (k, t) = ((i / per_knot).min(last - 1), i as f64 / per_knot as f64);
                let t = t - k as f64;
                // Catmull-Rom; the tangent at an end is that of the first or last chord.
                let (a, b) = (knot(k), knot(k + 1));
                let from = if k > 0 { (b - knot(k - 1)) / 2.0 } else { b - a };
                let to = if k + 1 < last { (knot(k + 2) - a) / 2.0 } else { b - a };
                let (t2, t3) = (t * t, t * t * t);
                let v = a * (2.0 * t3 - 3.0 * t2 + 1.0)
                    + from * (t3 - 2.0 * t2 + t)
                    + b * (3.0 * t2 - 2.0 * t3)
                    + to * (t3 - t2);
                Sample { at: Point3::new(side * v[0], v[1], v[2]), depth: v[3], width: v[4] }
            })
            .collect();
        let reach = |s: &Sample| Vector3::new(s.width, s.depth, s.depth);
        let low = samples.iter().fold(samples[0].at, |low, s| low.inf(&(s.at - reach(s))));
        let high = samples.iter().fold(samples[0].at, |high, s| high.sup(&(s.at + reach(s))));
        let balls = (0..samples.len() - 1).step_by(SEGMENTS_PER_BALL).map(|first| {
            let run = &samples[first..=(first + SEGMENTS_PER_BALL).min(samples.len() - 1)];
            let centre = nalgebra::center(&run[0].at, &run[run.len() - 1].at);
            let radius = run.iter().map(|s| (s.at - centre).norm() + s.depth.max(s.width)).fold(0.0, f64::max);
            (centre, radius, run.iter().map(|s| (s.width / s.depth).min(1.0)).fold(1.0, f64::min))
        });
        let balls = balls.collect();
        Self { samples, per_knot, low, high, balls }
    }

    /// The s of sample `index`.
    pub fn parameter(&self, index: usize) -> f64 {
        index as f64 / self.per_knot as f64
    }

    /// The sample before `s` and how far `s` is on the way to the next, 0 to 1.
    pub fn locate(&self, s: f64) -> (usize, f64) {
        let place = (s * self.per_knot as f64).clamp(0.0, (self.samples.len() - 1) as f64);
        let index = (place as usize).min(self.samples.len() - 2);
        (index, place - index as f64)
    }

    /// The place on the line at `s`.
    pub fn at(&self, s: f64) -> Sample {
        let (i, t) = self.locate(s);
        let (a, b) = (self.samples[i], self.samples[i + 1]);
        let mix = |a: f64, b: f64| a + (b - a) * t;
        Sample { at: a.at + (b.at - a.at) * t, depth: mix(a.depth, b.depth), width: mix(a.width, b.width) }
    }

    /// Direction of growing s at `s`, of length 1.
    pub fn tangent(&self, s: f64) -> Vector3<f64> {
        let (i, _) = self.locate(s);
        (self.samples[i + 1].at - self.samples[i].at).normalize()
    }

    /// About the distance from `point` to the limb's surface, negative inside, and half the thickness of the limb
    /// there.
    ///
    /// Far from the limb the distance is that to its box, which is smaller.
    pub fn distance(&self, point: &Point3<f64>) -> (f64, f64) {
        let outside = (self.low - point).sup(&(point - self.high)).sup(&Vector3::zeros()).norm();
        if outside > MAX_EXACT_DISTANCE {
            return (outside, f64::INFINITY);
        }
        let bound = |&(centre, radius, slope): &(Point3<f64>, f64, f64)| {
            let distance = (point - centre).norm() - radius;
            if distance > 0.0 { distance * slope } else { distance }
        };
        // The most promising run first, so that most of the others need not be looked at.
        let first = (0..self.balls.len()).map(|run| (bound(&self.balls[run]), run));
        let first = first.min_by(|a, b| a.0.total_cmp(&b.0)).map_or(0, |(_, run)| run);
        let mut nearest = self.distance_to_run(first, point);
        for (run, ball) in self.balls.iter().enumerate() {
            if run != first && bound(ball) < nearest.0 {
                let other = self.distance_to_run(run, point);
                if other.0 < nearest.0 {
                    nearest = other;
                }
            }
        }
        nearest
    }

    fn distance_to_run(&self, run: usize, point: &Point3<f64>) -> (f64, f64) {
        let mut nearest = (f64::INFINITY, 0.0);
        let last = (run * SEGMENTS_PER_BALL + SEGMENTS_PER_BALL).min(self.samples.len() - 1);
        for pair in self.samples[run * SEGMENTS_PER_BALL..=last].windows(2) {
            let (a, b) = (&pair[0], &pair[1]);
            let (from, along) = (point - a.at, b.at - a.at);
            // The foot is sought in the plane of the line, so that it does not depend on the flattening along x.
            let length = along.y * along.y + along.z * along.z;
            let t = ((from.y * along.y + from.z * along.z) / length).clamp(0.0, 1.0);
            let (depth, width) = (a.depth + (b.depth - a.depth) * t, a.width + (b.width - a.width) * t);
            let away = from - along * t;
            let ratio = depth / width;
            let stretched = (away.x * ratio * away.x * ratio + away.y * away.y + away.z * away.z).sqrt();
            let distance = (stretched - depth) * (width / depth).min(1.0);
            if distance < nearest.0 {
                nearest = (distance, depth.min(width));
            }
        }
        nearest
    }

    /// The s of a point on or near the limb: the mean over the line, weighted by exp(−D²/2σ²) with D the distance in
    /// the stretched cross-section and σ a share of the depth there.
    ///
    /// Unlike the nearest point it is smooth where the line bends inwards.
    pub fn soft_parameter(&self, point: &Point3<f64>) -> f64 {
        const SHARE: f64 = 0.35;
        let squared = |s: &Sample| {
            let away = point - s.at;
            let x = away.x * s.depth / s.width;
            x * x + away.y * away.y + away.z * away.z
        };
        let distances: Vec<f64> = self.samples.iter().map(squared).collect();
        let least = distances.iter().copied().fold(f64::INFINITY, f64::min);
        let (mut sum, mut total) = (0.0, 0.0);
        for (i, (sample, distance)) in self.samples.iter().zip(&distances).enumerate() {
            let sigma = SHARE * sample.depth;
            let exponent = (distance - least) / (2.0 * sigma * sigma);
            if exponent < 30.0 {
                let neighbour = self.samples[if i + 1 < self.samples.len() { i + 1 } else { i - 1 }];
                let weight = (-exponent).exp() * (neighbour.at - sample.at).norm();
                sum += weight * self.parameter(i);
                total += weight;
            }
        }
        sum / total
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn straight() -> Chain {
        let knots: Vec<[f64; 5]> = (0..5).map(|k| [0.1, 1.0, 0.5 * f64::from(k), 0.2, 0.1]).collect();
        Chain::new(&knots, 8, false)
    }

    #[test]
    fn a_straight_limb_has_the_distances_of_an_elliptic_cylinder() {
        let (chain, close) = (straight(), |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} {b}"));
        close(chain.distance(&Point3::new(0.1, 1.2, 1.0)).0, 0.0);
        close(chain.distance(&Point3::new(0.2, 1.0, 1.0)).0, 0.0);
        close(chain.distance(&Point3::new(0.3, 1.0, 1.0)).0, 0.1);
        close(chain.distance(&Point3::new(0.1, 1.0, 1.0)).0, -0.1);
        close(chain.distance(&Point3::new(0.1, 1.0, 1.0)).1, 0.1);
    }

    #[test]
    fn the_soft_parameter_runs_along_a_straight_limb() {
        // Away from the ends, where the mean over the line is one-sided.
        for s in [1.5, 2.0, 2.3] {
            let found = straight().soft_parameter(&Point3::new(0.1, 1.2, 0.5 * s));
            assert!((found - s).abs() < 2e-3, "{found} {s}");
        }
    }
}
