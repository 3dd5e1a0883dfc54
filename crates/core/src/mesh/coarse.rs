//! Surfaces over some of the vertices of a finer one, which stand for all of them.

use nalgebra::Point3;

use super::{
    Surface, bounding_box,
    collapsing::{Collapsing, Ends},
};
use crate::Result;

/// A surface over some of the vertices of a finer one.
#[derive(Clone, Debug)]
pub struct Coarse {
    /// The surface.
    pub surface: Surface,
    /// The vertex of the finer surface that each of its vertices is, #V of this one, all different.
    pub vertices: Vec<u32>,
    /// For how many vertices of the finer surface each stands, #V of this one; the sum is #V of that.
    pub counts: Vec<f64>,
}

impl Coarse {
    /// The values at the vertices of this surface, of `values` at those of the finer one.
    pub fn restrict<T: Clone>(&self, values: &[T]) -> Vec<T> {
        self.vertices.iter().map(|&v| values[v as usize].clone()).collect()
    }

    /// The vertex of this surface that is `vertex` of the finer one.
    pub fn find(&self, vertex: u32) -> Option<u32> {
        self.vertices.iter().position(|&v| v == vertex).map(|v| v as u32)
    }
}

/// A surface over about `vertices` vertices of `surface`, among them `kept`.
///
/// Edges collapse as in [`simplify`](super::simplify), but to one of their ends, so that poses of `surface` are poses of it. Vertices that
/// no triangle is left for are missing; so may be some of `kept` on a surface with defects.
///
/// # Errors
///
/// Those of [`Surface::from_triangles`].
pub fn coarsen(surface: &Surface, vertices: usize, kept: &[u32]) -> Result<Coarse> {
    let (low, high) = bounding_box(&surface.positions);
    let (centre, diagonal) = (nalgebra::center(&low, &high), (high - low).norm());
    let n = surface.vertex_count();
    let unit = if diagonal > 0.0 { diagonal } else { 1.0 };
    let positions = surface.positions.iter().map(|p| Point3::from((p - centre) / unit)).collect();
    let mut mesh = Collapsing::new(positions, surface.triangles.clone(), kept, Ends::Stay);
    let mut fine: Vec<u32> = (0..n as u32).collect();
    let mut counts = vec![1.0; n];
    mesh.run(n, vertices, |candidate| {
        let [a, b] = candidate.edge.map(|v| v as usize);
        counts[a] += counts[b];
        if candidate.is_second {
            fine[a] = fine[b];
        }
    });
    let mut triangles: Vec<[u32; 3]> = mesh.triangles.into_iter().flatten().collect();
    let mut number = vec![None; n];
    triangles.iter().flatten().for_each(|&v| number[v as usize] = Some(0));
    let used: Vec<usize> = (0..n).filter(|&v| number[v].is_some()).collect();
    used.iter().zip(0..).for_each(|(&v, k)| number[v] = Some(k));
    triangles.iter_mut().flatten().for_each(|v| *v = number[*v as usize].unwrap_or(0));
    let vertices: Vec<u32> = used.iter().map(|&v| fine[v]).collect();
    let positions = vertices.iter().map(|&v| surface.positions[v as usize]).collect();
    let counts = used.iter().map(|&v| counts[v]).collect();
    Ok(Coarse { surface: Surface::from_triangles(positions, triangles)?, vertices, counts })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testkit::meshes;

    #[test]
    fn vertices_are_those_of_the_finer_surface_and_stand_for_all_of_them() {
        let sphere = meshes::icosphere(4);
        let kept = [0, 17, 400, 401, 2000];
        for count in [1000, 200, 40] {
            let coarse = coarsen(&sphere, count, &kept).unwrap();
            assert_eq!(coarse.surface.vertex_count(), count);
            assert_eq!(coarse.surface.triangle_count(), 2 * count - 4, "closed, without handles");
            assert_eq!(coarse.surface.positions, coarse.restrict(&sphere.positions));
            assert_eq!(coarse.counts.iter().sum::<f64>(), sphere.vertex_count() as f64);
            let mut different = coarse.vertices.clone();
            different.sort_unstable();
            different.dedup();
            assert_eq!(different.len(), count);
            for v in kept {
                assert_eq!(coarse.find(v).map(|k| coarse.vertices[k as usize]), Some(v));
            }
            // Each stands for about as many, within the unevenness of collapses.
            let most = coarse.counts.iter().fold(0.0_f64, |most, &c| most.max(c));
            assert!(most * count as f64 <= 6.0 * sphere.vertex_count() as f64, "{count}: {most}");
        }
    }

    #[test]
    fn borders_components_and_small_surfaces_stay() {
        let grid = meshes::grid(20, 20);
        let coarse = coarsen(&grid, 40, &[210]).unwrap();
        assert!(coarse.find(210).is_some());
        let area = |s: &Surface| s.area_normals(&s.positions).iter().map(|n| n.norm()).sum::<f64>();
        assert!((area(&coarse.surface) / area(&grid) - 1.0).abs() < 1e-9, "the square keeps its four sides");
        let two = meshes::two_components();
        assert_eq!(coarsen(&two, 20, &[3, 60]).unwrap().surface.components().count(), 2);
        let same = coarsen(&two, two.vertex_count(), &[]).unwrap();
        assert_eq!((same.surface.triangles, same.counts), (two.triangles, vec![1.0; two.positions.len()]));
    }
}
