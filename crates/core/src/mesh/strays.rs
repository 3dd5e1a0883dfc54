use nalgebra::{Point3, Vector3};

use crate::{
    operators::{DeformationGradients, is_degenerate},
    spatial::Nearest,
};

/// A vertex of a mesh that no face uses: construction points and remains of an export, which may lie anywhere.
///
/// It goes with a triangle at the vertex of the surface nearest to it, by that triangle's deformation gradient.
#[derive(Clone, Debug, PartialEq)]
pub struct Stray {
    /// The vertex, as the mesh counts.
    pub vertex: u32,
    /// The triangle that it goes with.
    pub triangle: u32,
    /// The corner of the triangle that it is nearest to, 0 to 2.
    corner: usize,
    /// The triangle at rest.
    rest: [Point3<f64>; 3],
    /// From the corner to the stray at rest.
    offset: Vector3<f64>,
}

impl Stray {
    /// All strays of a mesh with positions `of_mesh`; `positions` and `triangles` are those of its surface.
    pub(super) fn all(
        of_mesh: &[Point3<f64>],
        vertex_of: &[Option<u32>],
        positions: &[Point3<f64>],
        triangles: &[[u32; 3]],
    ) -> Vec<Self> {
        let vertices: Vec<u32> = (0..).zip(vertex_of).filter(|(_, of)| of.is_none()).map(|(v, _)| v).collect();
        if vertices.is_empty() {
            return vec![];
        }
        let Ok(nearest) = Nearest::new(positions) else { return vec![] };
        // A triangle without area has no deformation gradient, and serves only where there is no other.
        let has_area = |t: &u32| !is_degenerate(&triangles[*t as usize].map(|v| positions[v as usize]));
        let (with, without): (Vec<u32>, Vec<u32>) = (0..triangles.len() as u32).partition(has_area);
        let mut first_around = vec![(0, 0); positions.len()];
        for t in without.into_iter().rev().chain(with.into_iter().rev()) {
            (0..3).for_each(|k| first_around[triangles[t as usize][k] as usize] = (t, k));
        }
        let stray = |vertex: u32| {
            let at = of_mesh[vertex as usize];
            let (triangle, corner) = first_around[nearest.find(&at).0 as usize];
            let rest = triangles[triangle as usize].map(|v| positions[v as usize]);
            Self { vertex, triangle, corner, rest, offset: at - rest[corner] }
        };
        vertices.into_iter().map(stray).collect()
    }

    /// The place of the stray when the corners of its triangle are at `posed`.
    pub fn position(&self, posed: [Point3<f64>; 3]) -> Point3<f64> {
        let gradient = DeformationGradients::new(&self.rest, &[[0, 1, 2]]).of_triangle(0, &posed);
        posed[self.corner] + gradient * self.offset
    }
}
