use super::*;
use crate::{
    mesh::Surface,
    operators::Gradient,
    testkit::{meshes, random::Random},
};

/// The Laplacian of `surface` with a vertex held, its triangles weighted.
fn laplacian(surface: &Surface, weight: impl Fn(usize) -> f64) -> CscMatrix<f64> {
    let mut assembly = Assembly::new(surface.vertex_count());
    for (t, corners) in surface.triangles.iter().enumerate() {
        let gradient = Gradient::new(&surface.corners(&surface.positions, t)).unwrap();
        let rows: [[f64; 3]; 3] = std::array::from_fn(|k| gradient.of_corners.column(k).into_owned().into());
        assembly.add_outer(corners, &rows, gradient.area * weight(t));
    }
    assembly.add(0, 0, 1.0);
    assembly.finish()
}

/// The values of `lower` where `multigrid` has them.
fn values(multigrid: &Multigrid, lower: &CscMatrix<f64>) -> Vec<f64> {
    let mut values = vec![0.0; multigrid.entry_count()];
    for (i, j, &value) in lower.triplet_iter() {
        values[multigrid.entry(i as u32, j as u32).unwrap() as usize] = value;
    }
    values
}

fn right_hand_side(n: usize) -> Vec<[f64; 3]> {
    let mut random = Random::new(3);
    (0..n).map(|_| random.vector().into()).collect()
}

/// The solution by a factorisation.
fn expected(multigrid: &Multigrid, values: &[f64], b: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let mut x = vec![[0.0; 3]; b.len()];
    assert!(multigrid.solve_directly(values, b, &mut x));
    x
}

/// The largest difference, relative to the largest value.
fn far(a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    let most = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0_f64, |most, x| most.max(x.abs()));
    most(&mut a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| a - b)) / most(&mut b.iter().flatten().copied())
}

#[test]
fn solutions_are_those_of_a_factorisation_and_take_few_steps() {
    for surface in [meshes::icosphere(5), meshes::grid(90, 70), meshes::cylinder(60, 150, 40.0)] {
        let plain = laplacian(&surface, |_| 1.0);
        let multigrid = Multigrid::new(&plain, "the test").unwrap();
        let mut grids = multigrid.grids();
        assert!(!multigrid.prolongations.is_empty());
        let b = right_hand_side(surface.vertex_count());
        // As weights are where joints bend: most are 1, some far less.
        let bent = laplacian(&surface, |t| if t % 5 == 0 || t % 1000 < 300 { 0.02 } else { 1.0 });
        for matrix in [&plain, &bent] {
            let values = values(&multigrid, matrix);
            multigrid.update(&mut grids, &values);
            let expected = expected(&multigrid, &values, &b);
            for (tolerance, limit) in [(1e-3, 0.05), (1e-20, 1e-8)] {
                let mut x = vec![[0.0; 3]; b.len()];
                let steps = multigrid.conjugate_gradients(&mut grids, &values, &b, &mut x, tolerance).unwrap();
                // A step lowers the error to 0.6 or less; the square of the error falls to the tolerance.
                assert!(steps < 60 && (steps < 16 || tolerance < 1e-3), "{steps}");
                assert!(far(&x, &expected) < limit, "{tolerance}: {}", far(&x, &expected));
                // With its solution as the guess there is nothing to do.
                assert!(multigrid.solve(&mut grids, &values, &b, &mut x, tolerance));
            }
        }
    }
}

#[test]
fn a_small_matrix_is_solved_in_a_step() {
    let sphere = meshes::icosphere(2);
    let plain = laplacian(&sphere, |_| 1.0);
    let multigrid = Multigrid::new(&plain, "the test").unwrap();
    let b = right_hand_side(sphere.vertex_count());
    let mut x = vec![[0.0; 3]; b.len()];
    let steps = multigrid.conjugate_gradients(&mut multigrid.grids(), multigrid.first_values(), &b, &mut x, 1e-10);
    // The dense factor has the precision of its entries, so that a second step shows that the first was enough.
    assert!(steps.unwrap() <= 2, "{steps:?}");
}

#[test]
fn parts_that_nothing_ties_are_solved_side_by_side() {
    // More parts than the coarsest level may have rows.
    let triangle = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
    let n = 2000;
    let positions =
        (0..n).flat_map(|k| triangle.map(|[x, y]| nalgebra::Point3::new(x + 2.0 * f64::from(k), y, 0.0))).collect();
    let triangles = (0..n as u32).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
    let parts = Surface::from_triangles(positions, triangles).unwrap();
    let mut assembly = Assembly::new(parts.vertex_count());
    for (i, j, &value) in laplacian(&parts, |_| 1.0).triplet_iter() {
        assembly.add(i, j, value);
    }
    (0..n as usize).for_each(|k| assembly.add(3 * k, 3 * k, 1.0));
    let multigrid = Multigrid::new(&assembly.finish(), "the test").unwrap();
    let b = right_hand_side(parts.vertex_count());
    let mut x = vec![[0.0; 3]; b.len()];
    assert!(multigrid.solve(&mut multigrid.grids(), multigrid.first_values(), &b, &mut x, 1e-20));
    assert!(far(&x, &expected(&multigrid, multigrid.first_values(), &b)) < 1e-8);
}

#[test]
fn what_is_not_positive_definite_is_told() {
    let sphere = meshes::icosphere(4);
    let plain = laplacian(&sphere, |_| 1.0);
    let multigrid = Multigrid::new(&plain, "the test").unwrap();
    let b = right_hand_side(sphere.vertex_count());
    for wrong in [-1.0, f64::NAN] {
        let mut lower = plain.clone();
        let start = lower.col_offsets()[9];
        lower.values_mut()[start] = wrong;
        assert!(Multigrid::new(&lower, "the test").is_err());
        let values = values(&multigrid, &lower);
        let mut grids = multigrid.grids();
        multigrid.update(&mut grids, &values);
        assert!(!multigrid.solve(&mut grids, &values, &b, &mut vec![[0.0; 3]; b.len()], 1e-6));
    }
}
