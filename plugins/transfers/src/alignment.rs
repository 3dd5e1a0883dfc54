//! Corresponding points of a pair, and how the pair lies to each other by them.

use mimesh_core::{
    mesh::SurfacePoint,
    spatial::{Orientation, Oriented, Similarity, Taken},
    stage::{TransferPair, TriangleMap},
};
use nalgebra::{Matrix3, Point3, Vector3};

/// Middles of target triangles with the source points they lie at, weighted by area.
#[derive(Debug)]
pub struct Alignment {
    /// Takes the source to the place, size and orientation of the target at rest.
    pub target_from_source: Similarity,
    /// How its rotation was chosen; `None` if the points leave it open.
    pub oriented: Option<Oriented>,
    /// Weights of source vertices in the mean of all source points; they sum to 1.
    source_weights: Vec<f64>,
    /// Weights of target vertices in the mean of all target points; they sum to 1.
    target_weights: Vec<f64>,
}

impl Alignment {
    pub fn new(pair: TransferPair<'_>, map: &TriangleMap, orientation: Orientation) -> Self {
        let (source, target) = (pair.source, pair.target);
        let areas = target.area_normals(&target.positions);
        let (mut from, mut to, mut weights) = (Vec::new(), Vec::new(), Vec::new());
        let mut source_weights = vec![0.0; source.vertex_count()];
        let mut target_weights = vec![0.0; target.vertex_count()];
        for (t, area) in areas.iter().enumerate() {
            let Some(places) = places(pair, map, t) else { continue };
            let weight = area.norm();
            let mut place = Vector3::zeros();
            for (point, share) in places {
                place += point.position(source, &source.positions).coords * share;
                point.corners(source).into_iter().for_each(|(v, b)| source_weights[v as usize] += weight * share * b);
            }
            from.push(Point3::from(place));
            to.push(middle(&target.corners(&target.positions, t)));
            weights.push(weight);
            target.triangles[t].iter().for_each(|&v| target_weights[v as usize] += weight / 3.0);
        }
        normalise(&mut source_weights);
        normalise(&mut target_weights);
        // Markers decide where there are enough, so that transfer and correspondence take the same rotation.
        let oriented = match by_markers(pair, orientation) {
            Some(by_markers) if by_markers.taken == Taken::Fitted => {
                Similarity::orient(&from, &to, &weights, Orientation::Fitted)
            }
            Some(by_markers) => Some(by_markers),
            None => Similarity::orient(&from, &to, &weights, orientation),
        };
        let rotation = oriented.map_or_else(Matrix3::identity, |oriented| oriented.rotation);
        let target_from_source = Similarity::with_rotation(&from, &to, &weights, rotation);
        Self { target_from_source, oriented, source_weights, target_weights }
    }

    /// Mean of the source points when the source is at `positions`.
    pub fn source_mean(&self, positions: &[Point3<f64>]) -> Vector3<f64> {
        weighted(positions, &self.source_weights)
    }

    /// Mean of the target points when the target is at `positions`.
    pub fn target_mean(&self, positions: &[Point3<f64>]) -> Vector3<f64> {
        weighted(positions, &self.target_weights)
    }
}

/// How the markers orient the pair; `None` if they leave it open.
pub fn by_markers(pair: TransferPair<'_>, orientation: Orientation) -> Option<Oriented> {
    let from: Vec<_> = pair.markers.iter().map(|m| m.source.position(pair.source, &pair.source.positions)).collect();
    let to: Vec<_> = pair.markers.iter().map(|m| m.target.position(pair.target, &pair.target.positions)).collect();
    Similarity::orient(&from, &to, &vec![1.0; from.len()], orientation)
}

/// The source points under target triangle `t` with their shares, which sum to 1: those of its corners if all are known,
/// else the middle of its partner; `None` for an orphan.
fn places(pair: TransferPair<'_>, map: &TriangleMap, t: usize) -> Option<Vec<(SurfacePoint, f64)>> {
    let partner = map.triangles[t]?;
    let corners: Option<Vec<_>> =
        pair.target.triangles[t].iter().map(|&v| Some((map.points.get(v as usize).copied()??, 1.0 / 3.0))).collect();
    Some(corners.unwrap_or_else(|| vec![(SurfacePoint::Triangle(partner, [1.0 / 3.0; 3]), 1.0)]))
}

fn middle([a, b, c]: &[Point3<f64>; 3]) -> Point3<f64> {
    Point3::from((a.coords + b.coords + c.coords) / 3.0)
}

fn normalise(weights: &mut [f64]) {
    let total: f64 = weights.iter().sum();
    if total > 0.0 {
        weights.iter_mut().for_each(|w| *w /= total);
    }
}

fn weighted(positions: &[Point3<f64>], weights: &[f64]) -> Vector3<f64> {
    positions.iter().zip(weights).map(|(p, w)| p.coords * *w).sum()
}
