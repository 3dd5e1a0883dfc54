//! More points, where two fits agree.

use mimesh_core::{
    Result,
    mesh::SurfacePoint,
    spatial::ClosestPoint,
    stage::{Marker, TransferPair},
};
use nalgebra::Point3;

/// Points nearer to others, in diagonals of the target, say nothing new.
const MIN_DISTANCE: f64 = 0.05;

/// At most `most` of the places in `agreed`, each as far from `taken` and from those before as can be on the target, as points of the
/// surfaces of `pair`, named `name` with a number.
///
/// # Errors
///
/// Those of the search.
pub fn between(
    pair: TransferPair<'_>,
    agreed: &[[Point3<f64>; 2]],
    taken: &[Marker],
    most: usize,
    name: &str,
) -> Result<Vec<Marker>> {
    if most == 0 || agreed.is_empty() {
        return Ok(vec![]);
    }
    let search = [pair.source, pair.target].map(|surface| ClosestPoint::new(&surface.positions, &surface.triangles));
    let [source, target] = search;
    let (source, target) = (source?, target?);
    let least = MIN_DISTANCE * pair.target.diagonal();
    let mut near = vec![f64::INFINITY; agreed.len()];
    let lower = |near: &mut [f64], place: &Point3<f64>| {
        near.iter_mut().zip(agreed).for_each(|(near, [_, other])| *near = near.min((other - place).norm()));
    };
    for marker in taken {
        lower(&mut near, &marker.target.position(pair.target, &pair.target.positions));
    }
    let mut found = Vec::new();
    while found.len() < most
        && let Some(next) = (0..near.len()).reduce(|best, k| if near[k] > near[best] { k } else { best })
        && near[next] >= least
    {
        let [from, to] = &agreed[next];
        lower(&mut near, to);
        if let (Some(source), Some(target)) = (point(&source, from), point(&target, to)) {
            found.push(Marker { name: format!("{name}{}", found.len() + 1), source, target });
        }
    }
    Ok(found)
}

/// The point of a surface that is nearest to `place`.
fn point(search: &ClosestPoint, place: &Point3<f64>) -> Option<SurfacePoint> {
    let found = search.find(place, f64::INFINITY, |_| true)?;
    Some(SurfacePoint::Triangle(found.triangle, found.barycentric))
}
