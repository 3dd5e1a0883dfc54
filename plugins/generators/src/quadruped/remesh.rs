//! Well-shaped triangles of a given size on a surface that points can be projected to.
//!
//! Split long edges, collapse short ones, flip edges to Delaunay, move vertices to the middle of their neighbours
//! along the surface, project; again [Botsch and Kobbelt 2004]. Topology is kept. Sequential where order matters, so
//! equal input gives equal output on any number of threads.

use std::collections::HashMap;

use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

/// A mesh in the making: triangles around each vertex are kept up to date.
struct Editor {
    positions: Vec<Point3<f64>>,
    /// The edge length wanted at each vertex.
    lengths: Vec<f64>,
    /// Removed ones have equal corners.
    triangles: Vec<[u32; 3]>,
    around: Vec<Vec<u32>>,
}

/// Remeshes a closed manifold so that edges are about `length` long; `project` moves a point onto the surface.
pub fn remesh(
    positions: Vec<Point3<f64>>,
    triangles: Vec<[u32; 3]>,
    length: impl Fn(&Point3<f64>) -> f64 + Sync,
    project: impl Fn(Point3<f64>) -> Point3<f64> + Sync,
    rounds: usize,
) -> (Vec<Point3<f64>>, Vec<[u32; 3]>) {
    let (mut positions, mut triangles) = (positions, triangles);
    let mut lengths: Vec<f64> = positions.par_iter().map(&length).collect();
    for round in 0..rounds {
        split(&mut positions, &mut lengths, &mut triangles);
        let mut editor = Editor::new(positions, lengths, triangles);
        // Marching leaves many tiny edges; a second sweep takes what the first could not.
        for _ in 0..if round == 0 { 3 } else { 1 } {
            editor.collapse_short_edges();
        }
        editor.flip_edges();
        editor.smooth(&project);
        (positions, triangles) = editor.finish();
        lengths = positions.par_iter().map(&length).collect();
    }
    let mut editor = Editor::new(positions, lengths, triangles);
    for _ in 0..3 {
        editor.flip_edges();
        editor.smooth(&project);
    }
    editor.flip_edges();
    editor.finish()
}

/// Cuts edges longer than 4/3 of the wanted length in the middle.
fn split(positions: &mut Vec<Point3<f64>>, lengths: &mut Vec<f64>, triangles: &mut Vec<[u32; 3]>) {
    let mut middles = HashMap::new();
    let mut result = Vec::with_capacity(triangles.len());
    for &[a, b, c] in triangles.iter() {
        let mut middle = |a: u32, b: u32| {
            let key = (a.min(b), a.max(b));
            let (u, v) = (key.0 as usize, key.1 as usize);
            let wanted = (lengths[u] + lengths[v]) / 2.0;
            if (positions[u] - positions[v]).norm() <= 4.0 / 3.0 * wanted {
                return None;
            }
            Some(*middles.entry(key).or_insert_with(|| {
                positions.push(nalgebra::center(&positions[u], &positions[v]));
                lengths.push(wanted);
                positions.len() as u32 - 1
            }))
        };
        let middle = [middle(a, b), middle(b, c), middle(c, a)];
        match middle {
            [None, None, None] => result.push([a, b, c]),
            [Some(d), Some(e), Some(f)] => result.extend([[a, d, f], [b, e, d], [c, f, e], [d, e, f]]),
            _ => {
                // Turned so that the first edge is cut and the last is not.
                let turn = (0..3).find(|&t| middle[t].is_some() && middle[(t + 2) % 3].is_none()).unwrap_or(0);
                let corner = |k: usize| [a, b, c][(turn + k) % 3];
                let (p, q, r) = (corner(0), corner(1), corner(2));
                match (middle[turn], middle[(turn + 1) % 3]) {
                    (Some(d), Some(e)) => result.extend([[d, q, e], [p, d, e], [p, e, r]]),
                    (Some(d), None) => result.extend([[p, d, r], [d, q, r]]),
                    _ => result.push([a, b, c]),
                }
            }
        }
    }
    *triangles = result;
}

impl Editor {
    fn new(positions: Vec<Point3<f64>>, lengths: Vec<f64>, triangles: Vec<[u32; 3]>) -> Self {
        let mut around = vec![vec![]; positions.len()];
        for (t, corners) in triangles.iter().enumerate() {
            corners.iter().for_each(|&v| around[v as usize].push(t as u32));
        }
        Self { positions, lengths, triangles, around }
    }

    /// The mesh without what was removed.
    fn finish(self) -> (Vec<Point3<f64>>, Vec<[u32; 3]>) {
        let mut number = vec![u32::MAX; self.positions.len()];
        let mut positions = vec![];
        for (v, around) in self.around.iter().enumerate() {
            if !around.is_empty() {
                number[v] = positions.len() as u32;
                positions.push(self.positions[v]);
            }
        }
        let alive = self.triangles.iter().filter(|t| t[0] != t[1]);
        (positions, alive.map(|t| t.map(|v| number[v as usize])).collect())
    }

    /// The neighbours of `vertex`, in ascending order.
    fn neighbours(&self, vertex: u32) -> Vec<u32> {
        let corners = self.around[vertex as usize].iter().flat_map(|&t| self.triangles[t as usize]);
        let mut result: Vec<u32> = corners.filter(|&v| v != vertex).collect();
        result.sort_unstable();
        result.dedup();
        result
    }

    fn length(&self, a: u32, b: u32) -> f64 {
        (self.positions[a as usize] - self.positions[b as usize]).norm()
    }

    fn wanted(&self, a: u32, b: u32) -> f64 {
        (self.lengths[a as usize] + self.lengths[b as usize]) / 2.0
    }

    /// Twice the area times the normal.
    fn normal(&self, triangle: [u32; 3]) -> Vector3<f64> {
        let [a, b, c] = triangle.map(|v| self.positions[v as usize]);
        (b - a).cross(&(c - a))
    }

    /// Merges the ends of edges shorter than 4/5 of the wanted length where topology and shape allow it.
    fn collapse_short_edges(&mut self) {
        for vertex in 0..self.positions.len() as u32 {
            if self.around[vertex as usize].is_empty() {
                continue;
            }
            let mut short: Vec<(f64, u32)> = self
                .neighbours(vertex)
                .into_iter()
                .map(|n| (self.length(vertex, n), n))
                .filter(|&(length, n)| length < 0.8 * self.wanted(vertex, n))
                .collect();
            short.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            for (_, onto) in short {
                if self.collapse(vertex, onto) {
                    break;
                }
            }
        }
    }

    /// Merges `vertex` into `onto`, if that leaves a manifold without long edges and folded triangles.
    fn collapse(&mut self, vertex: u32, onto: u32) -> bool {
        let (ring, other) = (self.neighbours(vertex), self.neighbours(onto));
        let shared: Vec<u32> = ring.iter().copied().filter(|n| other.binary_search(n).is_ok()).collect();
        // Two shared neighbours: no tunnel closes. They keep at least three triangles each.
        if shared.len() != 2 || shared.iter().any(|&n| self.around[n as usize].len() <= 3) {
            return false;
        }
        if ring.iter().any(|&n| n != onto && self.length(n, onto) > 4.0 / 3.0 * self.wanted(n, onto)) {
            return false;
        }
        let moved = |t: [u32; 3]| t.map(|v| if v == vertex { onto } else { v });
        let triangles = self.around[vertex as usize].clone();
        for &t in &triangles {
            let corners = self.triangles[t as usize];
            if !corners.contains(&onto) {
                let (before, after) = (self.normal(corners), self.normal(moved(corners)));
                if before.norm() > 0.0 && before.dot(&after) < 0.3 * before.norm() * after.norm() {
                    return false;
                }
            }
        }
        for t in triangles {
            let corners = self.triangles[t as usize];
            if corners.contains(&onto) {
                corners.iter().for_each(|&v| self.around[v as usize].retain(|&other| other != t));
                self.triangles[t as usize] = [0; 3];
            } else {
                self.triangles[t as usize] = moved(corners);
                self.around[onto as usize].push(t);
            }
        }
        self.around[vertex as usize].clear();
        true
    }

    /// Flips edges whose opposite angles sum to more than π, until few are left.
    fn flip_edges(&mut self) {
        for _ in 0..4 {
            let mut flips = 0;
            for a in 0..self.positions.len() as u32 {
                for b in self.neighbours(a) {
                    flips += usize::from(a < b && self.flip(a, b));
                }
            }
            if flips == 0 {
                break;
            }
        }
    }

    /// Flips the edge a–b if its opposite angles sum to more than π and the new triangles face the same way.
    fn flip(&mut self, a: u32, b: u32) -> bool {
        let sides: Vec<u32> =
            self.around[a as usize].iter().copied().filter(|&t| self.triangles[t as usize].contains(&b)).collect();
        let [mut left, mut right] = sides[..] else { return false };
        // The left triangle runs through the edge from a to b.
        if !runs(self.triangles[left as usize], a, b) {
            (left, right) = (right, left);
        }
        let opposite = |t: u32| self.triangles[t as usize].into_iter().find(|&v| v != a && v != b);
        let (Some(c), Some(d)) = (opposite(left), opposite(right)) else { return false };
        if c == d || !runs(self.triangles[left as usize], a, b) || !runs(self.triangles[right as usize], b, a) {
            return false;
        }
        let angle = |at: u32| {
            let [p, q, r] = [at, a, b].map(|v| self.positions[v as usize]);
            (q - p).angle(&(r - p))
        };
        if angle(c) + angle(d) <= std::f64::consts::PI + 1e-6 {
            return false;
        }
        let few = |v: u32| self.around[v as usize].len() <= 3;
        if few(a) || few(b) || self.neighbours(c).binary_search(&d).is_ok() {
            return false;
        }
        let new = [[a, d, c], [d, b, c]];
        let before = self.normal(self.triangles[left as usize]) + self.normal(self.triangles[right as usize]);
        if new.iter().any(|&t| self.normal(t).dot(&before) < 0.5 * self.normal(t).norm() * before.norm()) {
            return false;
        }
        self.triangles[left as usize] = new[0];
        self.triangles[right as usize] = new[1];
        self.around[a as usize].retain(|&t| t != right);
        self.around[b as usize].retain(|&t| t != left);
        self.around[c as usize].push(right);
        self.around[d as usize].push(left);
        true
    }

    /// Moves every vertex to the middle of its triangles, weighted by area over wanted area, along the surface.
    fn smooth(&mut self, project: &(impl Fn(Point3<f64>) -> Point3<f64> + Sync)) {
        let moved = |v: usize| {
            let at = self.positions[v];
            let (mut normal, mut sum, mut total) = (Vector3::zeros(), Vector3::zeros(), 0.0);
            for &t in &self.around[v] {
                let corners = self.triangles[t as usize];
                let area = self.normal(corners);
                let size: f64 = corners.iter().map(|&v| self.lengths[v as usize]).sum();
                let weight = area.norm() / (size * size);
                let middle = corners.iter().map(|&v| self.positions[v as usize] - at).sum::<Vector3<f64>>() / 3.0;
                normal += area;
                sum += middle * weight;
                total += weight;
            }
            if total <= 0.0 || normal.norm() <= 0.0 {
                return at;
            }
            let (step, normal) = (sum / total, normal.normalize());
            project(at + step - normal * step.dot(&normal))
        };
        self.positions = (0..self.positions.len()).into_par_iter().map(moved).collect();
    }
}

/// Whether `triangle` runs through the edge from `a` to `b`.
fn runs(triangle: [u32; 3], a: u32, b: u32) -> bool {
    (0..3).any(|k| triangle[k] == a && triangle[(k + 1) % 3] == b)
}

#[cfg(test)]
mod tests {
    use mimesh_core::mesh::{Mesh, Statistics};

    use super::{super::polygonise::polygonise, *};

    #[test]
    fn a_sphere_gets_edges_of_the_wanted_length_and_no_thin_triangle() {
        let (low, high) = (Point3::new(-1.31, -1.27, -1.23), Point3::new(1.3, 1.3, 1.3));
        let (positions, triangles) = polygonise(|p| p.coords.norm() - 1.0, low, high, 0.1);
        let (positions, triangles) = remesh(positions, triangles, |_| 0.15, |p| Point3::from(p.coords.normalize()), 6);
        let statistics = Statistics::new(&Mesh::from_triangles(positions.clone(), &triangles)).unwrap();
        assert_eq!((statistics.boundary_edges, statistics.non_manifold_edges), (0, 0));
        assert_eq!(positions.len() as i64 - (triangles.len() / 2) as i64, 2, "a sphere's Euler characteristic");
        // Edges lie between 4/5 and 4/3 of the length wanted when they are split and collapsed; smoothing moves them
        // on.
        for t in &triangles {
            let [a, b, c] = t.map(|v| positions[v as usize]);
            for (edge, next) in [(b - a, c - b), (c - b, a - c), (a - c, b - a)] {
                assert!(edge.norm() > 0.06 && edge.norm() < 0.25, "{}", edge.norm());
                assert!((-edge).angle(&next) > 25f64.to_radians());
            }
        }
    }
}
