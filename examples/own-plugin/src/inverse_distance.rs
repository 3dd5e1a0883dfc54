//! Inverse distance weights of compact support.
//!
//! Shepard's weights as Franke and Nielson (1980) made them local: wₖ ∝ ((R − dₖ)₊ / (R dₖ))ᵖ, divided by their sum. dₖ is the
//! distance from handle k along the surface, and R, for each vertex, that to the (`neighbours` + 1)-th nearest handle: a handle
//! moves only vertices that have it among their `neighbours` nearest, and its influence fades to 0 where the next one comes
//! nearer. Weights lie within 0 to 1 and are continuous; where no more than `neighbours` handles reach a vertex, R is infinite
//! and wₖ ∝ dₖ⁻ᵖ.
//!
//! Bridged components are as far apart as the ends of their bridges.

use mimesh_core::{
    Figures, Result,
    mesh::{Surface, SurfacePoint},
    plugin::check_ranges,
    register,
    spatial::EdgePaths,
    stage::{BoundWeights, HandlePoints, HandleWeights, ProximityGraph, Weights, unreached},
};
use nalgebra::DMatrix;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

register!(Weights: InverseDistance);

/// Inverse distance weights of compact support: each vertex follows its few nearest handles.
///
/// Sparse and cheap, and no handle has a say far away; not as smooth as `bounded_biharmonic`.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct InverseDistance {
    /// How many handles a vertex follows at most, unless more are equally near.
    #[schemars(range(min = 2))]
    pub neighbours: usize,
    /// p: how fast weights fall off; the greater, the sharper is the border between two handles.
    #[schemars(range(min = 1.0, max = 16.0))]
    pub power: f64,
}

impl Default for InverseDistance {
    fn default() -> Self {
        Self { neighbours: 4, power: 2.0 }
    }
}

#[typetag::serde(name = "inverse_distance")]
impl Weights for InverseDistance {
    fn bind(
        &self,
        surface: &Surface,
        points: &[SurfacePoint],
        proximity: Option<&ProximityGraph>,
    ) -> Result<Box<dyn BoundWeights>> {
        check_ranges(self)?;
        proximity.map_or(Ok(()), |graph| graph.check(surface))?;
        let points = HandlePoints::new(surface, points)?;
        let bridges: Vec<[u32; 2]> = proximity.iter().flat_map(|graph| graph.pairs()).collect();
        let paths = EdgePaths::new(&surface.positions, &surface.triangles, &bridges);
        let distances = points.all().par_iter().map(|&v| paths.distances(&[v])).collect();
        Ok(Box::new(Bound { settings: self.clone(), surface: surface.clone(), points, distances }))
    }
}

/// Weights bound to a surface.
#[derive(Debug)]
struct Bound {
    settings: InverseDistance,
    surface: Surface,
    points: HandlePoints,
    /// From each point to each vertex; infinite where no path leads.
    distances: Vec<Vec<f64>>,
}

impl BoundWeights for Bound {
    fn solve(&self, handles: &[usize]) -> Result<HandleWeights> {
        let vertices = self.points.choose(handles)?;
        let distances: Vec<&[f64]> = handles.iter().map(|&h| &self.distances[h][..]).collect();
        let count = self.surface.vertex_count();
        let reached: Vec<bool> = (0..count).map(|v| distances.iter().any(|d| d[v].is_finite())).collect();
        let unreached = unreached(&self.surface, &reached)?;
        let mut matrix = DMatrix::zeros(count, handles.len());
        for v in (0..count).filter(|&v| reached[v]) {
            let shares = shares(&distances, v, &self.settings);
            shares.into_iter().for_each(|(handle, share)| matrix[(v, handle)] = share);
        }
        // Two handles at one place, on vertices of their own, are at no distance from each other.
        for (handle, &v) in vertices.iter().enumerate() {
            matrix.row_mut(v as usize).fill(0.0);
            matrix[(v as usize, handle)] = 1.0;
        }
        for [v, by] in unreached {
            let row = matrix.row(by as usize).into_owned();
            matrix.set_row(v as usize, &row);
        }
        let mut figures = Figures::default();
        figures.set("weights_per_vertex", matrix.iter().filter(|w| **w > 0.0).count() as f64 / count as f64);
        Ok(HandleWeights { matrix, figures })
    }

    fn figures(&self) -> Figures {
        Figures::default()
    }
}

/// The share in vertex `v` of each handle that it follows; they sum to 1.
fn shares(distances: &[&[f64]], v: usize, settings: &InverseDistance) -> Vec<(usize, f64)> {
    let reaching = distances.iter().enumerate().map(|(handle, d)| (handle, d[v])).filter(|(_, d)| d.is_finite());
    let mut near: Vec<_> = reaching.collect();
    near.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
    let Some(&(_, first)) = near.first() else { return vec![] };
    // Handles that are all as near as the first count the same, however many; R is the distance of one beyond.
    let beyond = (settings.neighbours..near.len()).find(|&k| near[k].1 > first);
    let radius = beyond.map_or(f64::INFINITY, |k| near[k].1);
    near.truncate(beyond.unwrap_or(near.len()));
    // Relative to the nearest handle, so that no power overflows; at distance 0 only handles at 0 count.
    let falloff = |d: f64| (1.0 - d / radius) / (1.0 - first / radius) * (first / d);
    let share = |d: f64| if d == first { 1.0 } else { falloff(d).powf(settings.power) };
    let sum: f64 = near.iter().map(|(_, d)| share(*d)).sum();
    near.iter().map(|(handle, d)| (*handle, share(*d) / sum)).collect()
}

#[cfg(test)]
mod tests {
    use mimesh_core::testkit::meshes;

    use super::*;

    fn weights(surface: &Surface, vertices: &[u32], settings: &InverseDistance) -> DMatrix<f64> {
        let points: Vec<_> = vertices.iter().map(|&v| SurfacePoint::Vertex(v)).collect();
        let handles: Vec<usize> = (0..points.len()).collect();
        settings.bind(surface, &points, None).unwrap().solve(&handles).unwrap().matrix
    }

    #[test]
    fn a_vertex_follows_its_nearest_handles_and_no_others() {
        let surface = meshes::icosphere(3);
        let vertices: Vec<u32> = (0..30).map(|k| 20 * k).collect();
        let w = weights(&surface, &vertices, &InverseDistance { neighbours: 3, power: 2.0 });
        let paths = EdgePaths::new(&surface.positions, &surface.triangles, &[]);
        let distances: Vec<_> = vertices.iter().map(|&v| paths.distances(&[v])).collect();
        for v in 0..surface.vertex_count() {
            let of: Vec<usize> = (0..30).filter(|&h| w[(v, h)] > 0.0).collect();
            assert!(!of.is_empty() && of.len() <= 3, "vertex {v} follows {of:?}");
            let farthest = of.iter().map(|&h| distances[h][v]).fold(0.0, f64::max);
            let others = (0..30).filter(|h| !of.contains(h));
            assert!(others.into_iter().all(|h| distances[h][v] >= farthest), "vertex {v} follows {of:?}");
            assert!(w.row(v).iter().all(|w| (0.0..=1.0).contains(w)));
        }
    }

    #[test]
    fn between_two_handles_weights_are_those_of_their_distances() {
        let row = meshes::grid(4, 1);
        // Along the lower edge of the square, at 0 and 1; the vertex at 1/4 is three times as far from the second.
        let w = weights(&row, &[0, 4], &InverseDistance { neighbours: 4, power: 2.0 });
        // Two roundings of a square.
        assert!((w[(1, 0)] - 0.9).abs() < 1e-12 && (w[(2, 0)] - 0.5).abs() < 1e-12, "{w}");
    }
}
