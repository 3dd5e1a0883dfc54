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
        let mut place = vec![None; components.count()];
        chosen.iter().enumerate().for_each(|(k, &c)| place[c as usize] = Some(k));
        let mut bodies: Vec<Body> = chosen.iter().map(|_| Body { triangles: vec![], vertices: vec![] }).collect();
        let body = |v: usize| components.of_vertex[v].and_then(|c| place[c as usize]);
        for (t, normal) in target.area_normals(&target.positions).iter().enumerate() {
            if let Some(k) = body(target.triangles[t][0] as usize) {
                bodies[k].triangles.push((t as u32, normal.norm()));
            }
        }
        for (v, mass) in voronoi_mass(&target.positions, &target.triangles).into_iter().enumerate() {
            if let Some(k) = body(v) {
                bodies[k].vertices.push((v as u32, mass));
            }
        }
        Ok(Self { bodies, rest: target.positions.clone() })
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
