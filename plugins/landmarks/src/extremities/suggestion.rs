//! The next click: where fits from both sides disagree most, away from the points that are known.

use mimesh_core::{
    Result,
    mesh::{Surface, SurfacePoint},
    spatial::ClosestPoint,
    stage::{Suggestion, TransferPair},
};
use nalgebra::Point3;
use rayon::prelude::*;

use super::comparison::{Comparison, Proxies};

/// Disagreements count up to this, in diagonals: what is lost is lost.
const MOST: f64 = 0.1;

/// What lies this near, in diagonals, is settled by the same click.
const AROUND: f64 = 0.05;

/// What a place counts where the fits agree, so that clicks spread over the surface; one where they disagree entirely counts 1 more.
const EVERYWHERE: f64 = 0.25;

/// The vertex of the source's proxy with the largest product of its distance to known points and of the disagreement around it.
///
/// # Errors
///
/// Those of the search on the surfaces.
pub fn suggest(
    pair: TransferPair<'_>,
    proxies: &Proxies<'_>,
    comparison: Option<&Comparison>,
) -> Result<Option<Suggestion>> {
    let side = proxies.source();
    let known: Vec<Point3<f64>> =
        pair.markers.iter().map(|marker| marker.source.position(pair.source, &pair.source.positions)).collect();
    let positions = &side.surface.positions;
    let doubt = |v: usize| {
        let comparison = comparison?;
        let near = (0..positions.len()).filter(|&u| (positions[u] - positions[v]).norm() <= AROUND * side.diagonal);
        let (all, apart) = near.fold((0.0, 0.0), |(all, apart), u| {
            let own = comparison.source_vertices[u].0 / side.diagonal;
            (all + side.mass[u], apart + side.mass[u] * own.min(MOST))
        });
        Some(if all > 0.0 { apart / all } else { 0.0 })
    };
    let rated = |v: usize| {
        let distance = known.iter().map(|place| (positions[v] - place).norm() / side.diagonal).fold(1.0, f64::min);
        let doubt = doubt(v);
        (distance * (EVERYWHERE + doubt.unwrap_or(0.0) / MOST), v, doubt)
    };
    let best = (0..positions.len()).into_par_iter().map(rated).max_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)));
    let Some((_, vertex, doubt)) = best.filter(|(rate, ..)| *rate > 0.0) else { return Ok(None) };
    let partner = comparison.and_then(|comparison| comparison.source_vertices[vertex].1);
    Ok(Some(Suggestion {
        source: nearest(pair.source, &positions[vertex])?.unwrap_or(SurfacePoint::Vertex(0)),
        target: partner.map(|place| nearest(pair.target, &place)).transpose()?.flatten(),
        doubt,
    }))
}

fn nearest(surface: &Surface, place: &Point3<f64>) -> Result<Option<SurfacePoint>> {
    let found = ClosestPoint::new(&surface.positions, &surface.triangles)?.find(place, f64::INFINITY, |_| true);
    Ok(found.map(|found| SurfacePoint::Triangle(found.triangle, found.barycentric)))
}
