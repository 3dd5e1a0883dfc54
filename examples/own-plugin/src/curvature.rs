//! Points where a surface is curved most, apart from each other.
//!
//! The curvature is the mean curvature in magnitude, smoothed: κ solves (M + t L) κ = ½ ‖L V‖, row by row, with the Laplacian L
//! and the mass M. For t = 0 that is |H| at each vertex, which follows every wrinkle; t = (`smoothing` · diagonal)² lets what is
//! smaller than that go under. Then, again and again, the vertex of greatest κ is taken and all others nearer than `distance`
//! along the surface are struck out. Tips come first: hooves, ears, noses.
//!
//! Every component with an area gets a point before any gets a second, where `count` allows. Vertices on a boundary count as
//! flat, since there ‖L V‖ tells the bend of the border and not that of the surface.

use mimesh_core::{
    Error, Result,
    linalg::{Assembly, Cholesky},
    mesh::{Surface, SurfacePoint},
    operators::{cotangent_laplacian, voronoi_mass},
    plugin::check_ranges,
    register,
    spatial::EdgePaths,
    stage::Sampler,
};
use nalgebra::Vector3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A vertex has at least this part of the mean mass: one of a triangle without area would have none, and its κ no value.
const LEAST_MASS: f64 = 1e-6;

register!(Sampler: Curvature);

/// Vertices where the surface is curved most, apart from each other.
///
/// Tips come first: hooves, ears, noses. A handle there moves what a handle in the middle of a limb cannot.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Curvature {
    /// Most points; there are fewer where `distance` leaves no room.
    #[schemars(range(min = 1))]
    pub count: usize,
    /// How far points keep from each other along the surface, relative to the diagonal of the bounding box.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub distance: f64,
    /// The size of what is smoothed away before curvature is compared, relative to the diagonal; 0 for nothing.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub smoothing: f64,
}

impl Default for Curvature {
    fn default() -> Self {
        Self { count: 100, distance: 0.03, smoothing: 0.01 }
    }
}

#[typetag::serde(name = "curvature")]
impl Sampler for Curvature {
    fn sample(&self, surface: &Surface) -> Result<Vec<SurfacePoint>> {
        check_ranges(self)?;
        let mass = voronoi_mass(&surface.positions, &surface.triangles);
        let curvature = smooth_curvature(surface, &mass, (self.smoothing * surface.diagonal()).powi(2))?;

        // Most curved first, ties by number.
        let mut waiting: Vec<u32> = (0..surface.vertex_count() as u32).filter(|&v| mass[v as usize] > 0.0).collect();
        waiting.sort_by(|&a, &b| curvature[b as usize].total_cmp(&curvature[a as usize]).then(a.cmp(&b)));
        let components = surface.components();
        let component = |v: u32| components.of_vertex[v as usize].map_or(0, |c| c as usize);
        let mut has_point = vec![false; components.count()];
        let paths = EdgePaths::new(&surface.positions, &surface.triangles, &[]);
        let mut nearest = vec![f64::INFINITY; surface.vertex_count()];
        let mut chosen = Vec::new();
        while chosen.len() < self.count {
            let is_free =
                |v: u32| nearest[v as usize] > 0.0 && nearest[v as usize] >= self.distance * surface.diagonal();
            let next = waiting.iter().copied().find(|&v| !has_point[component(v)]);
            let Some(next) = next.or_else(|| waiting.iter().copied().find(|&v| is_free(v))) else { break };
            has_point[component(next)] = true;
            paths.shorten(&mut nearest, next);
            chosen.push(SurfacePoint::Vertex(next));
        }
        if chosen.is_empty() {
            return Err(Error::data(
                "no triangle has an area to put points on",
                "export the mesh again; all its triangles are points or lines",
            ));
        }
        Ok(chosen)
    }
}

/// κ of each vertex, #V, in 1 / unit of length; `time` is t, a squared length.
fn smooth_curvature(surface: &Surface, mass: &[f64], time: f64) -> Result<Vec<f64>> {
    let laplacian = cotangent_laplacian(&surface.positions, &surface.triangles);
    let mut bend = vec![Vector3::zeros(); surface.vertex_count()];
    let mut system = Assembly::new(surface.vertex_count());
    for (i, j, &value) in laplacian.triplet_iter() {
        system.add(i, j, time * value);
        bend[i] += value * surface.positions[j].coords;
        // L is symmetric, and its lower triangle stored.
        if i != j {
            bend[j] += value * surface.positions[i].coords;
        }
    }
    let floor = LEAST_MASS * mass.iter().sum::<f64>() / mass.len() as f64;
    // A surface without any area has no curvature, and no scale either.
    let floor = if floor > 0.0 { floor } else { 1.0 };
    mass.iter().enumerate().for_each(|(v, m)| system.add(v, v, m.max(floor)));
    let mut curvature: Vec<f64> = bend.iter().map(|b| 0.5 * b.norm()).collect();
    surface.topology().boundary.iter().flatten().for_each(|&v| curvature[v as usize] = 0.0);
    Cholesky::new(system.finish(), "the smoothing of curvature")?.solve_refined_in_place(&mut curvature, 1);
    Ok(curvature)
}

#[cfg(test)]
mod tests {
    use mimesh_core::testkit::meshes;
    use nalgebra::Point3;

    use super::*;

    #[test]
    fn a_unit_sphere_has_mean_curvature_1() {
        let sphere = meshes::icosphere(4);
        let mass = voronoi_mass(&sphere.positions, &sphere.triangles);
        for time in [0.0, 0.01] {
            for curvature in smooth_curvature(&sphere, &mass, time).unwrap() {
                // Triangles of edge 0.07 tell the curvature of an arc to the square of that.
                assert!((curvature - 1.0).abs() < 0.01, "{curvature}");
            }
        }
    }

    #[test]
    fn the_ends_of_a_long_ellipsoid_come_first() {
        let mut surface = meshes::icosphere(3);
        surface.positions.iter_mut().for_each(|p| p.x *= 4.0);
        let points = Curvature { count: 2, ..Curvature::default() }.sample(&surface).unwrap();
        let mut ends: Vec<f64> = points.iter().map(|p| p.position(&surface, &surface.positions).x).collect();
        ends.sort_by(f64::total_cmp);
        // No vertex lies at the very ends; the triangles there are 0.6 long.
        assert!(ends[0] < -3.8 && ends[1] > 3.8, "{ends:?}");
    }

    #[test]
    fn points_keep_their_distance_and_size_and_place_do_not_matter() {
        let surface = meshes::icosphere(3);
        let sampler = Curvature { count: 1000, distance: 0.2, ..Curvature::default() };
        let points = sampler.sample(&surface).unwrap();
        assert!(points.len() > 12, "room on a sphere for a dozen at least: {}", points.len());
        let paths = EdgePaths::new(&surface.positions, &surface.triangles, &[]);
        for point in &points {
            let [(v, _)] = point.corners(&surface)[..] else { panic!("points are vertices") };
            let distances = paths.distances(&[v]);
            let others = points.iter().filter(|other| *other != point).map(|other| other.corners(&surface)[0].0);
            // Paths one way and the other sum the same edges in another order.
            assert!(others.into_iter().all(|o| distances[o as usize] >= 0.2 * surface.diagonal() - 1e-12));
        }

        // By a power of two, so that rounding is the same.
        let mut moved = surface.clone();
        moved.positions.iter_mut().for_each(|p| *p = Point3::from(p.coords * 1024.0));
        assert_eq!(sampler.sample(&moved).unwrap(), points);
    }

    #[test]
    fn borders_count_as_flat() {
        let grid = meshes::grid(6, 6);
        let mass = voronoi_mass(&grid.positions, &grid.triangles);
        let curvature = smooth_curvature(&grid, &mass, 0.0).unwrap();
        // Rounding of coordinates of size 1 over an area of 1/36.
        assert!(curvature.iter().all(|c| c.abs() < 1e-12), "{curvature:?}");
    }
}
