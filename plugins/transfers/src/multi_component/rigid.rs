//! Components that move as rigid bodies.

use mimesh_core::{
    Result,
    mesh::Surface,
    operators::{polar, voronoi_mass},
    stage::ComponentRef,
};
use nalgebra::{Matrix3, Point3, Vector3};

/// The rigid components of a target.
#[derive(Debug)]
pub struct Rigid {
    bodies: Vec<Body>,
    rest: Vec<Point3<f64>>,
}

#[derive(Debug)]
struct Body {
    /// Triangles with twice their area.
    triangles: Vec<(u32, f64)>,
    /// Vertices with their mass.
    vertices: Vec<(u32, f64)>,
}

impl Rigid {
    /// The components that the user names, and `others` by number.
    pub fn new(target: &Surface, which: &[ComponentRef], others: &[usize]) -> Result<Self> {
        let components = target.components();
        let mut chosen: Vec<u32> = others.iter().map(|&c| c as u32).collect();
        for component in which {
            chosen.extend(component.resolve(target, &components)?);
        }
        chosen.sort_unstable();
        chosen.dedup();
        let mass = voronoi_mass(&target.positions, &target.triangles);
        let areas = target.area_normals(&target.positions);
        let of = |c: u32| Body {
            triangles: (0..target.triangles.len())
                .filter(|&t| components.of_vertex[target.triangles[t][0] as usize] == Some(c))
                .map(|t| (t as u32, areas[t].norm()))
                .collect(),
            vertices: (0..mass.len())
                .filter(|&v| components.of_vertex[v] == Some(c))
                .map(|v| (v as u32, mass[v]))
                .collect(),
        };
        Ok(Self { bodies: chosen.into_iter().map(of).collect(), rest: target.positions.clone() })
    }

    /// Number of rigid components.
    pub fn count(&self) -> usize {
        self.bodies.len()
    }

    /// Gives every triangle of a rigid component the rotation nearest to its mean deformation gradient.
    pub fn stiffen(&self, field: &mut [Matrix3<f64>]) {
        for body in &self.bodies {
            let mean: Matrix3<f64> = body.triangles.iter().map(|&(t, area)| field[t as usize] * area).sum();
            if mean.norm() > 0.0 {
                let rotation = polar(&mean).rotation;
                body.triangles.iter().for_each(|&(t, _)| field[t as usize] = rotation);
            }
        }
    }

    /// Replaces every rigid component by the rigid motion of its rest that comes closest to `positions`.
    pub fn fit(&self, positions: &mut [Point3<f64>]) {
        for body in &self.bodies {
            let total: f64 = body.vertices.iter().map(|(_, m)| m).sum();
            if total <= 0.0 {
                continue;
            }
            let mean = |points: &[Point3<f64>]| {
                body.vertices.iter().map(|&(v, m)| points[v as usize].coords * m).sum::<Vector3<f64>>() / total
            };
            let (from, to) = (mean(&self.rest), mean(positions));
            let covariance: Matrix3<f64> = body
                .vertices
                .iter()
                .map(|&(v, m)| {
                    (positions[v as usize].coords - to) * (self.rest[v as usize].coords - from).transpose() * m
                })
                .sum();
            if covariance.norm() == 0.0 {
                continue;
            }
            let rotation = polar(&covariance).rotation;
            for &(v, _) in &body.vertices {
                positions[v as usize] = Point3::from(to + rotation * (self.rest[v as usize].coords - from));
            }
        }
    }
}
