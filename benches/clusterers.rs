//! Regions of a surface with 12 handles and four poses: binding to the poses, and clustering; by number of triangles.

mod support;

use divan::Bencher;
use mimesh::core::stage::{Clusterer, Weights};
use support::{FACES, Shape, animal, default_stage};

const NAMES: [&str; 2] = ["rotation_kmeans", "weight_kmeans"];

fn main() {
    support::main();
}

#[divan::bench(args = NAMES, consts = FACES)]
fn bind<const F: usize>(bencher: Bencher, name: &str) {
    let horse = animal(Shape::Horse(F));
    let poses = horse.poses();
    let clusterer = default_stage::<dyn Clusterer>(name);
    bencher.bench(|| clusterer.bind(&horse.surface, &poses).expect("poses of the surface"));
}

#[divan::bench(args = NAMES, consts = FACES)]
fn cluster<const F: usize>(bencher: Bencher, name: &str) {
    let horse = animal(Shape::Horse(F));
    let bound = default_stage::<dyn Clusterer>(name).bind(&horse.surface, &horse.poses()).expect("poses");
    let weights = default_stage::<dyn Weights>("biharmonic").bind(&horse.surface, &horse.points(12), None);
    let weights = weights.and_then(|weights| weights.solve(&(0..12).collect::<Vec<_>>())).expect("weights");
    bencher.bench(|| bound.cluster(&weights.matrix).expect("regions"));
}
