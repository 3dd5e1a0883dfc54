//! Corresponding points of a horse and a camel, found by their shapes; by number of triangles.

mod support;

use divan::Bencher;
use mimesh::core::stage::Landmarks;
use support::{Shape, default_stage, pair};

fn main() {
    support::main();
}

#[divan::bench(args = [2_500, 10_000, 40_000])]
fn extremities(bencher: Bencher, faces: usize) {
    let (stage, pair) = (default_stage::<dyn Landmarks>("extremities"), pair(Shape::Camel(faces)));
    bencher.bench(|| stage.propose(pair.with_markers(&[])).expect("points"));
}
