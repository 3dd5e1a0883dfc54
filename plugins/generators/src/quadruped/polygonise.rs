//! The zero set of a function as a closed triangle mesh: marching tetrahedra.
//!
//! Each cube of a lattice is cut into six tetrahedra about its diagonal [Kuhn]; unlike cubes they leave no case
//! open, so the mesh is closed and manifold whatever the function. Its triangles are poor: they are meant to be
//! remeshed.

use std::collections::HashMap;

use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

/// Cubes along an edge of a block; blocks that the surface cannot reach are skipped.
const BLOCK: usize = 6;

/// Paths from corner 0 to corner 7 of a cube along its edges, as tetrahedra of positive volume; bit k is the step in k.
const TETRAHEDRA: [[usize; 4]; 6] =
    [[0, 1, 3, 7], [0, 2, 6, 7], [0, 4, 5, 7], [0, 5, 1, 7], [0, 3, 2, 7], [0, 6, 4, 7]];

/// Vertices and triangles of `distance` = 0 in the box from `low` to `high`, on cubes of edge `cell`.
///
/// `distance` is negative inside and must not grow faster than 1.5 a unit of length.
pub fn polygonise(
    distance: impl Fn(&Point3<f64>) -> f64 + Sync,
    low: Point3<f64>,
    high: Point3<f64>,
    cell: f64,
) -> (Vec<Point3<f64>>, Vec<[u32; 3]>) {
    let blocks: [usize; 3] = std::array::from_fn(|k| ((high[k] - low[k]) / (cell * BLOCK as f64)).ceil() as usize);
    let corner = |i: [usize; 3]| low + Vector3::new(i[0] as f64, i[1] as f64, i[2] as f64) * cell;
    let lattice = |i: [usize; 3]| {
        let [nx, ny] = [blocks[0] * BLOCK + 1, blocks[1] * BLOCK + 1];
        ((i[2] * ny + i[1]) * nx + i[0]) as u64
    };
    // Per block: triangles of lattice edges, an edge given by its ends with the value there.
    let triangles_of = |block: usize| -> Vec<[Edge; 3]> {
        let first =
            [block % blocks[0], block / blocks[0] % blocks[1], block / blocks[0] / blocks[1]].map(|b| b * BLOCK);
        let size = cell * BLOCK as f64;
        let centre = corner(first) + Vector3::repeat(size / 2.0);
        if distance(&centre).abs() > 1.5 * size * 0.5 * 3f64.sqrt() {
            return vec![];
        }
        let side = BLOCK + 1;
        let values: Vec<f64> = (0..side * side * side)
            .map(|n| distance(&corner([first[0] + n % side, first[1] + n / side % side, first[2] + n / side / side])))
            .collect();
        let mut result = vec![];
        for n in 0..BLOCK * BLOCK * BLOCK {
            let cube = [n % BLOCK, n / BLOCK % BLOCK, n / BLOCK / BLOCK];
            let corners: [Corner; 8] = std::array::from_fn(|c| {
                let local: [usize; 3] = std::array::from_fn(|k| cube[k] + (c >> k & 1));
                let global: [usize; 3] = std::array::from_fn(|k| first[k] + local[k]);
                let value = values[(local[2] * side + local[1]) * side + local[0]];
                Corner { number: lattice(global), at: corner(global), value }
            });
            if corners.iter().any(|c| c.inside()) && corners.iter().any(|c| !c.inside()) {
                TETRAHEDRA.iter().for_each(|t| cut(t.map(|c| corners[c]), &mut result));
            }
        }
        result
    };
    let count = blocks.iter().product::<usize>();
    let per_block: Vec<_> = (0..count).into_par_iter().map(triangles_of).collect();

    let mut numbers = HashMap::new();
    let mut positions = vec![];
    let triangles = per_block.iter().flatten().map(|triangle| {
        triangle.map(|[a, b]| {
            *numbers.entry((a.number.min(b.number), a.number.max(b.number))).or_insert_with(|| {
                // Never at an end, so that no two vertices coincide.
                let t = (a.value / (a.value - b.value)).clamp(0.02, 0.98);
                positions.push(a.at + (b.at - a.at) * t);
                positions.len() as u32 - 1
            })
        })
    });
    let triangles = triangles.collect();
    (positions, triangles)
}

/// A lattice point.
#[derive(Clone, Copy)]
struct Corner {
    number: u64,
    at: Point3<f64>,
    value: f64,
}

/// An edge that the surface crosses: its end inside, its end outside.
type Edge = [Corner; 2];

impl Corner {
    fn inside(&self) -> bool {
        self.value < 0.0
    }
}

/// The triangles of the surface in a tetrahedron of positive volume, counter-clockwise seen from outside.
fn cut(t: [Corner; 4], out: &mut Vec<[Edge; 3]>) {
    // Even permutations that bring each corner, or each pair, to the front.
    const ONE: [[usize; 4]; 4] = [[0, 1, 2, 3], [1, 0, 3, 2], [2, 3, 0, 1], [3, 2, 1, 0]];
    const TWO: [[usize; 4]; 6] = [[0, 1, 2, 3], [0, 2, 3, 1], [0, 3, 1, 2], [1, 2, 0, 3], [1, 3, 2, 0], [2, 3, 0, 1]];
    let inside = t.map(|c| c.inside());
    match inside.iter().filter(|&&i| i).count() {
        1 => {
            let Some([i, j, k, l]) = ONE.iter().find(|p| inside[p[0]]).map(|p| p.map(|c| t[c])) else { return };
            out.push([[i, j], [i, k], [i, l]]);
        }
        3 => {
            let Some([i, j, k, l]) = ONE.iter().find(|p| !inside[p[0]]).map(|p| p.map(|c| t[c])) else { return };
            out.push([[j, i], [l, i], [k, i]]);
        }
        2 => {
            let front = TWO.iter().find(|p| inside[p[0]] && inside[p[1]]);
            let Some([i, j, k, l]) = front.map(|p| p.map(|c| t[c])) else { return };
            out.extend([[[i, k], [i, l], [j, l]], [[i, k], [j, l], [j, k]]]);
        }
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use mimesh_core::mesh::{Mesh, Statistics};

    use super::*;

    #[test]
    fn a_sphere_is_closed_and_faces_outwards() {
        let (low, high) = (Point3::new(-1.31, -1.27, -1.23), Point3::new(1.3, 1.3, 1.3));
        let (positions, triangles) = polygonise(|p| p.coords.norm() - 1.0, low, high, 0.1);
        let statistics = Statistics::new(&Mesh::from_triangles(positions, &triangles)).unwrap();
        assert_eq!((statistics.boundary_edges, statistics.non_manifold_edges), (0, 0));
        assert_eq!(statistics.component_sizes.len(), 1);
        // A chord of length h cuts about h²/8 off a radius, three times that off the volume.
        assert!((statistics.volume.unwrap() / (4.0 / 3.0 * std::f64::consts::PI) - 1.0).abs() < 0.01);
    }
}
