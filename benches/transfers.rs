//! Transfers from a horse to a camel: binding, one pose, and as many poses as are transferred at once.

mod support;

use divan::{Bencher, counter::ItemsCount};
use mimesh::core::stage::{BoundTransfer, Marker, Transfer};
use nalgebra::Point3;
use support::{FACES, PIECES, Pair, Shape, default_stage, pair};

const NAMES: [&str; 4] = ["gradient", "multi_component", "biharmonic", "copy_displacement"];
const OF_PIECES: [&str; 2] = ["multi_component", "biharmonic"];

fn main() {
    support::main();
}

/// Handles are few; other transfers take all markers.
fn markers(pair: &Pair, name: &str) -> Vec<Marker> {
    if name == "biharmonic" { pair.twelve_markers() } else { pair.markers.clone() }
}

fn bound(pair: &Pair, name: &str) -> Box<dyn BoundTransfer> {
    let (stage, markers) = (default_stage::<dyn Transfer>(name), markers(pair, name));
    stage.bind(pair.bind_input(&*stage, &markers)).expect("a bound transfer")
}

fn bench_bind(bencher: Bencher, pair: &Pair, name: &str) {
    let (stage, markers) = (default_stage::<dyn Transfer>(name), markers(pair, name));
    let input = pair.bind_input(&*stage, &markers);
    bencher.bench(|| stage.bind(input).expect("a bound transfer"));
}

fn bench_apply(bencher: Bencher, pair: &Pair, name: &str) {
    let (bound, pose) = (bound(pair, name), pair.source.pose(1));
    bencher.bench(|| bound.transfer(&pose).expect("a posed target"));
}

fn bench_apply_at_once(bencher: Bencher, pair: &Pair, name: &str) {
    let (bound, poses) = (bound(pair, name), pair.source.poses());
    let several: Vec<&[Point3<f64>]> = poses.iter().map(Vec::as_slice).cycle().take(bound.at_once()).collect();
    bencher.counter(ItemsCount::new(several.len())).bench(|| bound.transfer_all(&several));
}

#[divan::bench(args = NAMES, consts = FACES)]
fn bind<const F: usize>(bencher: Bencher, name: &str) {
    bench_bind(bencher, pair(Shape::Camel(F)), name);
}

#[divan::bench(args = NAMES, consts = FACES)]
fn apply<const F: usize>(bencher: Bencher, name: &str) {
    bench_apply(bencher, pair(Shape::Camel(F)), name);
}

/// Poses a second are in the column of the counter.
#[divan::bench(args = NAMES, consts = FACES)]
fn apply_at_once<const F: usize>(bencher: Bencher, name: &str) {
    bench_apply_at_once(bencher, pair(Shape::Camel(F)), name);
}

#[divan::bench(args = OF_PIECES, consts = PIECES)]
fn bind_to_pebbles<const P: usize>(bencher: Bencher, name: &str) {
    bench_bind(bencher, pair(Shape::Pebbles(P)), name);
}

#[divan::bench(args = OF_PIECES, consts = PIECES)]
fn apply_to_pebbles<const P: usize>(bencher: Bencher, name: &str) {
    bench_apply(bencher, pair(Shape::Pebbles(P)), name);
}
