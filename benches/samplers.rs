//! 100 points on a surface, by number of triangles.

mod support;

use divan::Bencher;
use mimesh::core::stage::Sampler;
use serde_json::json;
use support::{FACES, Shape, animal, stage};

fn main() {
    support::main();
}

#[divan::bench(args = ["farthest_point", "poisson_disk"], consts = FACES)]
fn sample<const F: usize>(bencher: Bencher, name: &str) {
    let surface = &animal(Shape::Horse(F)).surface;
    let sampler = stage::<dyn Sampler>(json!({ "type": name, "count": 100 }));
    bencher.bench(|| sampler.sample(surface).expect("points"));
}
