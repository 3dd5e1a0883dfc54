//! Points spread evenly over a surface, which stand for it whatever its triangles are.

use mimesh_core::{
    Error, Result,
    mesh::{Surface, SurfacePoint, check_finite},
    stage::Sampler,
};
use nalgebra::{Point3, Vector3};

/// Points of a surface.
#[derive(Clone, Debug)]
pub struct Cloud {
    /// The points on the surface, #P.
    pub points: Vec<SurfacePoint>,
    /// Where they lie, #P × 3.
    pub places: Vec<Point3<f64>>,
    /// The unit normals there, #P × 3; zero where triangles have no area.
    pub normals: Vec<Vector3<f64>>,
    /// The component of the surface that each lies on, #P.
    pub components: Vec<u32>,
    /// The side of a square of the surface's area that one point stands for.
    pub spacing: f64,
    /// The volume that the triangles enclose relative to their area to the power 3/2, negative if they point inwards. A sphere has 0.094.
    pub volume: f64,
}

impl Cloud {
    /// The points that `sampler` spreads over `surface`.
    ///
    /// # Errors
    ///
    /// Those of the sampler, and [`Error::Data`] for a surface that is not finite or has no area.
    pub fn new(surface: &Surface, sampler: &dyn Sampler) -> Result<Self> {
        check_finite(&surface.positions)?;
        let area_normals = surface.area_normals(&surface.positions);
        let area = area_normals.iter().map(|n| n.norm() / 2.0).sum::<f64>();
        if !(area.is_finite() && area > 0.0) {
            let hint = "give a mesh whose triangles have area, in a unit that leaves its area a finite number";
            return Err(Error::data(format!("the surface has an area of {area}"), hint));
        }
        let points = sampler.sample_available(surface)?.points;
        let mut at_vertex = vec![Vector3::zeros(); surface.vertex_count()];
        for (corners, normal) in surface.triangles.iter().zip(&area_normals) {
            corners.iter().for_each(|&v| at_vertex[v as usize] += normal);
        }
        let normal = |point: &SurfacePoint| match *point {
            SurfacePoint::Vertex(v) => at_vertex[v as usize],
            SurfacePoint::Triangle(t, _) => area_normals[t as usize],
        };
        let of_vertex = surface.components().of_vertex;
        let component = |point: &SurfacePoint| of_vertex[point.corners(surface)[0].0 as usize].unwrap_or_default();
        Ok(Self {
            places: points.iter().map(|point| point.position(surface, &surface.positions)).collect(),
            normals: points.iter().map(|p| normal(p).try_normalize(0.0).unwrap_or_default()).collect(),
            components: points.iter().map(component).collect(),
            spacing: (area / points.len() as f64).sqrt(),
            volume: volume(surface, &area_normals) / area.powf(1.5),
            points,
        })
    }

    /// Whether the points lie on more than one component.
    pub fn is_parted(&self) -> bool {
        self.components.iter().any(|component| *component != self.components[0])
    }
}

/// The volume under the triangles of `surface`, seen from the mean of its vertices, so that no digits are lost far from the origin.
fn volume(surface: &Surface, area_normals: &[Vector3<f64>]) -> f64 {
    let sum: Vector3<f64> = surface.positions.iter().map(|p| p.coords).sum();
    let middle = sum / surface.vertex_count() as f64;
    let sixths = surface.triangles.iter().zip(area_normals);
    sixths.map(|(t, normal)| (surface.positions[t[0] as usize].coords - middle).dot(normal)).sum::<f64>() / 6.0
}
