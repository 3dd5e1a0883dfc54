//! Components of the target that take their motion from several distant places along the source.

use mimesh_core::{
    Result,
    mesh::SurfacePoint,
    spatial::{DistanceSearch, SurfaceDistance},
    stage::{ProximityGraph, TransferPair},
};
use rayon::prelude::*;

use crate::distribution::first_largest;

/// How much farther apart along the source than on the target torn neighbours are, in diagonals of the source.
const MIN_TEAR: f64 = 0.05;

/// Two neighbours on the target.
pub struct Neighbours {
    /// Their distance on the target.
    pub target: f64,
    /// Their straight distance on the source.
    pub source: f64,
    /// Their places on the source.
    pub places: [SurfacePoint; 2],
    /// The vertices of the target that they belong to, some of them more than once.
    pub vertices: [u32; 6],
}

/// The component with the largest share of torn neighbours, and that share in percent, by distance on the target.
///
/// Neighbours are torn if their distance along the source exceeds their distance on the target, times `scale`, by more than the longest
/// edge of the two source triangles and 5 % of `source_diagonal`. Gaps between components of the source are bridged.
///
/// # Errors
///
/// The errors of [`ProximityGraph::bridges`].
pub fn worst(
    pair: TransferPair<'_>,
    neighbours: &[Neighbours],
    scale: f64,
    source_diagonal: f64,
) -> Result<Option<(usize, f64)>> {
    let bridges = ProximityGraph::bridges(pair.source)?;
    let distance = SurfaceDistance::new(pair.source, &pair.source.positions, &bridges);
    let is_torn = |search: &mut DistanceSearch, n: &Neighbours| {
        let [p, q] = &n.places;
        let edge = distance.longest_edge(p).max(distance.longest_edge(q));
        let allowed = scale * n.target + edge + MIN_TEAR * source_diagonal;
        // A bound needs no search.
        distance.bound(p, q) > allowed && distance.between(p, q, allowed, search).is_infinite()
    };
    let torn: Vec<bool> = neighbours.par_iter().with_min_len(1024).map_init(|| distance.search(), is_torn).collect();
    let components = pair.target.components();
    let (mut total, mut lost) = (vec![0.0; components.count()], vec![0.0; components.count()]);
    for (n, torn) in neighbours.iter().zip(torn) {
        let Some(component) = components.of_vertex[n.vertices[0] as usize] else { continue };
        total[component as usize] += n.target;
        lost[component as usize] += if torn { n.target } else { 0.0 };
    }
    let shares: Vec<f64> = lost.iter().zip(&total).map(|(lost, total)| 100.0 * lost / total).collect();
    Ok(first_largest(&shares).map(|worst| (worst, shares[worst])))
}

#[cfg(test)]
mod tests {
    use mimesh_core::{mesh::Surface, testkit::meshes};
    use nalgebra::{Point3, Vector3};

    use super::*;

    /// A sheet folded over, as two lips that lie on each other: halves 0.02 apart, joined at x = 0. Its diagonal is √2.
    fn folded() -> Surface {
        let mut sheet = meshes::grid(40, 20);
        for p in &mut sheet.positions {
            let along = 2.0 * p.x - 1.0;
            *p = Point3::new(along.abs(), p.y, if along < 0.0 { 0.02 } else { 0.0 });
        }
        sheet
    }

    #[test]
    fn a_component_on_two_sheets_is_torn_along_the_way_around_and_straight_distances_do_not_see_it() {
        let source = folded();
        // A strip near the free rim, half of whose vertices lie on either sheet by turns, and one that lies on one sheet.
        let strip: Vec<Point3<f64>> =
            (0..6).flat_map(|k| [0.9, 0.95].map(|x| Point3::new(x, 0.1 * f64::from(k), 0.01))).collect();
        let both = strip.iter().chain(&strip).copied().map(|p| p + Vector3::z() * 0.001);
        let strip = |first: u32| {
            (0..5).flat_map(move |k| {
                let v = first + 2 * k;
                [[v, v + 1, v + 2], [v + 1, v + 3, v + 2]]
            })
        };
        let target = Surface::from_triangles(both.collect(), strip(0).chain(strip(12)).collect()).unwrap();
        let nearest = |p: &Point3<f64>, z: f64| {
            let distance = |v: &u32| (source.positions[*v as usize] - Point3::new(p.x, p.y, z)).norm();
            (0..source.vertex_count() as u32).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap()
        };
        let place = |v: u32| {
            let z = if v < 12 && (v / 2).is_multiple_of(2) { 0.02 } else { 0.0 };
            SurfacePoint::Vertex(nearest(&target.positions[v as usize], z))
        };
        let at = |place: &SurfacePoint| place.position(&source, &source.positions);
        let neighbours: Vec<Neighbours> = target
            .edges()
            .into_iter()
            .map(|[a, b]| {
                let places = [place(a), place(b)];
                Neighbours {
                    target: (target.positions[a as usize] - target.positions[b as usize]).norm(),
                    source: (at(&places[0]) - at(&places[1])).norm(),
                    places,
                    vertices: [a, b, a, b, a, b],
                }
            })
            .collect();
        let pair = TransferPair { source: &source, target: &target, markers: &[], proximity: None };
        let (component, share) = worst(pair, &neighbours, 1.0, source.diagonal()).unwrap().unwrap();
        assert_eq!(component, 0);
        // All edges between rungs are torn: 10 of 0.1 and 5 diagonals of 0.112, of these and 6 rungs of 0.05.
        let expected = 100.0 * (1.0 + 5.0 * 0.0125f64.sqrt()) / (1.3 + 5.0 * 0.0125f64.sqrt());
        assert!((share - expected).abs() < 1e-9, "{share}, expected {expected}");
        assert!(neighbours.iter().all(|n| n.source < n.target + 0.05), "straight distances are short");
        // The other strip alone.
        let whole: Vec<Neighbours> = neighbours.into_iter().filter(|n| n.vertices[0] >= 12).collect();
        assert_eq!(worst(pair, &whole, 1.0, source.diagonal()).unwrap(), Some((1, 0.0)));
    }
}
