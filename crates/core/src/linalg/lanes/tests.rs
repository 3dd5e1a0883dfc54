use std::sync::Arc;

use nalgebra_sparse::CscMatrix;
use proptest::prelude::*;

use super::*;
use crate::linalg::{Assembly, Cholesky};

/// A matrix of `n` unknowns with a chain and `edges` of the given weights, and 0.1 on its diagonal.
fn matrix(n: usize, edges: &[(usize, usize)], weight: impl Fn(usize) -> f64) -> CscMatrix<f64> {
    let mut assembly = Assembly::new(n);
    let chain = (1..n).map(|i| (i - 1, i));
    for (k, (i, j)) in chain.chain(edges.iter().map(|&(i, j)| (i % n, j % n))).enumerate() {
        if i != j {
            assembly.add_outer(&[i as u32, j as u32], &[[1.0], [-1.0]], weight(k));
        }
    }
    (0..n).for_each(|i| assembly.add(i, i, 0.1));
    assembly.finish()
}

fn lanes<const N: usize>(matrices: [&CscMatrix<f64>; N]) -> LaneCholesky<N> {
    let pattern = Arc::new(LanePattern::new(matrices[0], "the test").unwrap());
    let mut lanes = LaneCholesky::new(pattern.clone());
    let values = lanes.clear();
    for (k, matrix) in matrices.into_iter().enumerate() {
        for (i, j, &value) in matrix.triplet_iter() {
            values[pattern.entry(i as u32, j as u32).unwrap() as usize][k] += value;
        }
    }
    lanes
}

/// The solutions for the right-hand side sin i, in the order of the matrix.
fn solutions<const N: usize>(lanes: &LaneCholesky<N>) -> Vec<[f64; N]> {
    let n = lanes.pattern().size();
    let mut x = vec![[[0.0; N]; 1]; n];
    (0..n).for_each(|i| x[lanes.pattern().row(i as u32) as usize][0] = [(i as f64).sin(); N]);
    lanes.solve_in_place(&mut x);
    (0..n).map(|i| x[lanes.pattern().row(i as u32) as usize][0]).collect()
}

proptest! {
    #[test]
    fn every_lane_solves_its_own_matrix_and_minds_no_other(
        n in 1_usize..80,
        edges in prop::collection::vec((0_usize..80, 0_usize..80), 0..200),
    ) {
        let make = |lane: usize| matrix(n, &edges, |k| 0.1 + ((k * 7 + lane * 13) % 10) as f64);
        let matrices: [_; 4] = std::array::from_fn(make);
        let mut four = lanes([&matrices[0], &matrices[1], &matrices[2], &matrices[3]]);
        prop_assert_eq!(four.factor(), [true; 4]);
        let four = solutions(&four);
        for lane in 0..4 {
            let mut alone = lanes([&matrices[lane]]);
            alone.factor_one().unwrap();
            let alone = solutions(&alone);
            let mut plain: Vec<f64> = (0..n).map(|i| (i as f64).sin()).collect();
            Cholesky::new(matrices[lane].clone(), "the test").unwrap().solve_in_place(&mut plain, 1);
            for i in 0..n {
                prop_assert_eq!(four[i][lane], alone[i][0]);
                // Rounding at a condition below 1e5.
                prop_assert!((alone[i][0] - plain[i]).abs() < 1e-9);
            }
        }
    }
}

#[test]
fn a_matrix_that_is_not_definite_spoils_its_own_lane_alone() {
    let good = matrix(30, &[(2, 20), (5, 11)], |k| 1.0 + k as f64);
    let mut bad = good.clone();
    bad.values_mut()[0] = -1.0;
    let mut both = lanes([&good, &bad]);
    assert_eq!(both.factor(), [true, false]);
    let mut alone = lanes([&good]);
    alone.factor_one().unwrap();
    let alone = solutions(&alone);
    assert!(solutions(&both).iter().zip(&alone).all(|(both, alone)| both[0] == alone[0]));
    assert!(lanes([&bad]).factor_one().is_err());
}

#[test]
fn a_graph_that_nothing_holds_is_singular() {
    let mut assembly = Assembly::new(3);
    [[0, 1], [1, 2]].iter().for_each(|edge| assembly.add_outer(edge, &[[1.0], [-1.0]], 1.0));
    assert!(lanes([&assembly.finish()]).factor_one().is_err());
}

#[test]
fn one_matrix_serves_right_hand_sides_in_lanes() {
    let mut one = lanes([&matrix(40, &[(0, 30), (12, 25)], |_| 2.0)]);
    one.factor_one().unwrap();
    let right = |i: usize, lane: usize| (i as f64 + 0.5 * lane as f64).cos();
    let mut together: Vec<[[f64; 4]; 1]> = (0..40).map(|i| [std::array::from_fn(|lane| right(i, lane))]).collect();
    one.solve_lanes_in_place(&mut together);
    for lane in 0..4 {
        let mut alone: Vec<[[f64; 1]; 1]> = (0..40).map(|i| [[right(i, lane)]]).collect();
        one.solve_in_place(&mut alone);
        assert!(together.iter().zip(&alone).all(|(together, alone)| together[0][lane] == alone[0][0]));
    }
}
