//! Weights that fall off with the distance along the surface.
//!
//! wₖ ∝ dₖ⁻ᵖ with dₖ the distance from handle k [Shepard 1968], divided by the sum over handles. Bridged components are as far
//! apart as the ends of their bridges.

use mimesh_core::{
    Figures, Result,
    mesh::{Surface, SurfacePoint},
    plugin::check_ranges,
    register,
    spatial::EdgePaths,
    stage::{BoundWeights, HandlePoints, HandleWeights, ProximityGraph, Weights, unreached},
};
use nalgebra::DMatrix;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

register!(Weights: MyStage);

/// Weights that fall off with the distance along the surface.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct MyStage {
    /// p: how fast weights fall off; the greater, the sharper is the border between two handles.
    #[schemars(range(min = 1.0, max = 16.0))]
    pub power: f64,
}

impl Default for MyStage {
    fn default() -> Self {
        Self { power: 2.0 }
    }
}

#[typetag::serde(name = "my_stage")]
impl Weights for MyStage {
    // What depends on the surface and on all points that may become handles is done here, once.
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
        let distances = points.all().iter().map(|&v| paths.distances(&[v])).collect();
        Ok(Box::new(Bound { power: self.power, surface: surface.clone(), points, distances }))
    }
}

#[derive(Debug)]
struct Bound {
    power: f64,
    surface: Surface,
    points: HandlePoints,
    /// From each point to each vertex; infinite where no path leads.
    distances: Vec<Vec<f64>>,
}

impl BoundWeights for Bound {
    // Called for every choice of handles, from many threads.
    fn solve(&self, handles: &[usize]) -> Result<HandleWeights> {
        let vertices = self.points.choose(handles)?;
        let count = self.surface.vertex_count();
        let nearest = |v: usize| handles.iter().map(|&h| self.distances[h][v]).fold(f64::INFINITY, f64::min);
        let nearest: Vec<f64> = (0..count).map(nearest).collect();
        let reached: Vec<bool> = nearest.iter().map(|d| d.is_finite()).collect();
        let unreached = unreached(&self.surface, &reached)?;
        let mut matrix = DMatrix::zeros(count, handles.len());
        for v in (0..count).filter(|&v| reached[v]) {
            // Relative to the nearest handle, so that no power overflows; at distance 0 only handles at 0 count.
            let share = |d: f64| if d == nearest[v] { 1.0 } else { (nearest[v] / d).powf(self.power) };
            let shares: Vec<f64> = handles.iter().map(|&h| share(self.distances[h][v])).collect();
            let sum: f64 = shares.iter().sum();
            shares.iter().enumerate().for_each(|(handle, share)| matrix[(v, handle)] = share / sum);
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
        Ok(HandleWeights { matrix, figures: Figures::default() })
    }

    fn figures(&self) -> Figures {
        Figures::default()
    }
}

#[cfg(test)]
mod tests {
    use mimesh_core::testkit::meshes;

    use super::*;

    #[test]
    fn between_two_handles_weights_are_those_of_their_distances() {
        let row = meshes::grid(4, 1);
        // Along the lower edge of the square, at 0 and 1; the vertex at 1/4 is three times as far from the second.
        let points = [SurfacePoint::Vertex(0), SurfacePoint::Vertex(4)];
        let w = MyStage { power: 2.0 }.bind(&row, &points, None).unwrap().solve(&[0, 1]).unwrap().matrix;
        // Two roundings of a square.
        assert!((w[(1, 0)] - 0.9).abs() < 1e-12 && (w[(2, 0)] - 0.5).abs() < 1e-12, "{w}");
    }
}
