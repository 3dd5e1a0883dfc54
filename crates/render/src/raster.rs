//! Filling triangles into a depth buffer.
//!
//! Corners are snapped to 1/256 of a sample and compared in integers, so that triangles with a common edge neither overlap
//! nor leave a gap, in whatever order they come. A sample holds its depth in the upper and its colour in the lower half
//! of one number and keeps the least. So of surfaces in the same place the same one wins every time.

use crate::colour::Colour;
use crate::shade::Shade;

/// Corners are snapped to this part of a sample.
const STEPS: i32 = 256;

/// A corner farther from the origin than this many samples is not drawn; products of two differences stay below 2^62.
const MAX_DISTANCE: f64 = 2_097_152.0;

/// A corner in the depth buffer.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Corner {
    x: i32,
    y: i32,
    depth: f32,
}

impl Corner {
    /// Returns the corner at a place counted in samples; `None` if it lies too far off to be drawn.
    pub(crate) fn new(x: f64, y: f64, depth: f64) -> Option<Self> {
        let within = x.abs() <= MAX_DISTANCE && y.abs() <= MAX_DISTANCE && depth.abs() <= f64::from(f32::MAX);
        let snap = |c: f64| (c * f64::from(STEPS)).round() as i32;
        within.then(|| Self { x: snap(x), y: snap(y), depth: depth as f32 })
    }
}

/// The nearest surface at each sample of a grid.
#[derive(Clone, Debug)]
pub(crate) struct Samples {
    pub(crate) width: usize,
    pub(crate) height: usize,
    nearest: Vec<u64>,
}

const EMPTY: u64 = u64::MAX;

impl Samples {
    pub(crate) fn new(width: usize, height: usize) -> Self {
        Self { width, height, nearest: vec![EMPTY; width * height] }
    }

    /// Returns the depth and colour of the nearest surface; `None` where there is none.
    pub(crate) fn at(&self, x: usize, y: usize) -> Option<(f32, Colour)> {
        if x >= self.width || y >= self.height {
            return None;
        }
        let packed = *self.nearest.get(y * self.width + x)?;
        let [_, r, g, b] = (packed as u32).to_be_bytes();
        (packed != EMPTY).then(|| (from_ordered((packed >> 32) as u32), [r, g, b]))
    }

    /// Draws a triangle.
    ///
    /// `make_shade` gets whether the front is seen, and is called only if some sample of the triangle is nearest so far.
    pub(crate) fn fill(&mut self, corners: [Corner; 3], make_shade: impl FnOnce(bool) -> Shade) {
        let [mut a, mut b, c] = corners;
        let area = edge(a, b, c.x, c.y);
        if area == 0 {
            return;
        }
        // y points down here, so corners that run counter-clockwise to the viewer have a negative area.
        let front = area < 0;
        if front {
            std::mem::swap(&mut a, &mut b);
        }
        let first = |lowest: i32| (lowest - STEPS / 2 + STEPS - 1).div_euclid(STEPS).max(0);
        let last = |highest: i32, end: usize| (highest - STEPS / 2).div_euclid(STEPS).min(end as i32 - 1);
        let (left, right) = (first(a.x.min(b.x).min(c.x)), last(a.x.max(b.x).max(c.x), self.width));
        let (top, bottom) = (first(a.y.min(b.y).min(c.y)), last(a.y.max(b.y).max(c.y), self.height));
        if left > right || top > bottom {
            return;
        }
        let (x, y) = (left * STEPS + STEPS / 2, top * STEPS + STEPS / 2);
        let edges = [(b, c), (c, a), (a, b)];
        let mut row_start = edges.map(|(from, to)| edge(from, to, x, y) - i64::from(!owns(from, to)));
        let right_step = edges.map(|(from, to)| -i64::from(to.y - from.y) * i64::from(STEPS));
        let down_step = edges.map(|(from, to)| i64::from(to.x - from.x) * i64::from(STEPS));
        let over_area = 1.0 / area.unsigned_abs() as f32;
        let mut shade = None;
        let mut make_shade = Some(make_shade);
        for row in top as usize..=bottom as usize {
            let mut inside = row_start;
            let mut entered = false;
            let samples = &mut self.nearest[row * self.width + left as usize..=row * self.width + right as usize];
            for sample in samples {
                if inside[0] | inside[1] | inside[2] >= 0 {
                    entered = true;
                    let [u, v, w] = inside.map(|e| e as f32 * over_area);
                    let depth = u64::from(to_ordered(u * a.depth + v * b.depth + w * c.depth)) << 32;
                    if depth | 0xffff_ffff <= *sample | 0xffff_ffff {
                        if let Some(make) = make_shade.take() {
                            shade = Some(make(front));
                        }
                        let barycentric = if front { [v, u, w] } else { [u, v, w] };
                        let [r, g, b] = shade.as_ref().map_or([0; 3], |shade: &Shade| shade.colour(barycentric));
                        *sample = (*sample).min(depth | u64::from(u32::from_be_bytes([0, r, g, b])));
                    }
                } else if entered {
                    break;
                }
                (0..3).for_each(|i| inside[i] += right_step[i]);
            }
            (0..3).for_each(|i| row_start[i] += down_step[i]);
        }
    }
}

/// Returns twice the area of the triangle of an edge and a point: positive on its right as seen with y down.
fn edge(from: Corner, to: Corner, x: i32, y: i32) -> i64 {
    i64::from(to.x - from.x) * (i64::from(y) - i64::from(from.y))
        - i64::from(to.y - from.y) * (i64::from(x) - i64::from(from.x))
}

/// Returns whether a triangle owns the samples on its edge, which it does if the edge is at its left or its top.
fn owns(from: Corner, to: Corner) -> bool {
    to.y < from.y || (to.y == from.y && to.x > from.x)
}

/// Returns bits that sort as the numbers do.
fn to_ordered(depth: f32) -> u32 {
    let bits = depth.to_bits();
    if bits >> 31 == 1 { !bits } else { bits | 1 << 31 }
}

fn from_ordered(ordered: u32) -> f32 {
    f32::from_bits(if ordered >> 31 == 1 { ordered & !(1 << 31) } else { !ordered })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn covered(samples: &Samples) -> Vec<bool> {
        (0..samples.height).flat_map(|y| (0..samples.width).map(move |x| samples.at(x, y).is_some())).collect()
    }

    fn drawn(corners: [[f64; 2]; 3]) -> Vec<bool> {
        let mut samples = Samples::new(32, 32);
        samples.fill(corners.map(|[x, y]| Corner::new(x, y, 1.0).unwrap()), |_| Shade::plain([9, 9, 9]));
        covered(&samples)
    }

    proptest! {
        #[test]
        fn triangles_around_a_point_cover_each_sample_of_the_square_once(x in 0.0..32.0f64, y in 0.0..32.0f64) {
            // Sample centres on edges and corners are where a wrong rule would show, hence the snapping.
            for [x, y] in [[x, y], [x.round(), y.round()], [x.floor() + 0.5, y.floor() + 0.5]] {
                let [x, y] = [f64::clamp(x, 0.0, 32.0), f64::clamp(y, 0.0, 32.0)];
                let corners = [[0.0, 0.0], [32.0, 0.0], [32.0, 32.0], [0.0, 32.0]];
                let mut count = vec![0; 32 * 32];
                for side in 0..4 {
                    let fan = drawn([corners[side], corners[(side + 1) % 4], [x, y]]);
                    count.iter_mut().zip(fan).for_each(|(count, covered)| *count += i32::from(covered));
                }
                prop_assert!(count.iter().all(|count| *count == 1));
            }
        }

        #[test]
        fn ordered_bits_sort_as_numbers_do(a in -1e30f32..1e30, b in -1e30f32..1e30) {
            prop_assert_eq!(a.total_cmp(&b), to_ordered(a).cmp(&to_ordered(b)));
            prop_assert_eq!(from_ordered(to_ordered(a)), a);
        }
    }

    #[test]
    fn depth_in_the_middle_of_an_edge_is_the_mean_of_its_ends() {
        let mut samples = Samples::new(8, 8);
        let corner = |x, y, depth| Corner::new(x, y, depth).unwrap();
        samples
            .fill([corner(0.5, 0.5, 0.0), corner(6.5, 0.5, 6.0), corner(0.5, 6.5, -12.0)], |_| Shade::plain([1, 2, 3]));
        let (depth, _) = samples.at(3, 0).unwrap();
        // Single precision, and a bias of one unit of area at edges not owned: far below a hundredth of a pixel.
        assert!((depth - 3.0).abs() < 1e-3);
        assert!((samples.at(0, 3).unwrap().0 + 6.0).abs() < 1e-3);
    }

    #[test]
    fn the_front_is_where_corners_run_counter_clockwise() {
        let place = [[1.0, 7.0], [7.0, 7.0], [1.0, 1.0]].map(|[x, y]| Corner::new(x, y, 0.0).unwrap());
        let mut seen = Vec::new();
        for corners in [place, [place[1], place[0], place[2]]] {
            Samples::new(8, 8).fill(corners, |front| {
                seen.push(front);
                Shade::plain([0; 3])
            });
        }
        assert_eq!(seen, [true, false]);
    }
}
