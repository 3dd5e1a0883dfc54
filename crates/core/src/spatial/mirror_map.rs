//! Points of a surface and those on its other side.

use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

use super::{ClosestPoint, OnSurface};
use crate::{Error, Result, mesh::Surface};

/// How often the plane of symmetry is moved to the middle of the pairs that it gives.
const ROUNDS: usize = 10;

/// For each vertex of a surface the point of the surface on the other side of its plane of symmetry.
#[derive(Clone, Debug)]
pub struct MirrorMap {
    axis: usize,
    partners: Vec<([u32; 3], [f64; 3])>,
    /// The mean distance between mirrored vertices and the surface, relative to its diagonal; 0 for a symmetric surface.
    pub asymmetry: f64,
}

impl MirrorMap {
    /// The map of `surface` whose plane of symmetry is across `axis` (0 to 2), in the middle between both sides.
    ///
    /// # Errors
    ///
    /// [`Error::Data`] for a surface that cannot be searched.
    pub fn new(surface: &Surface, axis: usize) -> Result<Self> {
        let search = ClosestPoint::new(&surface.positions, &surface.triangles)?;
        let (low, high) = crate::mesh::bounding_box(&surface.positions);
        let mut middle = 0.5 * (low[axis] + high[axis]);
        let mut found = mirrored(surface, &search, axis, middle)?;
        for _ in 0..ROUNDS {
            let sum: f64 = surface.positions.iter().zip(&found).map(|(p, on)| 0.5 * (p[axis] + on.point[axis])).sum();
            middle = sum / found.len() as f64;
            found = mirrored(surface, &search, axis, middle)?;
        }
        let off = |(p, on): (&Point3<f64>, &OnSurface)| (reflected(p, axis, middle) - on.point).norm();
        let asymmetry = surface.positions.iter().zip(&found).map(off).sum::<f64>() / found.len() as f64;
        let partner = |on: &OnSurface| (surface.triangles[on.triangle as usize], on.barycentric);
        Ok(Self {
            axis,
            partners: found.iter().map(partner).collect(),
            asymmetry: asymmetry / surface.diagonal().max(f64::MIN_POSITIVE),
        })
    }

    /// What vertices move by (#V) when the other side moves by `displacements` (#V).
    ///
    /// # Errors
    ///
    /// [`Error::Shape`] if the count differs.
    pub fn mirror(&self, displacements: &[Vector3<f64>]) -> Result<Vec<Vector3<f64>>> {
        Error::check_shape("displacements: vertices", self.partners.len(), displacements.len())?;
        let mirror = |(corners, weights): &([u32; 3], [f64; 3])| {
            let terms = corners.iter().zip(weights).filter(|(_, weight)| **weight != 0.0);
            let mut sum: Vector3<f64> = terms.map(|(&v, weight)| displacements[v as usize] * *weight).sum();
            sum[self.axis] = -sum[self.axis];
            sum
        };
        Ok(self.partners.iter().map(mirror).collect())
    }
}

/// The points of the surface nearest to its mirrored vertices.
fn mirrored(surface: &Surface, search: &ClosestPoint, axis: usize, middle: f64) -> Result<Vec<OnSurface>> {
    let find = |p: &Point3<f64>| search.find(&reflected(p, axis, middle), f64::INFINITY, |_| true);
    let found: Option<Vec<OnSurface>> = surface.positions.par_iter().map(find).collect();
    found.ok_or_else(|| {
        Error::data("no point of the surface is nearest to a mirrored vertex", "look for vertices far away")
    })
}

fn reflected(p: &Point3<f64>, axis: usize, middle: f64) -> Point3<f64> {
    let mut p = *p;
    p[axis] = 2.0 * middle - p[axis];
    p
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testkit::meshes;

    #[test]
    fn a_symmetric_surface_takes_the_motion_of_one_side_to_the_other_and_back() {
        let mut surface = meshes::icosphere(2);
        surface.positions.iter_mut().for_each(|p| p.x += 7.0);
        let map = MirrorMap::new(&surface, 0).unwrap();
        assert!(map.asymmetry < 1e-9, "{}", map.asymmetry);
        let bump = |p: &Point3<f64>| if p.x > 7.3 { Vector3::new(p.y, 0.2, p.z * p.x) } else { Vector3::zeros() };
        let moved: Vec<_> = surface.positions.iter().map(bump).collect();
        let mirrored = map.mirror(&moved).unwrap();
        for (p, d) in surface.positions.iter().zip(&mirrored) {
            let mut expected = bump(&Point3::new(14.0 - p.x, p.y, p.z));
            expected.x = -expected.x;
            // The vertices of the icosphere have partners, up to the rounding of the search in 64 bits.
            assert!((d - expected).norm() < 1e-6, "{p}: {d} {expected}");
        }
        let back = map.mirror(&mirrored).unwrap();
        assert!(back.iter().zip(&moved).all(|(a, b)| (a - b).norm() < 1e-6));
        assert!(map.mirror(&moved[1..]).is_err());
    }

    #[test]
    fn a_lopsided_surface_is_told() {
        let mut surface = meshes::icosphere(2);
        // One half leans by as much as it is wide.
        surface.positions.iter_mut().filter(|p| p.x > 0.0).for_each(|p| p.y += 2.0 * p.x);
        let asymmetry = MirrorMap::new(&surface, 0).unwrap().asymmetry;
        assert!(asymmetry > 0.02, "{asymmetry}");
    }
}
