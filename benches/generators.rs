//! Made animals with a gallop of four frames, by number of triangles and of pieces.

mod support;

use divan::Bencher;
use mimesh::core::stage::Generator;
use support::{FACES, PIECES, Shape, settings, stage};

fn main() {
    support::main();
}

fn make(bencher: Bencher, shape: Shape) {
    let generator = stage::<dyn Generator>(settings(shape));
    bencher.bench(|| generator.make().expect("an animal"));
}

#[divan::bench(args = FACES)]
fn skin(bencher: Bencher, faces: usize) {
    make(bencher, Shape::Camel(faces));
}

#[divan::bench(args = PIECES)]
fn pebbles(bencher: Bencher, pieces: usize) {
    make(bencher, Shape::Pebbles(pieces));
}

#[divan::bench(args = PIECES)]
fn plates(bencher: Bencher, pieces: usize) {
    make(bencher, Shape::Plates(pieces));
}
