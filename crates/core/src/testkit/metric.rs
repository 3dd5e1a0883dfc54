//! The contract of metrics.

use std::collections::HashSet;

use nalgebra::{Point3, Rotation3, Vector3};

use super::{
    random::Random,
    support::{bent_bar, one_thread, twisted, with_defects},
};
use crate::{
    Figures, Result,
    mesh::{Mesh, Surface},
    stage::{
        Aggregate, BoundMetric, Frame, Measured, Metric, MetricContext, MetricInput, Posed, Statistic, TransferPair,
        TriangleMap,
    },
};

/// Words that the meaning of a statistic may have.
const MAX_WORDS: usize = 25;

/// The contract of [`Metric`], on a sound mesh and on one with defects.
///
/// # Panics
///
/// With `name` and the clause that `stage` breaks.
pub fn metric(name: &str, stage: &dyn Metric) {
    declares_its_statistics(name, &stage.statistics());
    for surface in [bent_bar(), with_defects(bent_bar())] {
        let scene = Scene::new(surface);
        measures_poses(name, stage, &scene);
        exceeds_no_limit_at_rest(name, stage, &scene);
        refuses_other_counts(name, stage, &scene);
    }
    ignores_a_rigid_motion(name, stage);
}

/// A surface that is source and target of a transfer at once, and its twist in two frames.
struct Scene {
    surface: Surface,
    mesh: Mesh,
    map: TriangleMap,
    /// The pose to measure.
    ground_truth: Vec<Point3<f64>>,
    /// The pose before it; the one before that is the rest.
    before: Vec<Point3<f64>>,
}

impl Scene {
    fn new(surface: Surface) -> Self {
        let mesh = Mesh::from_triangles(surface.positions.clone(), &surface.triangles);
        let count = surface.triangle_count();
        let partners = (0..count as u32).map(Some).collect();
        let map = TriangleMap { source_triangle_count: count, triangles: partners, ..TriangleMap::default() };
        let (ground_truth, before) = (twisted(&surface, 0.5), twisted(&surface, 0.25));
        Self { surface, mesh, map, ground_truth, before }
    }

    fn context(&self) -> MetricContext<'_> {
        let pair = TransferPair { source: &self.surface, target: &self.surface, markers: &[], proximity: None };
        MetricContext { rest: &self.mesh, surface: &self.surface, pair: Some(pair), map: Some(&self.map) }
    }

    fn bind<'a>(&'a self, name: &str, stage: &dyn Metric) -> Box<dyn BoundMetric + 'a> {
        stage.bind(self.context()).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    /// `result` in this pose, whose known result is `ground_truth`, while the source is at `source`.
    fn input<'a>(
        &'a self,
        result: &'a [Point3<f64>],
        ground_truth: &'a [Point3<f64>],
        source: &'a [Point3<f64>],
    ) -> MetricInput<'a> {
        MetricInput {
            result: Posed::without_seams(result),
            ground_truth: Some(Posed::without_seams(ground_truth)),
            source: Some(source),
            before: [frame(&self.before), frame(&self.surface.positions)],
            wants_field: true,
        }
    }

    /// The known result with a random offset of about `amount` at every vertex.
    fn noisy(&self, seed: u64, amount: f64) -> Vec<Point3<f64>> {
        let mut random = Random::new(seed);
        self.ground_truth.iter().map(|p| p + random.vector() * amount).collect()
    }
}

fn frame(positions: &[Point3<f64>]) -> Option<Frame<'_>> {
    Some(Frame { result: Posed::without_seams(positions), source: Some(positions) })
}

fn expect(name: &str, measured: Result<Measured>) -> Measured {
    measured.unwrap_or_else(|error| panic!("{name}: {error}"))
}

fn declares_its_statistics(name: &str, statistics: &[Statistic]) {
    assert!(!statistics.is_empty(), "{name}: declares no statistic");
    assert!(statistics[0].aggregate != Aggregate::None, "{name}: the primary statistic has no average");
    let (mut names, mut titles) = (HashSet::new(), HashSet::new());
    for Statistic { name: statistic, title, unit, aggregate, limits, meaning } in statistics {
        let is_plain = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_';
        assert!(!statistic.is_empty() && statistic.chars().all(is_plain), "{name}: `{statistic}` is not snake_case");
        assert!(names.insert(statistic), "{name}: declares `{statistic}` twice");
        assert!(!unit.is_empty(), "{name}: `{statistic}` has no unit");
        let is_sentence = meaning.starts_with(|c: char| !c.is_whitespace()) && meaning.ends_with('.');
        assert!(is_sentence, "{name}: the meaning of `{statistic}` is no sentence: {meaning:?}");
        let words = meaning.split_whitespace().count();
        assert!(words <= MAX_WORDS, "{name}: the meaning of `{statistic}` has {words} words, at most {MAX_WORDS}");
        let is_phrase = *title == title.trim() && !title.ends_with('.');
        assert!(is_phrase, "{name}: the title of `{statistic}` is a sentence or has blanks around it: {title:?}");
        assert!(title.is_empty() || titles.insert(title), "{name}: two statistics have the title {title:?}");
        let Some(limits) = limits else { continue };
        assert!(*aggregate != Aggregate::None, "{name}: `{statistic}` is the number of a thing and has limits");
        let in_order = 0.0 <= limits.doubtful && limits.doubtful <= limits.bad && limits.bad.is_finite();
        assert!(in_order, "{name}: limits of `{statistic}` in the wrong order: {limits:?}");
    }
}

fn measures_poses(name: &str, stage: &dyn Metric, scene: &Scene) {
    let statistics = stage.statistics();
    let bound = scene.bind(name, stage);
    let (ground_truth, noisy) = (&scene.ground_truth, scene.noisy(1, 0.05));
    for result in [ground_truth, &noisy, &scene.surface.positions] {
        let run = || expect(name, bound.measure(scene.input(result, ground_truth, ground_truth)));
        let measured = run();
        gives_declared_numbers(name, &statistics, &measured.statistics);
        gives_a_field_of_the_mesh(name, &measured, result.len());
        let again = one_thread(run);
        assert!(measured.statistics == again.statistics, "{name}: other statistics on one thread");
        assert!(bits(&measured.field) == bits(&again.field), "{name}: another field on one thread");
        assert!(measured.about == again.about, "{name}: about something else on one thread");
        let input = MetricInput { wants_field: false, ..scene.input(result, ground_truth, ground_truth) };
        let without = expect(name, bound.measure(input));
        assert!(measured.statistics == without.statistics, "{name}: other statistics without a field");
        assert!(measured.about == without.about, "{name}: about something else without a field");
    }
    let alone = stage.bind(MetricContext::alone(&scene.mesh, &scene.surface));
    let alone = alone.unwrap_or_else(|error| panic!("{name}: {error}"));
    let measured = expect(name, alone.measure(MetricInput::alone(Posed::without_seams(ground_truth))));
    let is_empty = measured.statistics.values.is_empty();
    assert!(is_empty || !stage.needs_ground_truth(), "{name}: needs a ground truth, but has statistics without one");
    gives_declared_numbers(name, &statistics, &measured.statistics);
    if stage.needs_ground_truth() {
        let same = expect(name, bound.measure(scene.input(ground_truth, ground_truth, ground_truth)));
        for statistic in statistics.iter().filter(|statistic| statistic.limits.is_some()) {
            let found = same.statistics.number(statistic.name).unwrap_or(0.0);
            // Centroids round.
            assert!(
                found.abs() <= 1e-9,
                "{name}: `{}` is {found} where the result is the ground truth",
                statistic.name
            );
        }
    }
    // A vertex that is not finite may be refused or left out, but no statistic may be NaN, which JSON has no word for.
    let mut broken = ground_truth.clone();
    broken[3].y = f64::NAN;
    if let Ok(measured) = bound.measure(scene.input(&broken, ground_truth, ground_truth)) {
        gives_declared_numbers(name, &statistics, &measured.statistics);
    }
}

fn gives_declared_numbers(name: &str, declared: &[Statistic], found: &Figures) {
    for (key, value) in &found.values {
        assert!(!value.is_null(), "{name}: `{key}` is not finite");
        let Some(number) = value.as_f64() else { continue };
        let Some(statistic) = declared.iter().find(|statistic| statistic.name == key) else {
            panic!("{name}: does not declare its statistic `{key}`");
        };
        match statistic.aggregate {
            Aggregate::Mean => {}
            Aggregate::RootMeanSquare => assert!(number >= 0.0, "{name}: `{key}` is no root mean square: {number}"),
            Aggregate::None => assert!(value.is_u64(), "{name}: `{key}` is no number of a thing: {number}"),
        }
    }
}

fn gives_a_field_of_the_mesh(name: &str, measured: &Measured, count: usize) {
    let field = measured.field.len();
    assert!(field == 0 || field == count, "{name}: a field of {field} values for {count} vertices");
    assert!(measured.field.iter().all(|x| x.is_nan() || *x >= 0.0), "{name}: a field with negative values");
    assert!(field == 0 || measured.field_high > 0.0, "{name}: a field without `field_high`");
}

fn bits(field: &[f64]) -> Vec<u64> {
    field.iter().map(|x| x.to_bits()).collect()
}

fn exceeds_no_limit_at_rest(name: &str, stage: &dyn Metric, scene: &Scene) {
    let rest = &scene.surface.positions;
    let input = MetricInput { before: [frame(rest); 2], ..scene.input(rest, rest, rest) };
    let measured = expect(name, scene.bind(name, stage).measure(input));
    for statistic in stage.statistics() {
        let Some(limits) = statistic.limits else { continue };
        let found = measured.statistics.number(statistic.name).unwrap_or(0.0);
        assert!(found.abs() <= limits.doubtful, "{name}: `{}` is {found} where nothing has moved", statistic.name);
    }
}

fn refuses_other_counts(name: &str, stage: &dyn Metric, scene: &Scene) {
    let all = scene.ground_truth.as_slice();
    let good = scene.input(all, all, all);
    let (short, short_mesh) = (Posed::without_seams(&all[1..]), Posed { mesh: &all[1..], surface: all });
    let short_surface = Posed { mesh: all, surface: &all[1..] };
    let bound = scene.bind(name, stage);
    for short in [short, short_mesh, short_surface] {
        let input = MetricInput { result: short, ..good };
        assert!(bound.measure(input).is_err(), "{name}: takes a result with a vertex too few");
        let input = MetricInput { ground_truth: Some(short), ..good };
        assert!(bound.measure(input).is_err(), "{name}: takes a ground truth with a vertex too few");
    }
    let input = MetricInput { source: Some(&all[1..]), ..good };
    assert!(bound.measure(input).is_err(), "{name}: takes a source with a vertex too few");
}

fn ignores_a_rigid_motion(name: &str, stage: &dyn Metric) {
    let scene = Scene::new(bent_bar());
    let bound = scene.bind(name, stage);
    let result = scene.noisy(2, 0.02);
    let turn = Rotation3::new(Vector3::new(0.3, -0.2, 0.5));
    let moved = |all: &[Point3<f64>]| -> Vec<Point3<f64>> {
        all.iter().map(|p| turn * p + Vector3::new(3.0, -1.0, 2.0)).collect()
    };
    let measure = |result: &[Point3<f64>], ground_truth: &[Point3<f64>], before: [&[Point3<f64>]; 2]| {
        let input = MetricInput { before: before.map(frame), ..scene.input(result, ground_truth, ground_truth) };
        expect(name, bound.measure(input)).statistics
    };
    let (truth, before, rest) = (&scene.ground_truth, &scene.before, &scene.surface.positions);
    let here = measure(&result, truth, [before, rest]);
    let there = measure(&moved(&result), &moved(truth), [&moved(before), &moved(rest)]);
    assert!(here.values.keys().eq(there.values.keys()), "{name}: other statistics after a rigid motion");
    for key in here.values.keys() {
        let (Some(a), Some(b)) = (here.number(key), there.number(key)) else { continue };
        // Moving by some sizes of the mesh costs a digit or two, which ill-shaped triangles may magnify.
        assert!((a - b).abs() <= 1e-6 * (1.0 + a.abs()), "{name}: `{key}` is {a}, and {b} after a rigid motion");
    }
}
