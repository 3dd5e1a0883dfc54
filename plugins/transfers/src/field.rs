//! The deformation gradient that each target triangle should take.

use mimesh_core::{
    Result,
    mesh::{Surface, SurfacePoint},
    operators::{DeformationGradients, relative_height},
    stage::{TransferPair, TriangleMap},
};
use nalgebra::{Matrix3, Point3};

use crate::{
    extension::{Continuation, Extension, OrphanRule},
    lift::Lift,
};

/// A triangle of source points serves if its shape (area over squared edges) is at least this part of the target
/// triangle's: below, points have been swept together and the quotient of small edges is noise.
const MIN_SHAPE: f64 = 0.2;

/// A partner with a smaller relative height gives no gradient: the quotient of its height before and after is noise.
const MIN_RELATIVE_HEIGHT: f64 = 1e-4;

/// Gives each target triangle a deformation gradient for each pose of the source.
///
/// - Where the map knows the source points under all three corners, it is that of the triangle they span. Summed along a
///   path it gives back what the source does from point to point, so that limbs keep their length across joints, where
///   gradients taken triangle by triangle drift.
/// - Else it is the partner's, as in Sumner and Popović 2004.
/// - Orphans continue their neighbours, as [`Continuation`] says.
#[derive(Debug)]
pub struct Field {
    source: Surface,
    of_partners: DeformationGradients,
    of_points: DeformationGradients,
    /// The source point of each target vertex; vertices without one stand in for nothing.
    points: Vec<SurfacePoint>,
    origins: Vec<Origin>,
    extension: Option<Extension>,
    /// The turns of the source next to orphans; `None` if gradients themselves are continued.
    lift: Option<Lift>,
    /// R that turns the axes of the source to those of the target.
    rotation: Matrix3<f64>,
}

/// Where the gradient of a target triangle comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Origin {
    Points,
    Partner(u32),
    Orphan,
}

impl Field {
    /// Prepares for poses of the source; `use_points` says whether source points are used at all.
    pub fn new(
        pair: TransferPair<'_>,
        map: &TriangleMap,
        rotation: Matrix3<f64>,
        use_points: bool,
        orphans: OrphanRule<'_>,
    ) -> Result<Self> {
        let (source, target) = (pair.source, pair.target);
        let of_partners = DeformationGradients::new(&source.positions, &source.triangles);
        let known = |v: u32| map.points.get(v as usize).copied().flatten();
        let points: Vec<_> =
            (0..target.vertex_count() as u32).map(|v| known(v).unwrap_or(SurfacePoint::Vertex(0))).collect();
        let at_points: Vec<_> = points.iter().map(|p| p.position(source, &source.positions)).collect();
        let of_points = DeformationGradients::new(&at_points, &target.triangles);

        let source_normals = source.area_normals(&source.positions);
        let point_normals = target.area_normals(&at_points);
        let is_too_flat =
            |p: u32| relative_height(&source.corners(&source.positions, p as usize)) < MIN_RELATIVE_HEIGHT;
        let origin = |t: usize| {
            let Some(partner) = map.triangles[t].filter(|&p| !is_too_flat(p)) else {
                return Origin::Orphan;
            };
            let all_known = target.triangles[t].iter().all(|&v| known(v).is_some());
            let same_way = point_normals[t].dot(&source_normals[partner as usize]) > 0.0;
            let at_rest = shape(&target.corners(&target.positions, t));
            let sound = shape(&target.corners(&at_points, t)) > MIN_SHAPE * at_rest && of_points.is_defined(t);
            if use_points && all_known && same_way && sound { Origin::Points } else { Origin::Partner(partner) }
        };
        let origins: Vec<_> = (0..target.triangle_count()).map(origin).collect();
        let is_orphan = |t: u32| origins[t as usize] == Origin::Orphan;
        let extension = Extension::new(target, is_orphan, &orphans)?;
        let lift = match &extension {
            Some(extension) if orphans.continuation == Continuation::Rotations => {
                let partner = |&t: &u32| map.triangles[t as usize].unwrap_or_default();
                Some(Lift::new(source, extension.held().iter().map(partner).collect()))
            }
            _ => None,
        };
        Ok(Self { source: source.clone(), of_partners, of_points, points, origins, extension, lift, rotation })
    }

    /// Number of target triangles whose gradient comes from source points, from a partner, and from neighbours.
    pub fn counts(&self) -> [usize; 3] {
        let orphans = self.origins.iter().filter(|o| **o == Origin::Orphan).count();
        let points = self.origins.iter().filter(|o| **o == Origin::Points).count();
        [points, self.origins.len() - points - orphans, orphans]
    }

    /// Whether target triangle `triangle` is an orphan.
    pub fn is_orphan(&self, triangle: usize) -> bool {
        self.origins[triangle] == Origin::Orphan
    }

    /// The source surface.
    pub fn source(&self) -> &Surface {
        &self.source
    }

    /// #V of the source.
    pub fn source_vertices(&self) -> usize {
        self.source.vertex_count()
    }

    /// R F Rᵀ for each target triangle when the source is at `posed`.
    pub fn at(&self, posed: &[Point3<f64>]) -> Vec<Matrix3<f64>> {
        let at_points: Vec<_> = self.points.iter().map(|p| p.position(&self.source, posed)).collect();
        let turned = |f: Matrix3<f64>| self.rotation * f * self.rotation.transpose();
        let of_triangle = |(t, origin): (usize, &Origin)| match *origin {
            Origin::Points => turned(self.of_points.of_triangle(t, &at_points)),
            Origin::Partner(partner) => turned(self.of_partners.of_triangle(partner as usize, posed)),
            Origin::Orphan => Matrix3::identity(),
        };
        let mut field: Vec<_> = self.origins.iter().enumerate().map(of_triangle).collect();
        match (&self.extension, &self.lift) {
            (Some(extension), Some(lift)) => {
                let turns = lift.quaternions(|t| self.of_partners.of_triangle(t, posed));
                extension.fill_rotations(&mut field, &turns, &self.rotation);
            }
            (Some(extension), None) => extension.fill_gradients(&mut field),
            (None, _) => {}
        }
        field
    }
}

/// Area over the sum of squared edges: 0 for a triangle without area, largest for an equilateral one.
fn shape([a, b, c]: &[Point3<f64>; 3]) -> f64 {
    let edges = (b - a).norm_squared() + (c - b).norm_squared() + (a - c).norm_squared();
    if edges > 0.0 { (b - a).cross(&(c - a)).norm() / edges } else { 0.0 }
}
