//! Maps of 12 handles: binding to a surface, preparing for handles, and fitting a pose; by number of triangles.

mod support;

use divan::Bencher;
use mimesh::core::stage::{Clusterer, Deformer, HandleWeights, Regions, Weights};
use support::{Animal, FACES, Shape, animal, default_stage};

const NAMES: [&str; 2] = ["arap_skinning", "linear_blend"];

fn main() {
    support::main();
}

/// Weights of 12 handles, and regions.
fn handles(horse: &Animal) -> (HandleWeights, Regions) {
    let weights = default_stage::<dyn Weights>("biharmonic").bind(&horse.surface, &horse.points(12), None);
    let weights = weights.and_then(|weights| weights.solve(&(0..12).collect::<Vec<_>>())).expect("weights");
    let clusterer = default_stage::<dyn Clusterer>("weight_kmeans").bind(&horse.surface, &horse.poses());
    let regions = clusterer.and_then(|clusterer| clusterer.cluster(&weights.matrix)).expect("regions");
    (weights, regions)
}

#[divan::bench(args = NAMES, consts = FACES)]
fn bind<const F: usize>(bencher: Bencher, name: &str) {
    let surface = &animal(Shape::Horse(F)).surface;
    let deformer = default_stage::<dyn Deformer>(name);
    bencher.bench(|| deformer.bind(surface).expect("a surface"));
}

#[divan::bench(args = NAMES, consts = FACES)]
fn skin<const F: usize>(bencher: Bencher, name: &str) {
    let horse = animal(Shape::Horse(F));
    let (weights, regions) = handles(horse);
    let bound = default_stage::<dyn Deformer>(name).bind(&horse.surface).expect("a surface");
    bencher.bench(|| bound.skin(&weights, &regions).expect("a skin"));
}

#[divan::bench(args = NAMES, consts = FACES)]
fn fit<const F: usize>(bencher: Bencher, name: &str) {
    let horse = animal(Shape::Horse(F));
    let (weights, regions) = handles(horse);
    let bound = default_stage::<dyn Deformer>(name).bind(&horse.surface).expect("a surface");
    let skin = bound.skin(&weights, &regions).expect("a skin");
    let pose = horse.pose(1);
    bencher.bench(|| skin.fit(&pose).expect("maps"));
}
