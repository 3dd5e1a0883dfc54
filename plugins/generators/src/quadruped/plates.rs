//! The animal as plates: its skin cut along the borders of a Voronoi diagram, with a gap between, and given a thickness.
//!
//! The diagram lives in places and normals together, so that a plate is nearly flat and does not reach around a limb or
//! across to another. Triangles are cut where a border passes through them; a vertex that lies close to the cut moves
//! onto it, so that no splinters arise.

use std::collections::BTreeMap;

use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

use super::{
    body::Body,
    pieces::{Motion, Pieces, Sheet, named, region},
    sites::{Cloud, Site, nearest},
};

/// About `count` plates from the skin `positions`, `triangles` of `body`.
pub fn plates(body: &Body, positions: &[Point3<f64>], triangles: &[[u32; 3]], (count, seed): (usize, u64)) -> Pieces {
    let skin = Skin::new(body, positions, triangles, count);
    let sites = skin.cloud.sites(count, seed);
    let owners: Vec<usize> = skin.cloud.places.par_iter().map(|place| nearest(&sites, place)).collect();
    let cut: Vec<_> = (0..sites.len()).into_par_iter().map(|site| skin.plates_of(&sites, &owners, site)).collect();
    let outers: Vec<Outer> = cut.into_iter().flatten().collect();
    let places: Vec<_> = outers.iter().map(|outer| region(body, &outer.middle())).collect();
    let mut result = Pieces::default();
    for (index, name) in named(&places) {
        let outer = &outers[index];
        let positions: Vec<_> = outer.positions.iter().map(|p| body.project(*p)).collect();
        let depths: Vec<f64> = positions.iter().map(|p| (0.25 * body.thickness(p)).min(skin.thickness)).collect();
        let count = positions.len() as u32;
        let sheet = Sheet { outer: outer.triangles.clone(), depths };
        let inner = sheet.inner(&positions);
        let mut all = outer.triangles.clone();
        all.extend(outer.triangles.iter().map(|&[a, b, c]| [a + count, c + count, b + count]));
        for [a, b] in outer.border() {
            all.extend([[b, a, a + count], [b, a + count, b + count]]);
        }
        result.push(name, [positions, inner].concat(), all.iter().map(|t| &t[..]), Motion::Sheet(sheet));
    }
    result
}

/// The skin, to be cut.
struct Skin<'a> {
    positions: &'a [Point3<f64>],
    triangles: &'a [[u32; 3]],
    cloud: Cloud,
    /// The thickness of the plates, where the body is not thin.
    thickness: f64,
    /// The width of the gap between plates, at each vertex.
    gaps: Vec<f64>,
}

impl<'a> Skin<'a> {
    fn new(body: &Body, positions: &'a [Point3<f64>], triangles: &'a [[u32; 3]], count: usize) -> Self {
        let mut normals = vec![Vector3::zeros(); positions.len()];
        for t in triangles {
            let [a, b, c] = t.map(|v| positions[v as usize]);
            let normal = (b - a).cross(&(c - a)) / 6.0;
            t.iter().for_each(|&v| normals[v as usize] += normal);
        }
        let weights: Vec<f64> = normals.iter().map(|n| n.norm()).collect();
        // The side of a plate, were all equal.
        let size = (weights.iter().sum::<f64>() / count as f64).sqrt();
        let thickness: Vec<f64> = positions.par_iter().map(|p| body.thickness(p)).collect();
        let places = positions.iter().zip(&normals).map(|(p, n)| {
            // Opposite normals are as far apart as plates are wide.
            let n = n.normalize() * (0.5 * size);
            Site::new(p.x, p.y, p.z, n.x, n.y, n.z)
        });
        let gaps = thickness.iter().map(|t| (0.2 * t).min(0.06 * size)).collect();
        let cloud = Cloud { places: places.collect(), weights, sizes: thickness.iter().map(|t| t.sqrt()).collect() };
        Self { positions, triangles, cloud, thickness: 0.1 * size, gaps }
    }

    /// The outer sides of the plates that the cell of `site` gives: one, or more if the cell falls apart.
    fn plates_of(&self, sites: &[Site], owners: &[usize], site: usize) -> Vec<Outer> {
        let touched: Vec<[u32; 3]> =
            self.triangles.iter().copied().filter(|t| t.iter().any(|&v| owners[v as usize] == site)).collect();
        let values = self.values(sites, site, &touched);
        let mut plates = cut(self.positions, &touched, values);
        // Crumbs at the meeting of borders are left out.
        let largest = plates.iter().map(Outer::area).fold(0.0, f64::max);
        plates.retain(|plate| plate.area() > 0.15 * largest);
        plates
    }

    /// How far inside the plate of `site` the vertices of `triangles` lie, by vertex.
    fn values(&self, sites: &[Site], site: usize, triangles: &[[u32; 3]]) -> BTreeMap<u32, f64> {
        let inside = |v: u32| {
            let place = &self.cloud.places[v as usize];
            let own = (place - sites[site]).norm_squared();
            let others = sites.iter().enumerate().filter(|(other, _)| *other != site);
            let border = |(_, other): (usize, &Site)| {
                ((place - other).norm_squared() - own) / (2.0 * (other - sites[site]).norm())
            };
            others.map(border).fold(f64::INFINITY, f64::min)
        };
        let mut values: BTreeMap<u32, f64> = triangles.iter().flatten().map(|&v| (v, 0.0)).collect();
        values.iter_mut().for_each(|(&v, value)| *value = inside(v));
        // Where normals turn, values change faster than places do: their slope makes lengths of them.
        let mut slopes: BTreeMap<u32, (f64, f64)> = BTreeMap::new();
        for t in triangles {
            let [a, b, c] = t.map(|v| self.positions[v as usize]);
            let normal = (b - a).cross(&(c - a));
            let opposite = [(c - b, t[0]), (a - c, t[1]), (b - a, t[2])];
            let gradient = opposite.iter().map(|(edge, v)| normal.cross(edge) * values[v]).sum::<Vector3<f64>>();
            let area = normal.norm();
            for v in t {
                let slope = slopes.entry(*v).or_default();
                // gradient is the true one times the square of twice the area.
                *slope = (slope.0 + gradient.norm() / area, slope.1 + area);
            }
        }
        for (v, value) in &mut values {
            let (sum, area) = slopes[v];
            *value = *value / (sum / area).clamp(0.3, 5.0) - self.gaps[*v as usize] / 2.0;
        }
        values
    }
}

/// The outer side of a plate.
#[derive(Debug, Default)]
struct Outer {
    positions: Vec<Point3<f64>>,
    triangles: Vec<[u32; 3]>,
}

impl Outer {
    fn area(&self) -> f64 {
        let area = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|v| self.positions[v as usize]);
            (b - a).cross(&(c - a)).norm() / 2.0
        };
        self.triangles.iter().map(area).sum()
    }

    fn middle(&self) -> Point3<f64> {
        let sum: Vector3<f64> = self.positions.iter().map(|p| p.coords).sum();
        Point3::from(sum / self.positions.len() as f64)
    }

    /// Edges of one triangle, in its direction.
    fn border(&self) -> Vec<[u32; 2]> {
        let mut edges: BTreeMap<[u32; 2], u32> = BTreeMap::new();
        for &[a, b, c] in &self.triangles {
            for edge in [[a, b], [b, c], [c, a]] {
                *edges.entry(edge).or_default() += 1;
            }
        }
        edges.keys().copied().filter(|&[a, b]| !edges.contains_key(&[b, a])).collect()
    }
}

/// The parts of `triangles` where the values of the corners, linear between, are positive: connected pieces.
fn cut(positions: &[Point3<f64>], triangles: &[[u32; 3]], values: BTreeMap<u32, f64>) -> Vec<Outer> {
    /// Shares of an edge nearer to its end than this are not cut off; the end moves to the cut.
    const MIN_EDGE_SHARE: f64 = 0.25;
    let mut snapped: BTreeMap<u32, (f64, Point3<f64>)> = BTreeMap::new();
    for t in triangles {
        for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0]), (t[1], t[0]), (t[2], t[1]), (t[0], t[2])] {
            let (from, to) = (values[&a], values[&b]);
            let share = from / (from - to);
            if from * to < 0.0 && share < MIN_EDGE_SHARE && snapped.get(&a).is_none_or(|best| share < best.0) {
                let (p, q) = (positions[a as usize], positions[b as usize]);
                snapped.insert(a, (share, p + (q - p) * share));
            }
        }
    }
    let value = |v: u32| if snapped.contains_key(&v) { 0.0 } else { values[&v] };
    let place = |v: u32| snapped.get(&v).map_or(positions[v as usize], |s| s.1);

    // A vertex of the result is one of the skin, or the cut of one of its edges.
    let mut corners: Vec<[(u32, u32); 3]> = vec![];
    for t in triangles {
        let signs = t.map(value);
        let Some(turn) = (0..3).find(|&k| signs[k] > 0.0 && signs[(k + 2) % 3] <= 0.0) else {
            if signs.iter().all(|&s| s > 0.0) {
                corners.push(t.map(|v| (v, v)));
            }
            continue;
        };
        let [a, b, c] = [0, 1, 2].map(|k| t[(turn + k) % 3]);
        let [_, at_b, at_c] = [0, 1, 2].map(|k| signs[(turn + k) % 3]);
        let own = |v: u32| (v, v);
        let between = |v: u32, w: u32, at: f64| if at == 0.0 { own(w) } else { (v.min(w), v.max(w)) };
        if at_b > 0.0 {
            // a and b are inside: what remains has four corners, or three if c lies on the cut.
            let (from_b, from_a) = (between(b, c, at_c), between(a, c, at_c));
            corners.push([own(a), own(b), from_b]);
            if from_a != from_b {
                corners.push([own(a), from_b, from_a]);
            }
        } else {
            corners.push([own(a), between(a, b, at_b), between(a, c, at_c)]);
        }
    }
    let at = |(a, b): (u32, u32)| {
        if a == b {
            return place(a);
        }
        let (from, to) = (values[&a], values[&b]);
        place(a) + (place(b) - place(a)) * (from / (from - to))
    };
    pieces(&corners).into_iter().map(|piece| piece.outer(&at)).collect()
}

/// A connected piece: triangles by the names of their corners, and by numbers that hold corners apart which only touch.
#[derive(Default)]
struct Piece {
    names: Vec<(u32, u32)>,
    triangles: Vec<[u32; 3]>,
}

impl Piece {
    fn outer(self, at: &impl Fn((u32, u32)) -> Point3<f64>) -> Outer {
        Outer { positions: self.names.into_iter().map(at).collect(), triangles: self.triangles }
    }
}

/// The pieces that hang together by edges; a vertex at which a piece merely touches itself becomes several.
fn pieces(triangles: &[[(u32, u32); 3]]) -> Vec<Piece> {
    // Across an edge, triangles and the corners at both its ends are one.
    let mut whole = Groups::new(triangles.len());
    let mut ends = Groups::new(3 * triangles.len());
    let mut edges: BTreeMap<[(u32, u32); 2], (usize, usize)> = BTreeMap::new();
    for (t, names) in triangles.iter().enumerate() {
        for (k, l) in [(0, 1), (1, 2), (2, 0)] {
            if let Some(&(other, from)) = edges.get(&[names[l], names[k]]) {
                whole.join(t, other);
                ends.join(3 * t + l, 3 * other + from);
                ends.join(3 * t + k, 3 * other + (from + 1) % 3);
            }
            edges.insert([names[k], names[l]], (t, k));
        }
    }
    let mut result: BTreeMap<usize, Piece> = BTreeMap::new();
    let mut numbers: BTreeMap<usize, u32> = BTreeMap::new();
    for (t, names) in triangles.iter().enumerate() {
        let piece = result.entry(whole.of(t)).or_default();
        let corners = [0, 1, 2].map(|k| {
            *numbers.entry(ends.of(3 * t + k)).or_insert_with(|| {
                piece.names.push(names[k]);
                piece.names.len() as u32 - 1
            })
        });
        piece.triangles.push(corners);
    }
    result.into_values().collect()
}

/// Things joined into groups.
struct Groups(Vec<usize>);

impl Groups {
    fn new(count: usize) -> Self {
        Self((0..count).collect())
    }

    /// The first of the group of `thing`.
    fn of(&mut self, thing: usize) -> usize {
        let mut first = thing;
        while self.0[first] != first {
            self.0[first] = self.0[self.0[first]];
            first = self.0[first];
        }
        first
    }

    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.of(a), self.of(b));
        self.0[a.max(b)] = a.min(b);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two triangles over a unit square.
    fn square() -> (Vec<Point3<f64>>, Vec<[u32; 3]>) {
        let p = |x: f64, y: f64| Point3::new(x, y, 0.0);
        (vec![p(0., 0.), p(1., 0.), p(1., 1.), p(0., 1.)], vec![[0, 1, 2], [0, 2, 3]])
    }

    #[test]
    fn a_cut_takes_the_part_where_values_are_positive() {
        let (positions, triangles) = square();
        // Linear in x: the square is cut at x = 0.4.
        let values = positions.iter().enumerate().map(|(v, p)| (v as u32, p.x - 0.4)).collect();
        let [outer] = &cut(&positions, &triangles, values)[..] else { panic!("one piece") };
        assert!((outer.area() - 0.6).abs() < 1e-12);
        assert_eq!(outer.border().len(), outer.positions.len());
    }

    #[test]
    fn a_vertex_near_the_cut_moves_onto_it() {
        let (positions, triangles) = square();
        let values = positions.iter().enumerate().map(|(v, p)| (v as u32, p.x - 0.1)).collect();
        let outers = cut(&positions, &triangles, values);
        assert!(outers[0].positions.len() == 4 && (outers[0].area() - 0.9).abs() < 1e-12, "{outers:?}");
    }

    #[test]
    fn triangles_that_touch_at_a_corner_are_two_pieces_of_their_own_vertices() {
        let name = |v: u32| (v, v);
        let pieces = pieces(&[[0, 1, 2].map(name), [2, 3, 4].map(name)]);
        assert_eq!(pieces.iter().map(|piece| piece.names.len()).collect::<Vec<_>>(), [3, 3]);
    }
}
