//! How sure the pairs are, as a colour map of the target: each vertex has the confidence of the pair that is nearest along the surface.

use mimesh_core::spatial::EdgePaths;

use super::{measure::Field, pair::LiveMarkers};
use crate::{meshes::Meshes, scalars::CONFIDENCE_WORDS};

/// The confidence of the pairs `live`; NaN on components without a pair, and where the nearest pair has no confidence.
pub fn field(meshes: &Meshes, live: &LiveMarkers) -> Field {
    let surface = meshes.for_markers()[1].surface;
    let points: Vec<u32> = live
        .markers
        .iter()
        .filter_map(|marker| {
            let corners = marker.target.corners(surface);
            corners.into_iter().max_by(|a, b| a.1.total_cmp(&b.1)).map(|(vertex, _)| vertex)
        })
        .collect();
    let nearest = nearest(meshes.target_paths(), surface.vertex_count(), &points);
    let of_vertex = |v: u32| Some(live.confidences[nearest[v as usize]?]);
    let values = surface.vertex_of.iter().map(|v| v.and_then(of_vertex).map_or(f32::NAN, |share| 100.0 * share as f32));
    Field { words: CONFIDENCE_WORDS, values: values.collect(), high: 100.0 }
}

/// For each vertex the place in `points` of the nearest one; none where no path leads.
fn nearest(paths: &EdgePaths, vertex_count: usize, points: &[u32]) -> Vec<Option<usize>> {
    let mut distances = vec![f64::INFINITY; vertex_count];
    let mut nearest = vec![None; vertex_count];
    for (i, &point) in points.iter().enumerate() {
        let before = distances.clone();
        paths.shorten(&mut distances, point);
        for v in (0..vertex_count).filter(|&v| distances[v] < before[v]) {
            nearest[v] = Some(i);
        }
    }
    nearest
}

#[cfg(test)]
mod tests {
    use mimesh_core::testkit::meshes;

    use super::*;

    #[test]
    fn each_vertex_takes_the_nearest_point_of_its_own_component() {
        let two = meshes::two_components();
        let paths = EdgePaths::new(&two.positions, &two.triangles, &[]);
        let nearest = nearest(&paths, two.vertex_count(), &[0, 7]);
        assert_eq!((nearest[0], nearest[7]), (Some(0), Some(1)));
        assert!(nearest[..42].iter().all(Option::is_some) && nearest[42..].iter().all(Option::is_none));
    }
}
