//! The same shape with fewer triangles.

use nalgebra::Point3;

use super::{
    Surface, bounding_box,
    collapsing::{Collapsing, Ends},
};
use crate::Result;

/// `surface` with about `vertices` vertices, by collapses of edges [Garland and Heckbert 1997].
///
/// An edge becomes the point of least squared distance to the planes around it, weighted by area; planes across a boundary hold that.
/// The edge that costs least goes first; on large surfaces, the edges of the cheaper half in each of some rounds. A collapse neither
/// turns a triangle round nor changes the topology: what is closed stays closed, and components stay apart. Edges at which more than two triangles meet stay, so that more vertices than asked for may
/// remain.
///
/// Departure: the length of an edge counts as well, so that triangles of flat parts do not grow without limit.
///
/// # Errors
///
/// Those of [`Surface::from_triangles`].
pub fn simplify(surface: &Surface, vertices: usize) -> Result<Surface> {
    Ok(simplify_keeping(surface, vertices, &[])?.0)
}

/// Like [`simplify`], where the vertices `kept` stay in their places. Gives the numbers that they have afterwards, too.
///
/// Components keep the order of their first vertices.
///
/// # Errors
///
/// Those of [`Surface::from_triangles`].
pub fn simplify_keeping(surface: &Surface, vertices: usize, kept: &[u32]) -> Result<(Surface, Vec<u32>)> {
    let (low, high) = bounding_box(&surface.positions);
    let (centre, diagonal) = (nalgebra::center(&low, &high), (high - low).norm());
    if surface.vertex_count() <= vertices || diagonal <= 0.0 || !diagonal.is_finite() {
        return Ok((Surface::from_triangles(surface.positions.clone(), surface.triangles.clone())?, kept.to_vec()));
    }
    let unit = surface.positions.iter().map(|p| Point3::from((p - centre) / diagonal)).collect();
    let mut mesh = Collapsing::new(unit, surface.triangles.clone(), kept, Ends::Move);
    mesh.run(surface.vertex_count(), vertices, |_| ());
    let triangles: Vec<[u32; 3]> = mesh.triangles.iter().flatten().copied().collect();
    let mut is_used = vec![false; mesh.positions.len()];
    triangles.iter().flatten().for_each(|&v| is_used[v as usize] = true);
    let mut positions: Vec<_> = mesh.positions.iter().map(|p| centre + p.coords * diagonal).collect();
    let mut numbers = vec![0; kept.len()];
    let used = mesh.stands_for.iter().enumerate().filter(|(v, _)| is_used[*v]);
    for (number, (v, stands_for)) in (0..).zip(used) {
        if let Some(original) = *stands_for {
            // Without the rounding of the way to the unit frame and back.
            positions[v] = surface.positions[original as usize];
            kept.iter().zip(&mut numbers).filter(|(k, _)| **k == original).for_each(|(_, to)| *to = number);
        }
    }
    Ok((Surface::from_triangles(positions, triangles)?, numbers))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{mesh::check_finite, spatial::ClosestPoint, testkit::meshes};

    /// The farthest that a vertex of `from` lies from `to`.
    fn farthest(from: &Surface, to: &Surface) -> f64 {
        let search = ClosestPoint::new(&to.positions, &to.triangles).unwrap();
        let distance = |p| search.find(p, f64::INFINITY, |_| true).unwrap().distance;
        from.positions.iter().map(distance).fold(0.0, f64::max)
    }

    fn volume(surface: &Surface) -> f64 {
        let six = |t: &[u32; 3]| {
            let [p, q, r] = t.map(|v| surface.positions[v as usize].coords);
            p.cross(&q).dot(&r)
        };
        surface.triangles.iter().map(six).sum::<f64>() / 6.0
    }

    #[test]
    fn a_sphere_stays_closed_whole_and_round() {
        let sphere = meshes::icosphere(4);
        for count in [1000, 300, 60] {
            let few = simplify(&sphere, count).unwrap();
            assert_eq!(few.vertex_count(), count);
            // Euler: a closed surface without handles has 2 V − 4 triangles.
            assert_eq!(few.triangle_count(), 2 * count - 4);
            assert!(few.topology().boundary.is_empty() && few.components().count() == 1);
            // A regular mesh of n vertices has edges of √(8π/√3 n); over a chord of length e the sphere rises e²/8. Edges are up to twice that.
            let rise = 8.0 * std::f64::consts::PI / (3f64.sqrt() * count as f64) / 8.0;
            assert!(farthest(&sphere, &few) < 3.0 * rise, "{count}: {}", farthest(&sphere, &few));
            // Nothing is turned round: each triangle faces away from the centre, and so the volume is that of the sphere.
            let outwards = few
                .area_normals(&few.positions)
                .iter()
                .zip(&few.triangles)
                .all(|(n, t)| n.dot(&few.positions[t[0] as usize].coords) > 0.0);
            assert!(outwards && (volume(&few) / volume(&sphere) - 1.0).abs() < 4.0 * rise, "{count}");
        }
    }

    #[test]
    fn flat_faces_and_straight_borders_stay() {
        let bar = meshes::bar([12, 6, 5], [3.0, 1.0, 0.8]);
        let few = simplify(&bar, 30).unwrap();
        // Corners move by the pull to the middle, a millionth.
        assert!(farthest(&bar, &few) < 1e-4 && farthest(&few, &bar) < 1e-4, "{}", farthest(&bar, &few));
        let grid = meshes::grid(20, 20);
        let few = simplify(&grid, 40).unwrap();
        let area = |s: &Surface| s.area_normals(&s.positions).iter().map(|n| n.norm()).sum::<f64>();
        assert!((area(&few) / area(&grid) - 1.0).abs() < 1e-4, "the square keeps its four sides");
    }

    #[test]
    fn components_and_defects_stay_and_nothing_breaks() {
        let two = meshes::two_components();
        let few = simplify(&two, 20).unwrap();
        assert_eq!((few.components().count(), few.topology().boundary.len()), (2, 0));
        let most = simplify(&two, 1).unwrap();
        assert_eq!(most.components().count(), 2);
        // The least closed surface is a tetrahedron.
        assert!(most.vertex_count() >= 8, "{}", most.vertex_count());
        // Three triangles at an edge, one with a repeated corner, one without area.
        let positions = (0..30).map(|k| Point3::new(f64::from(k % 5), f64::from(k / 5), f64::from(k % 3))).collect();
        let mut triangles: Vec<[u32; 3]> = (0..24).map(|k| [k, k + 1, k + 5]).collect();
        triangles.extend([[0, 1, 7], [0, 1, 9], [2, 2, 3], [1, 2, 3]]);
        let odd = Surface::from_triangles(positions, triangles).unwrap();
        let few = simplify(&odd, 5).unwrap();
        check_finite(&few.positions).unwrap();
    }

    #[test]
    fn vertices_that_are_kept_stay_in_their_places() {
        let two = meshes::two_components();
        for surface in [meshes::icosphere(4), meshes::grid(20, 20), two] {
            let kept: Vec<u32> = (0..surface.vertex_count() as u32).step_by(29).collect();
            let (few, numbers) = simplify_keeping(&surface, surface.vertex_count() / 5, &kept).unwrap();
            assert!(few.vertex_count() < surface.vertex_count() / 2);
            for (&v, &number) in kept.iter().zip(&numbers) {
                assert_eq!(surface.positions[v as usize], few.positions[number as usize]);
            }
            let mut distinct = numbers.clone();
            distinct.dedup();
            assert_eq!(distinct.len(), kept.len(), "each has a vertex of its own, in their order");
            assert_eq!(few.components().count(), surface.components().count());
        }
    }

    #[test]
    fn a_mesh_that_is_small_enough_stays_as_it_is() {
        let sphere = meshes::icosphere(1);
        let same = simplify(&sphere, 42).unwrap();
        assert_eq!((same.positions, same.triangles), (sphere.positions, sphere.triangles));
    }
}
