//! The contract of metrics.

use nalgebra::{Point3, Rotation3, Vector3};

use super::{
    contracts::{bent_bar, one_thread, twisted, with_defects},
    random::Random,
};
use crate::{
    Figures,
    mesh::{Mesh, Surface},
    stage::{Frame, Metric, MetricContext, MetricInput, TransferPair, TriangleMap},
};

/// The contract of [`Metric`], on a sound mesh and on one with defects.
pub fn metric(name: &str, stage: &dyn Metric) {
    for surface in [bent_bar(), with_defects(bent_bar())] {
        let rest = &Mesh::from_triangles(surface.positions.clone(), &surface.triangles);
        let map = itself(&surface);
        let pair = TransferPair { source: &surface, target: &surface, markers: &[], proximity: None };
        let subject = MetricContext { rest, surface: &surface, pair: Some(pair), map: Some(&map) };
        let bound = stage.bind(subject).unwrap_or_else(|error| panic!("{name}: {error}"));
        let truth = twisted(&surface, 0.5);
        let half = twisted(&surface, 0.25);
        let mut random = Random::new(1);
        let noisy: Vec<Point3<f64>> = truth.iter().map(|p| p + random.vector() * 0.05).collect();
        let measure = |result: &[Point3<f64>], truth: &[Point3<f64>], source: &[Point3<f64>]| {
            let frame = |at| Some(Frame { result: at, source: Some(at) });
            let before = [frame(half.as_slice()), frame(surface.positions.as_slice())];
            bound.measure(MetricInput { result, truth: Some(truth), source: Some(source), before })
        };
        for result in [&truth, &noisy, &surface.positions] {
            let run = || measure(result, &truth, &truth).unwrap_or_else(|error| panic!("{name}: {error}"));
            let measured = run();
            is_finite(name, &measured.figures);
            for (key, _) in measured.figures.values.iter().filter(|(_, value)| value.is_number()) {
                assert!(stage.figures().contains(&key.as_str()), "{name}: does not name its figure `{key}`");
            }
            let field = measured.field.len();
            assert!(field == 0 || field == result.len(), "{name}: a field of {field} values for {}", result.len());
            assert!(measured.field.iter().all(|x| x.is_nan() || *x >= 0.0), "{name}: a field with negative values");
            assert!(field == 0 || measured.field_high > 0.0, "{name}: a field without `field_high`");
            let again = one_thread(run);
            assert!(measured.figures == again.figures, "{name}: other figures on one thread");
            let bits = |field: &[f64]| field.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
            assert!(bits(&measured.field) == bits(&again.field), "{name}: another field on one thread");
            assert!(measured.about == again.about, "{name}: about something else on one thread");
        }
        let alone = stage.bind(MetricContext::alone(rest, &surface)).unwrap_or_else(|error| panic!("{name}: {error}"));
        let judged = alone.measure(MetricInput::alone(&truth)).unwrap_or_else(|error| panic!("{name}: {error}"));
        assert!(judged.figures.values.is_empty() || !stage.needs_truth(), "{name}: needs a truth, but has figures");
        is_finite(name, &judged.figures);

        at_rest_nothing_is_wrong(name, stage, subject);
        if stage.needs_truth() {
            let same = measure(&truth, &truth, &truth).unwrap_or_else(|error| panic!("{name}: {error}"));
            for limit in stage.limits() {
                let found = same.figures.number(limit.figure).unwrap_or(0.0);
                // Centroids round.
                assert!(found.abs() <= 1e-9, "{name}: `{}` is {found} where result and truth are one", limit.figure);
            }
        }
        assert!(measure(&truth[1..], &truth, &truth).is_err(), "{name}: takes a result with a vertex too few");
        assert!(measure(&truth, &truth[1..], &truth).is_err(), "{name}: takes a truth with a vertex too few");
        assert!(measure(&truth, &truth, &truth[1..]).is_err(), "{name}: takes a source with a vertex too few");
        let mut broken = truth.clone();
        broken[3].y = f64::NAN;
        // Such a vertex may be refused, or left out; but no figure may hide it as NaN, which JSON has no word for.
        if let Ok(measured) = measure(&broken, &truth, &truth) {
            is_finite(name, &measured.figures);
        }
    }
    a_rigid_motion_changes_nothing(name, stage);
}

/// Every triangle and vertex its own partner.
fn itself(surface: &Surface) -> TriangleMap {
    let count = surface.triangle_count();
    TriangleMap { source_triangles: count, partners: (0..count as u32).map(Some).collect(), ..TriangleMap::default() }
}

fn at_rest_nothing_is_wrong(name: &str, stage: &dyn Metric, subject: MetricContext<'_>) {
    let rest = &subject.rest.positions;
    let frame = Some(Frame { result: rest, source: Some(&subject.surface.positions) });
    let source = Some(subject.surface.positions.as_slice());
    let judged = MetricInput { result: rest, truth: Some(rest), source, before: [frame; 2] };
    let bound = stage.bind(subject).unwrap_or_else(|error| panic!("{name}: {error}"));
    let measured = bound.measure(judged).unwrap_or_else(|error| panic!("{name}: {error}"));
    for limit in stage.limits() {
        assert!(stage.figures().contains(&limit.figure), "{name}: a limit of `{}`, which is no figure", limit.figure);
        assert!(limit.doubtful <= limit.bad, "{name}: limits of `{}` in the wrong order", limit.figure);
        let found = measured.figures.number(limit.figure).unwrap_or(0.0);
        assert!(found.abs() <= limit.doubtful, "{name}: `{}` is {found} where nothing has moved", limit.figure);
    }
}

fn a_rigid_motion_changes_nothing(name: &str, stage: &dyn Metric) {
    let surface = bent_bar();
    let rest = &Mesh::from_triangles(surface.positions.clone(), &surface.triangles);
    let map = itself(&surface);
    let pair = TransferPair { source: &surface, target: &surface, markers: &[], proximity: None };
    let subject = MetricContext { rest, surface: &surface, pair: Some(pair), map: Some(&map) };
    let bound = stage.bind(subject).unwrap_or_else(|error| panic!("{name}: {error}"));
    let truth = twisted(&surface, 0.5);
    let mut random = Random::new(2);
    let result: Vec<Point3<f64>> = truth.iter().map(|p| p + random.vector() * 0.02).collect();
    let turn = Rotation3::new(Vector3::new(0.3, -0.2, 0.5));
    let moved = |all: &[Point3<f64>]| -> Vec<Point3<f64>> {
        all.iter().map(|p| turn * p + Vector3::new(3.0, -1.0, 2.0)).collect()
    };
    let half = twisted(&surface, 0.25);
    let measure = |result: &[Point3<f64>], truth: &[Point3<f64>], before: [&[Point3<f64>]; 2]| {
        let before = before.map(|at| Some(Frame { result: at, source: Some(at) }));
        let judged = MetricInput { result, truth: Some(truth), source: Some(truth), before };
        bound.measure(judged).unwrap_or_else(|error| panic!("{name}: {error}")).figures
    };
    let here = measure(&result, &truth, [&half, &surface.positions]);
    let there = measure(&moved(&result), &moved(&truth), [&moved(&half), &moved(&surface.positions)]);
    assert!(here.values.keys().eq(there.values.keys()), "{name}: other figures after a rigid motion");
    for key in here.values.keys() {
        let (Some(a), Some(b)) = (here.number(key), there.number(key)) else { continue };
        // Moving by some sizes of the mesh costs a digit or two, which ill-shaped triangles may magnify.
        assert!((a - b).abs() <= 1e-6 * (1.0 + a.abs()), "{name}: `{key}` is {a}, and {b} after a rigid motion");
    }
}

fn is_finite(name: &str, figures: &Figures) {
    for (key, value) in &figures.values {
        assert!(!value.is_null(), "{name}: figure `{key}` is not finite");
    }
}
