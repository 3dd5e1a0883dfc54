//! The graph of neighbouring components, by number of pieces.

mod support;

use divan::Bencher;
use mimesh::core::stage::Proximity;
use support::{PIECES, Shape, animal, default_stage};

fn main() {
    support::main();
}

#[divan::bench(args = PIECES)]
fn spanning_tree_of_pebbles(bencher: Bencher, pieces: usize) {
    let (stage, camel) = (default_stage::<dyn Proximity>("spanning_tree"), animal(Shape::Pebbles(pieces)));
    bencher.bench(|| stage.proximity(&camel.surface).expect("a graph"));
}

#[divan::bench(args = PIECES)]
fn spanning_tree_of_plates(bencher: Bencher, pieces: usize) {
    let (stage, camel) = (default_stage::<dyn Proximity>("spanning_tree"), animal(Shape::Plates(pieces)));
    bencher.bench(|| stage.proximity(&camel.surface).expect("a graph"));
}
