//! Points at even steps of area.
//!
//! Triangles are gone through in order, and wherever their summed area passes a multiple of the whole over `count`, a point is
//! put in the middle of that triangle. Every component with an area has a point, in its largest triangle, where `count` allows.

use std::collections::HashSet;

use mimesh_core::{
    Error, Result,
    mesh::{Surface, SurfacePoint},
    operators::is_degenerate,
    plugin::check_ranges,
    register,
    stage::Sampler,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

register!(Sampler: MyStage);

/// Points at even steps of area, in the middle of triangles.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct MyStage {
    /// Most points; there are fewer where triangles are larger than a step.
    #[schemars(range(min = 1))]
    pub count: usize,
}

impl Default for MyStage {
    fn default() -> Self {
        Self { count: 100 }
    }
}

#[typetag::serde(name = "my_stage")]
impl Sampler for MyStage {
    fn sample(&self, surface: &Surface) -> Result<Vec<SurfacePoint>> {
        check_ranges(self)?;
        let areas: Vec<f64> = surface.area_normals(&surface.positions).iter().map(|n| 0.5 * n.norm()).collect();
        let has_area = |t: &usize| !is_degenerate(&surface.corners(&surface.positions, *t));
        let triangles: Vec<usize> = (0..surface.triangle_count()).filter(has_area).collect();
        let mut wanted = largest(surface, &triangles, &areas);
        wanted.extend(at_even_steps(&triangles, &areas, self.count));

        // Components may lie in one another; no two points may.
        let mut places = HashSet::new();
        let middle = |t: usize| SurfacePoint::Triangle(t as u32, [1.0 / 3.0; 3]);
        let place = |point: &SurfacePoint| {
            let p = point.position(surface, &surface.positions);
            [p.x, p.y, p.z].map(f64::to_bits)
        };
        let points = wanted.into_iter().map(middle).filter(|point| places.insert(place(point)));
        let points: Vec<_> = points.take(self.count).collect();
        if points.is_empty() {
            return Err(Error::data(
                "no triangle has an area to put points on",
                "export the mesh again; all its triangles are points or lines",
            ));
        }
        Ok(points)
    }
}

/// The largest of `triangles` in each component, the first of equal ones.
fn largest(surface: &Surface, triangles: &[usize], areas: &[f64]) -> Vec<usize> {
    let components = surface.components();
    let mut largest: Vec<Option<usize>> = vec![None; components.count()];
    for &t in triangles {
        let Some(component) = components.of_vertex[surface.triangles[t][0] as usize] else { continue };
        let largest = &mut largest[component as usize];
        if largest.is_none_or(|other| areas[t] > areas[other]) {
            *largest = Some(t);
        }
    }
    largest.into_iter().flatten().collect()
}

/// The triangles in which the summed area passes a multiple of the whole over `count`.
fn at_even_steps(triangles: &[usize], areas: &[f64], count: usize) -> Vec<usize> {
    let step = triangles.iter().map(|&t| areas[t]).sum::<f64>() / count as f64;
    let mut sum = 0.5 * step;
    let mut passed = Vec::new();
    for &t in triangles {
        let before = (sum / step).floor();
        sum += areas[t];
        if (sum / step).floor() > before {
            passed.push(t);
        }
    }
    passed
}

#[cfg(test)]
mod tests {
    use mimesh_core::testkit::meshes;

    use super::*;

    #[test]
    fn an_even_grid_has_a_point_in_every_so_many_triangles() {
        let grid = meshes::grid(10, 10);
        let points = MyStage { count: 20 }.sample(&grid).unwrap();
        // 200 equal triangles: a point in every tenth, of which the first may be that of the component already.
        assert!(points.len() >= 19 && points.len() <= 20, "{}", points.len());
    }
}
