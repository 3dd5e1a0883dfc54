use mimesh_core::{
    linalg::Cholesky,
    mesh::Surface,
    operators::{cotangent_laplacian, voronoi_mass},
    testkit::{meshes, random::Random},
};
use proptest::prelude::*;

use super::*;
use crate::bounded_biharmonic::qp::BoxProgram;

const TOLERANCE: f64 = 1e-6;

/// A bar with uneven, partly obtuse triangles: 86 vertices.
fn uneven_bar(seed: u64) -> Surface {
    let mut surface = meshes::bar([9, 3, 2], [3.0, 0.9, 0.7]);
    let mut random = Random::new(seed);
    surface.positions.iter_mut().for_each(|p| *p += random.vector() * 0.08);
    surface
}

fn energy(surface: &Surface) -> Bilaplacian {
    let mass = voronoi_mass(&surface.positions, &surface.triangles);
    Bilaplacian::new(&cotangent_laplacian(&surface.positions, &surface.triangles), &mass)
}

/// Handles at `unknowns`, with the minima of their programs one by one.
struct Plain {
    unknowns: Vec<usize>,
    held: Vec<bool>,
    starts: Vec<Vec<f64>>,
    minima: Vec<Minimum>,
}

impl Plain {
    fn new(energy: &Bilaplacian, unknowns: &[usize]) -> Self {
        let mut held = vec![false; energy.inverse_mass.len()];
        unknowns.iter().for_each(|&i| held[i] = true);
        let mut matrix = energy.matrix.clone();
        matrix.values_mut().copy_from_slice(&energy.without(&held));
        let pattern = Cholesky::for_refactoring(matrix, "the test").unwrap();
        let program = BoxProgram::new(energy, &held, &pattern).unwrap();
        let starts = program.all_unbounded(unknowns);
        let minima = starts.iter().map(|start| program.minimise(start, TOLERANCE, 100)).collect();
        Self { unknowns: unknowns.to_vec(), held, starts, minima }
    }

    fn handles(&self) -> impl Iterator<Item = LaneHandle<'_>> {
        let each = self.unknowns.iter().zip(&self.starts);
        each.map(|(&unknown, start)| LaneHandle { held: &self.held, unknown, start })
    }
}

fn same(a: &Minimum, b: &Minimum) -> bool {
    a.x == b.x && a.energy == b.energy && a.gap == b.gap && a.iterations == b.iterations
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]
    #[test]
    fn a_handle_minds_no_other_and_comes_as_low_as_alone(
        seed in 0_u64..1000,
        choices in prop::collection::vec(prop::collection::btree_set(0_usize..86, 2..9), 1..5),
        turn in 0_usize..20,
    ) {
        let energy = energy(&uneven_bar(seed));
        let lanes = LaneProgram::new(&energy).unwrap();
        let choices: Vec<Vec<usize>> = choices.into_iter().map(|choice| choice.into_iter().collect()).collect();
        let plain: Vec<_> = choices.iter().map(|choice| Plain::new(&energy, choice)).collect();
        let lane_choices: Vec<_> =
            plain.iter().map(|plain| LaneChoice { held: &plain.held, unknowns: &plain.unknowns }).collect();
        for (found, plain) in lanes.unbounded(&lane_choices).into_iter().zip(&plain) {
            for (x, y) in found.unwrap().iter().zip(&plain.starts) {
                // Rounding at a condition of some 1e6.
                prop_assert!(x.iter().zip(y).all(|(x, y)| (x - y).abs() < 1e-8));
            }
        }
        let mut handles: Vec<_> = plain.iter().flat_map(Plain::handles).collect();
        let mut minima: Vec<_> = plain.iter().flat_map(|plain| &plain.minima).collect();
        let count = handles.len();
        handles.rotate_left(turn % count);
        minima.rotate_left(turn % count);
        let together = lanes.minimise_in::<8>(&handles, TOLERANCE, 100);
        prop_assert_eq!(together.len(), count);
        for ((handle, found), plain) in handles.iter().zip(&together).zip(minima) {
            let alone = lanes.minimise_in::<1>(&[*handle], TOLERANCE, 100);
            prop_assert!(same(found, &alone[0]), "{} and {}", found.energy, alone[0].energy);
            prop_assert!(found.gap <= TOLERANCE * found.energy, "{:e} of {}", found.gap, found.energy);
            // Either may lie above the least by its gap.
            let difference = (found.energy - plain.energy).abs();
            prop_assert!(difference <= found.gap.max(plain.gap), "{} and {}", found.energy, plain.energy);
            prop_assert!(found.x.iter().all(|x| (0.0..=1.0).contains(x)));
        }
        let shared = lanes.minimise(&handles, TOLERANCE, 100);
        prop_assert!(shared.iter().zip(&together).all(|(a, b)| same(a, b)), "eight lanes or four");
    }
}

#[test]
fn held_unknowns_keep_their_values_and_steps_are_limited() {
    let energy = energy(&uneven_bar(3));
    let lanes = LaneProgram::new(&energy).unwrap();
    let unknowns = [0, 17, 40, 66, 80];
    let plain = Plain::new(&energy, &unknowns);
    let handles: Vec<_> = plain.handles().collect();
    for (found, own) in lanes.minimise(&handles, TOLERANCE, 100).iter().zip(unknowns) {
        assert!(unknowns.iter().all(|&i| found.x[i] == f64::from(i == own)));
        assert!((1..100).contains(&found.iterations));
    }
    assert!(lanes.minimise(&handles, TOLERANCE, 2).iter().all(|found| found.iterations <= 2));
    assert!(lanes.minimise(&[], TOLERANCE, 100).is_empty());
}
