//! Whether two surfaces lie on each other.

use mimesh_core::{Result, mesh::Surface, spatial::ClosestPoint};
use rayon::prelude::*;

/// Surfaces lie on each other whose points are no farther apart than this on the average, in diagonals.
const LIES_ON: f64 = 0.004;

/// One point in a hundred may be this far away, in diagonals: a hand or an ear more is another shape.
const LIES_ON_P99: f64 = 0.03;

/// So many points of each surface are looked at.
const POINTS: usize = 2000;

/// The mean distance of points of each surface to the other, in diagonals of the target, the larger of the two; `None` unless the
/// surfaces lie on each other.
///
/// # Errors
///
/// Those of [`ClosestPoint::new`].
pub fn overlap(source: &Surface, target: &Surface) -> Result<Option<f64>> {
    let diagonal = target.diagonal();
    let size = source.diagonal() / diagonal;
    // What differs more in size is told apart without a search.
    if !(0.9..1.1).contains(&size) {
        return Ok(None);
    }
    let mut largest: f64 = 0.0;
    for (from, to) in [(target, source), (source, target)] {
        let distances = distances(from, to, diagonal)?;
        let mean = distances.iter().sum::<f64>() / distances.len().max(1) as f64;
        let far = distances[distances.len() - 1 - distances.len() / 100];
        if mean > LIES_ON || far > LIES_ON_P99 {
            return Ok(None);
        }
        largest = largest.max(mean);
    }
    Ok(Some(largest))
}

/// The distances of barycentres of `from` to `to`, in units of `unit`, ascending; at least one.
fn distances(from: &Surface, to: &Surface, unit: f64) -> Result<Vec<f64>> {
    let closest = ClosestPoint::new(&to.positions, &to.triangles)?;
    let step = from.triangle_count().div_ceil(POINTS).max(1);
    let chosen: Vec<_> = from.triangles.iter().step_by(step).collect();
    let distance = |triangle: &&[u32; 3]| {
        let corners = triangle.map(|v| from.positions[v as usize].coords);
        let barycentre = ((corners[0] + corners[1] + corners[2]) / 3.0).into();
        closest.find(&barycentre, f64::INFINITY, |_| true).map_or(f64::INFINITY, |found| found.distance / unit)
    };
    let mut distances: Vec<f64> = chosen.par_iter().map(distance).collect();
    distances.sort_by(f64::total_cmp);
    Ok(distances)
}
