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
fn a_mesh_that_is_small_enough_stays_as_it_is() {
    let sphere = meshes::icosphere(1);
    let same = simplify(&sphere, 42).unwrap();
    assert_eq!((same.positions, same.triangles), (sphere.positions, sphere.triangles));
}
