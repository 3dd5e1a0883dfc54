//! Weights of 12 handles: binding to a surface and its handles, and solving; by number of triangles.

mod support;

use divan::Bencher;
use mimesh::core::stage::{Proximity, Weights};
use support::{FACES, PIECES, Shape, animal, default_stage};

const NAMES: [&str; 4] = ["biharmonic", "bounded_biharmonic", "harmonic", "geodesic_falloff"];
const HANDLES: usize = 12;

fn main() {
    support::main();
}

#[divan::bench(args = NAMES, consts = FACES)]
fn bind<const F: usize>(bencher: Bencher, name: &str) {
    let horse = animal(Shape::Horse(F));
    let points = horse.points(HANDLES);
    let weights = default_stage::<dyn Weights>(name);
    bencher.bench(|| weights.bind(&horse.surface, &points, None).expect("a surface with handles"));
}

#[divan::bench(args = NAMES, consts = FACES)]
fn solve<const F: usize>(bencher: Bencher, name: &str) {
    let horse = animal(Shape::Horse(F));
    let bound = default_stage::<dyn Weights>(name).bind(&horse.surface, &horse.points(HANDLES), None);
    let (bound, handles) = (bound.expect("a surface with handles"), (0..HANDLES).collect::<Vec<_>>());
    bencher.bench(|| bound.solve(&handles).expect("weights"));
}

/// The handles of the neighbours of a component reach it over bridges.
#[divan::bench(args = NAMES, consts = PIECES)]
fn bind_and_solve_bridged<const P: usize>(bencher: Bencher, name: &str) {
    let plates = animal(Shape::Plates(P));
    let graph = default_stage::<dyn Proximity>("spanning_tree").proximity(&plates.surface).expect("a graph");
    // The first of many points lie on components of their own.
    let points = plates.points(P.max(HANDLES));
    let weights = default_stage::<dyn Weights>(name);
    let handles: Vec<_> = (0..HANDLES).collect();
    bencher.bench(|| {
        let bound = weights.bind(&plates.surface, &points[..HANDLES], Some(&graph)).expect("a surface with handles");
        bound.solve(&handles).expect("weights")
    });
}
