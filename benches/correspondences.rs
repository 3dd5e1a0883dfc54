//! The map between a horse and a camel of as many triangles, and from a horse to a camel of many pieces.

mod support;

use divan::Bencher;
use mimesh::core::stage::{Correspondence, TransferPair};
use support::{FACES, PIECES, Shape, animal, default_stage, pair};

fn main() {
    support::main();
}

#[divan::bench(args = FACES)]
fn nonrigid_fit(bencher: Bencher, faces: usize) {
    let (stage, pair) = (default_stage::<dyn Correspondence>("nonrigid_fit"), pair(Shape::Camel(faces)));
    bencher.bench(|| stage.correspond(pair.surfaces()).expect("a map"));
}

#[divan::bench(args = PIECES)]
fn nonrigid_fit_of_pebbles(bencher: Bencher, pieces: usize) {
    let (stage, pair) = (default_stage::<dyn Correspondence>("nonrigid_fit"), pair(Shape::Pebbles(pieces)));
    bencher.bench(|| stage.correspond(pair.surfaces()).expect("a map"));
}

/// Between two meshes of one shape.
#[divan::bench(args = FACES)]
fn nearest(bencher: Bencher, faces: usize) {
    let stage = default_stage::<dyn Correspondence>("nearest");
    let [source, target] = [faces, faces * 9 / 10].map(|faces| &animal(Shape::Horse(faces)).surface);
    let pair = TransferPair { source, target, markers: &[], proximity: None };
    bencher.bench(|| stage.correspond(pair).expect("a map"));
}

/// Between two meshes of one topology.
#[divan::bench(args = FACES)]
fn identity(bencher: Bencher, faces: usize) {
    let (stage, surface) = (default_stage::<dyn Correspondence>("identity"), &animal(Shape::Horse(faces)).surface);
    let pair = TransferPair { source: surface, target: surface, markers: &[], proximity: None };
    bencher.bench(|| stage.correspond(pair).expect("a map"));
}
