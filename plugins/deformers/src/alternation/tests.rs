use mimesh_core::testkit::random::Random;
use nalgebra::{Rotation3, Vector3};

use super::*;

/// J by its definition, with X given.
fn plain(energy: &Energy, goal: &Goal, maps: &DMatrix<f64>, rotations: &[Matrix3<f64>]) -> f64 {
    let moved = energy.covariances.of_maps.transpose() * maps;
    let of_region = |(g, (rotation, rest)): (usize, (&Matrix3<f64>, &Matrix3<f64>))| {
        let turn = rotation - Matrix3::identity();
        turn.dot(&(turn * rest)) - 2.0 * turn.transpose().dot(&moved.fixed_view::<3, 3>(3 * g, 0))
    };
    let turns: f64 = rotations.iter().zip(&energy.covariances.at_rest).enumerate().map(of_region).sum();
    let quadratic = maps.dot(&(&energy.quadratic * maps)) - 2.0 * maps.dot(&goal.projected) + goal.constant;
    quadratic + energy.lambda * turns + energy.of_ridge(maps, goal)
}

#[test]
fn energies_over_rotations_alone_are_those_of_maps_and_rotations() {
    for seed in 0..20 {
        let mut random = Random::new(seed);
        let mut matrix =
            |rows: usize, columns: usize| DMatrix::from_fn(rows, columns, |_, _| random.between(-1.0, 1.0));
        let (handles, regions) = (1 + seed as usize % 4, 1 + seed as usize % 3);
        let size = 4 * handles;
        let (root, other, of_maps) = (matrix(size, size), matrix(size, size), matrix(size, 3 * regions));
        let (projected, reference, spreads) = (matrix(size, 3), matrix(size, 3), matrix(3, 3 * regions));
        let at_rest = (0..regions).map(|g| spreads.fixed_view::<3, 3>(0, 3 * g).into_owned());
        let at_rest = at_rest.map(|m| m * m.transpose() + Matrix3::identity()).collect();
        let energy = Energy {
            lambda: 0.7,
            quadratic: &root * root.transpose() + DMatrix::identity(size, size),
            covariances: Covariances { of_maps, at_rest },
            ridge: DVector::from_element(size, 0.1),
        };
        let goal = Goal { projected, constant: 5.0, reference };
        let mut turned = || Rotation3::new(Vector3::from_fn(|_, _| random.between(-1.0, 1.0))).into_inner();
        let rotations: Vec<_> = (0..regions).map(|_| turned()).collect();
        for is_exact in [true, false] {
            let response = &energy.covariances.of_maps * energy.lambda;
            let stacked = &other * other.transpose() + DMatrix::identity(size, size);
            let matrix = if is_exact { energy.quadratic.clone() } else { stacked };
            let system = GlobalSystem::new(matrix, &energy.ridge, &response).unwrap();
            let reduced = Reduced::new(&energy, &system, is_exact);
            for steps in [0, 1, 7] {
                let stop = Stop { tolerance: 0.0, max_iterations: steps };
                let found = alternate(&energy, &system, &reduced, &goal, rotations.clone(), stop);
                // The same steps in the space of maps.
                let mut turned = rotations.clone();
                let start = system.solve(&(&goal.projected + &goal.ridge_rhs(&energy.ridge)));
                for (step, of_step) in found.energies.iter().enumerate() {
                    let maps = &start + &system.of_rotations * turns(&turned);
                    let expected = plain(&energy, &goal, &maps, &turned);
                    // Rounding of some hundred products of about 1 to 100.
                    assert!((of_step - expected).abs() < 1e-9, "{seed} {step}: {of_step} and {expected}");
                    let moved = energy.covariances.of_maps.transpose() * &maps;
                    let rest = energy.covariances.at_rest.iter().enumerate();
                    let covariances: Vec<_> =
                        rest.map(|(g, s)| (s + moved.fixed_view::<3, 3>(3 * g, 0)).transpose()).collect();
                    turned = operators::rotations(&covariances);
                    if step + 1 == found.energies.len() {
                        assert!((maps - &found.maps).amax() < 1e-9);
                    }
                }
            }
        }
    }
}
