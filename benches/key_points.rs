//! The choice of six key points among 30 candidates for one pose, by number of triangles.

mod support;

use divan::Bencher;
use mimesh::core::stage::{KeyPoints, KeyPointsInput};
use serde_json::json;
use support::{Shape, animal, stage};

fn main() {
    support::main();
}

#[divan::bench(args = [2_500, 10_000])]
fn greedy(bencher: Bencher, faces: usize) {
    let horse = animal(Shape::Horse(faces));
    let sampler = json!({ "type": "farthest_point", "count": 30 });
    let greedy =
        stage::<dyn KeyPoints>(json!({ "type": "greedy", "threshold": 0, "max_count": 6, "sampler": sampler }));
    let poses = [horse.pose(1)];
    let input = KeyPointsInput { source: &horse.surface, poses: &poses, start: &[] };
    bencher.bench(|| greedy.choose(input, &()).expect("key points"));
}
