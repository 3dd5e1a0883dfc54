use mimesh_core::{
    operators::DeformationGradients,
    testkit::meshes::{grid, icosphere},
};
use nalgebra::{Rotation3, Vector3};

use super::*;

const REWEIGHTED: Fit = Fit { steps: 5, epsilon: 0.02 };

/// Fields that no positions have: twists about an axis that differ from triangle to triangle, more for each field.
fn fields(surface: &Surface, count: usize) -> Vec<Vec<Matrix3<f64>>> {
    let twist = |k: usize, t: usize| {
        let height = surface.corners(&surface.positions, t)[0].x / surface.diagonal();
        let angle = (0.3 + k as f64) * height + if t.is_multiple_of(7) { 0.4 } else { 0.0 };
        Rotation3::from_scaled_axis(Vector3::new(0.2, 1.0, 0.1 * k as f64) * angle).into_inner()
    };
    (0..count).map(|k| (0..surface.triangle_count()).map(|t| twist(k, t)).collect()).collect()
}

fn solve(poisson: &Poisson, field: &[Matrix3<f64>]) -> Solution {
    poisson.solve_all(&[field], REWEIGHTED).pop().expect("one field has one solution").unwrap()
}

fn slices(fields: &[Vec<Matrix3<f64>>]) -> Vec<&[Matrix3<f64>]> {
    fields.iter().map(Vec::as_slice).collect()
}

fn farthest(a: &[Point3<f64>], b: &[Point3<f64>]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
}

/// A sphere, and beside it a triangle without area that a vertex hangs on.
fn with_needle() -> Surface {
    let surface = icosphere(2);
    let n = surface.vertex_count() as u32;
    let [a, b] = [surface.positions[0], surface.positions[1]];
    let (mut positions, mut triangles) = (surface.positions, surface.triangles);
    positions.push(a + (b - a) * 0.5);
    triangles.extend([[0, 1, n], [2, 2, 3]]);
    Surface::from_triangles(positions, triangles).unwrap()
}

#[test]
fn lanes_and_fronts_agree() {
    for surface in [icosphere(3), grid(9, 13), with_needle()] {
        let fields = fields(&surface, 3);
        let area = |area| area;
        let lanes = Poisson::new(&surface, area).unwrap();
        let fronts = Poisson::with_limit(&surface, area, 0).unwrap();
        assert_eq!([lanes.at_once(), fronts.at_once()], [8, 1]);
        for fit in [Fit::LEAST_SQUARES, REWEIGHTED] {
            let all = lanes.solve_all(&slices(&fields), fit).into_iter().zip(fronts.solve_all(&slices(&fields), fit));
            for (lanes, fronts) in all {
                let (lanes, fronts) = (lanes.unwrap(), fronts.unwrap());
                // Rounding: the weights of triangles span a factor of 50, and needles are held by 1e-4.
                assert!(farthest(&lanes.positions, &fronts.positions) < 1e-9 * surface.diagonal());
                assert!((lanes.residual - fronts.residual).abs() < 1e-9);
                assert_eq!(lanes.energies.len(), fronts.energies.len());
            }
        }
    }
}

#[test]
fn a_field_has_one_result_alone_and_among_others() {
    let surface = icosphere(3);
    let fields = fields(&surface, 11);
    let poisson = Poisson::new(&surface, |area| area).unwrap();
    let together = poisson.solve_all(&slices(&fields), REWEIGHTED);
    for (field, together) in fields.iter().zip(together) {
        let (alone, together) = (solve(&poisson, field), together.unwrap());
        assert_eq!(alone.positions, together.positions);
        assert_eq!(alone.energies, together.energies);
    }
}

#[test]
fn gradients_of_positions_give_these_positions_back() {
    let surface = with_needle();
    let bend = |p: &Point3<f64>| Point3::new(p.x + 0.3 * p.y * p.y, p.y, p.z - 0.2 * p.x * p.y);
    let posed: Vec<_> = surface.positions.iter().map(bend).collect();
    let of_triangles = DeformationGradients::new(&surface.positions, &surface.triangles);
    let field: Vec<_> = (0..surface.triangle_count()).map(|t| of_triangles.of_triangle(t, &posed)).collect();
    let found = solve(&Poisson::new(&surface, |area| area).unwrap(), &field);
    let held = surface.triangles[0][0] as usize;
    let shift = surface.positions[held] - posed[held];
    // The vertex on the needle follows what the needle has of its own gradient.
    let others = surface.vertex_count() - 1;
    let expected: Vec<_> = posed.iter().map(|p| p + shift).collect();
    // Triangles without area pull with 1e-4 of the others, which fit to rounding.
    assert!(farthest(&found.positions[..others], &expected[..others]) < 1e-3);
    assert!(found.energies.windows(2).all(|pair| pair[1] <= pair[0] + 1e-15));
}
