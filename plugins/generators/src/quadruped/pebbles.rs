//! The animal as pebbles: cells of a Voronoi diagram in a layer below the skin, shrunk and rounded.
//!
//! The layer is as deep as a pebble is long, so that a leg is filled by one pebble after another and the trunk is a shell. A
//! pebble is the part of its cell that lies in the layer; it is made a mesh by rays from its site, which see all of it
//! but for what little a bend of the skin hides.

use std::collections::BTreeMap;

use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

use super::{
    body::{Body, smooth_max},
    pieces::{Motion, Pieces, named, region},
    sites::{Cloud, Site},
};

/// About `count` pebbles (exactly, if the skin is fine enough) under the skin `positions`, `triangles` of `body`.
///
/// Their edges are about `edge` long.
pub fn pebbles(
    body: &Body,
    positions: &[Point3<f64>],
    triangles: &[[u32; 3]],
    (count, edge, seed): (usize, f64, u64),
) -> Pieces {
    let layer = Layer::new(body, positions, triangles, count);
    let sites: Vec<Point3<f64>> =
        layer.cloud.sites(count, seed).iter().map(|site| Point3::new(site[0], site[1], site[2])).collect();
    let pebble = |index: usize| {
        let pebble = Pebble::new(body, &layer, &sites, index);
        let around = (std::f64::consts::PI * pebble.size / (4.0 * edge)).round().clamp(2.0, 12.0);
        let (directions, triangles) = sphere(around as u32);
        (pebble.mesh(&directions), triangles)
    };
    let pebbles: Vec<_> = (0..sites.len()).into_par_iter().map(pebble).collect();
    let places: Vec<_> = sites.iter().map(|site| region(body, site)).collect();
    let mut result = Pieces::default();
    for (index, name) in named(&places) {
        let (positions, triangles) = &pebbles[index];
        result.push(name, positions.clone(), triangles.iter().map(|t| &t[..]), Motion::Rigid);
    }
    result
}

/// The layer below the skin that the pebbles fill.
struct Layer {
    cloud: Cloud,
    depths: Vec<f64>,
}

impl Layer {
    fn new(body: &Body, positions: &[Point3<f64>], triangles: &[[u32; 3]], count: usize) -> Self {
        let mut normals = vec![Vector3::zeros(); positions.len()];
        for t in triangles {
            let [a, b, c] = t.map(|v| positions[v as usize]);
            let normal = (b - a).cross(&(c - a)) / 6.0;
            t.iter().for_each(|&v| normals[v as usize] += normal);
        }
        let thickness: Vec<f64> = positions.par_iter().map(|p| body.thickness(p)).collect();
        // Pebbles of thin limbs are smaller, though by less than the limbs are.
        let relative: Vec<f64> = thickness.iter().map(|t| t.powf(0.4)).collect();
        // A pebble covers its square, or where it fills the limb, a ring of it.
        let pebbles = |factor: f64| {
            let share = |((normal, t), relative): ((&Vector3<f64>, &f64), &f64)| {
                let size = factor * relative;
                normal.norm() / (size * if *t < 0.65 * size { std::f64::consts::TAU * t } else { size })
            };
            normals.iter().zip(&thickness).zip(&relative).map(share).sum::<f64>()
        };
        let (mut low, mut high) = (1e-3, 1e3);
        for _ in 0..60 {
            let middle = f64::sqrt(low * high);
            *(if pebbles(middle) > count as f64 { &mut low } else { &mut high }) = middle;
        }
        let (mut cloud, mut depths) = (Cloud::default(), vec![]);
        for (((p, normal), t), relative) in positions.iter().zip(&normals).zip(&thickness).zip(&relative) {
            let size = low * relative;
            let depth = t.min(0.8 * size);
            for share in [1.0 / 6.0, 0.5, 5.0 / 6.0] {
                let at = p - normal.normalize() * (share * depth);
                cloud.places.push(Site::new(at.x, at.y, at.z, 0.0, 0.0, 0.0));
                cloud.weights.push(normal.norm() * depth);
                cloud.sizes.push(size);
                depths.push(depth);
            }
        }
        Self { cloud, depths }
    }
}

/// A pebble as the set of points where a function is negative.
struct Pebble<'a> {
    body: &'a Body,
    centre: Point3<f64>,
    /// About its diameter.
    size: f64,
    /// Depth of the layer there.
    depth: f64,
    /// Length over which its sides run into each other.
    round: f64,
    /// Sides towards its neighbours: outward normal and offset.
    sides: Vec<(Vector3<f64>, f64)>,
}

impl<'a> Pebble<'a> {
    fn new(body: &'a Body, layer: &Layer, sites: &[Point3<f64>], index: usize) -> Self {
        let cloud = &layer.cloud;
        let site = Site::new(sites[index].x, sites[index].y, sites[index].z, 0.0, 0.0, 0.0);
        let nearest = super::sites::nearest(&cloud.places, &site);
        let (size, depth) = (cloud.sizes[nearest], layer.depths[nearest]);
        let mut others: Vec<usize> = (0..sites.len()).filter(|&other| other != index).collect();
        let distance = |other: &usize| (sites[*other] - sites[index]).norm_squared();
        others.sort_by(|a, b| distance(a).total_cmp(&distance(b)));
        // More neighbours a cell among points in space hardly has.
        others.truncate(40);
        let gap = 0.02 * size;
        let side = |other: usize| {
            let normal = (sites[other] - sites[index]).normalize();
            (normal, normal.dot(&nalgebra::center(&sites[other], &sites[index]).coords) - gap)
        };
        let sides: Vec<_> = others.into_iter().map(side).collect();
        let mut pebble = Self { body, centre: sites[index], size, depth, round: 0.0, sides };
        let at = |place: &Site| Point3::new(place[0], place[1], place[2]);
        if pebble.value(&pebble.centre) > -0.1 * size.min(depth) {
            // A share that bends around an edge of the body has its middle outside; a point of the cloud is inside.
            pebble.centre = at(&cloud.places[nearest]);
        }
        if pebble.value(&pebble.centre) > -0.02 * size.min(depth) {
            // That point is nearly one of the next pebble.
            let near = cloud.places.iter().filter(|place| (*place - site).norm() < size).map(at);
            let deeper = near.map(|point| (pebble.value(&point), point)).min_by(|a, b| a.0.total_cmp(&b.0));
            pebble.centre = deeper.map_or(pebble.centre, |(_, point)| point);
        }
        // No rounder than the centre is deep inside, lest nothing be left.
        pebble.round = (0.3 * size).min(-1.2 * pebble.value(&pebble.centre)).max(0.0);
        pebble
    }

    /// Negative inside.
    fn value(&self, point: &Point3<f64>) -> f64 {
        let skin = self.body.distance(point);
        let layer = smooth_max(skin, -skin - self.depth, self.round);
        let side = |value, (normal, offset): &(Vector3<f64>, f64)| {
            smooth_max(value, normal.dot(&point.coords) - offset, self.round)
        };
        self.sides.iter().fold(layer, side)
    }

    /// The points at which rays from the centre leave the pebble.
    fn mesh(&self, directions: &[Vector3<f64>]) -> Vec<Point3<f64>> {
        let leaves = |direction: &Vector3<f64>| {
            let mut reached = 0.0;
            for _ in 0..60 {
                let value = self.value(&(self.centre + direction * reached));
                // The function grows no faster than 1.2 a unit of length, so no side is stepped over.
                reached -= value / 1.2;
                if value.abs() < 1e-4 * self.size {
                    break;
                }
            }
            self.centre + direction * reached
        };
        directions.iter().map(leaves).collect()
    }
}

/// Directions and triangles of an icosahedron with `n` triangles along each edge.
fn sphere(n: u32) -> (Vec<Vector3<f64>>, Vec<[u32; 3]>) {
    let golden = (1.0 + 5f64.sqrt()) / 2.0;
    // Pairs of opposite corners lie in the planes of coordinates.
    let corner = |i: u32| {
        let (a, b) = (if i & 1 == 0 { 1.0 } else { -1.0 }, if i & 2 == 0 { golden } else { -golden });
        match i / 4 {
            0 => Vector3::new(0.0, a, b),
            1 => Vector3::new(a, b, 0.0),
            _ => Vector3::new(b, 0.0, a),
        }
    };
    // Faces are the triples of corners at distance 2 from each other.
    let near = |i: u32, j: u32| (corner(i) - corner(j)).norm() < 2.1;
    let mut faces = vec![];
    for (i, j, k) in (0..12).flat_map(|i| (0..i).flat_map(move |j| (0..j).map(move |k| (i, j, k)))) {
        if near(i, j) && near(j, k) && near(k, i) {
            let outward = corner(i).cross(&corner(j)).dot(&corner(k)) > 0.0;
            faces.push(if outward { [i, j, k] } else { [i, k, j] });
        }
    }
    let (mut numbers, mut directions, mut triangles) = (BTreeMap::new(), vec![], vec![]);
    for face in faces {
        // A point of the face by its steps from the first corner towards the others; shared ones have equal shares.
        let mut number = |b: u32, c: u32| {
            let mut shares: Vec<(u32, u32)> =
                face.into_iter().zip([n - b - c, b, c]).filter(|share| share.1 > 0).collect();
            shares.sort_unstable();
            let direction = shares.iter().map(|&(v, share)| corner(v) * f64::from(share)).sum::<Vector3<f64>>();
            *numbers.entry(shares).or_insert_with(|| {
                directions.push(direction.normalize());
                directions.len() as u32 - 1
            })
        };
        for b in 0..n {
            for c in 0..n - b {
                triangles.push([number(b, c), number(b + 1, c), number(b, c + 1)]);
                if b + c + 2 <= n {
                    triangles.push([number(b + 1, c), number(b + 1, c + 1), number(b, c + 1)]);
                }
            }
        }
    }
    (directions, triangles)
}

#[cfg(test)]
mod tests {
    use mimesh_core::mesh::{Mesh, Statistics};

    use super::*;

    #[test]
    fn a_sphere_is_closed_and_has_the_vertices_of_a_divided_icosahedron() {
        for n in 1..6 {
            let (directions, triangles) = sphere(n);
            assert_eq!((directions.len(), triangles.len()), (10 * (n * n) as usize + 2, 20 * (n * n) as usize));
            let mesh = Mesh::from_triangles(directions.into_iter().map(Point3::from).collect(), &triangles);
            let statistics = Statistics::new(&mesh).unwrap();
            assert_eq!((statistics.boundary_edges, statistics.non_manifold_edges), (0, 0));
            assert!(statistics.volume.unwrap() > 2.5, "an icosahedron in the unit sphere encloses 2.536");
        }
    }
}
