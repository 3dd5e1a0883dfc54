//! Metrics of a pose with a known result: binding to the rest meshes, and measuring; by number of triangles.

mod support;

use divan::Bencher;
use mimesh::core::stage::{Frame, Metric, MetricContext, MetricInput, Posed};
use nalgebra::Point3;
use support::{FACES, PIECES, Pair, Shape, default_stage, pair};

/// Those of surfaces. `closure` needs vertices to be named.
const NAMES: [&str; 13] = [
    "area_change",
    "contact_slide",
    "edge_stretch",
    "flipped_triangles",
    "jitter",
    "map_collapse",
    "map_tears",
    "marker_fit",
    "point_error",
    "rest_difference",
    "self_intersections",
    "source_motion",
    "volume",
];
const OF_COMPONENTS: [&str; 2] = ["component_gaps", "component_motion"];

fn main() {
    support::main();
}

fn context(pair: &Pair) -> MetricContext<'_> {
    let (rest, surface) = (&pair.target.mesh.rest, &pair.target.surface);
    MetricContext { rest, surface, pair: Some(pair.surfaces()), map: Some(pair.map()) }
}

fn bench_bind(bencher: Bencher, pair: &'static Pair, name: &str) {
    let metric = default_stage::<dyn Metric>(name);
    bencher.bench(|| drop(metric.bind(context(pair)).expect("a bound metric")));
}

fn bench_measure(bencher: Bencher, pair: &'static Pair, name: &str) {
    let metric = default_stage::<dyn Metric>(name);
    let bound = metric.bind(context(pair)).expect("a bound metric");
    let (poses, source) = (pair.target.poses(), pair.source.poses());
    // Meshes without seams have the vertices of their surfaces.
    let posed = |k: usize| Posed::without_seams(&poses[k]);
    let source = |k: usize| Some::<&[Point3<f64>]>(&source[k]);
    let before = [1, 0].map(|k| Some(Frame { result: posed(k), source: source(k) }));
    let input = MetricInput { source: source(2), before, ..MetricInput::against(posed(2), posed(3)) };
    bencher.bench(|| bound.measure(input).expect("statistics"));
}

#[divan::bench(args = NAMES, consts = FACES)]
fn bind<const F: usize>(bencher: Bencher, name: &str) {
    bench_bind(bencher, pair(Shape::Camel(F)), name);
}

#[divan::bench(args = NAMES, consts = FACES)]
fn measure<const F: usize>(bencher: Bencher, name: &str) {
    bench_measure(bencher, pair(Shape::Camel(F)), name);
}

#[divan::bench(args = OF_COMPONENTS, consts = PIECES)]
fn bind_to_plates<const P: usize>(bencher: Bencher, name: &str) {
    bench_bind(bencher, pair(Shape::Plates(P)), name);
}

#[divan::bench(args = OF_COMPONENTS, consts = PIECES)]
fn measure_plates<const P: usize>(bencher: Bencher, name: &str) {
    bench_measure(bencher, pair(Shape::Plates(P)), name);
}
