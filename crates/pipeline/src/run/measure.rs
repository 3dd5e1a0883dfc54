//! Measuring posed targets, and their pictures.

use mimesh_core::{
    Result,
    stage::{Frame, MetricInput, Posed},
};
use nalgebra::Point3;

use crate::{
    cache::{PoseCache, PosedTarget},
    input::Prepared,
    metrics::{MEASURED_BEFORE, MetricSet, PoseMetrics, Reason},
    pictures::{PoseView, Thumbnails},
    report::PoseReport,
};

/// Measures the poses of a run.
pub(super) struct Measurer<'a> {
    /// The pipeline.
    pub prepared: &'a Prepared,
    /// The metrics.
    pub metrics: &'a MetricSet<'a>,
    /// The cached measurements of the poses that have some, by their places in the order of the run.
    pub measured: &'a [Option<PoseMetrics>],
    /// The pictures, if any are wanted.
    pub thumbnails: Option<&'a Thumbnails<'a>>,
}

/// A pose that has been transferred.
pub(super) struct PosedPose {
    /// The target for the vertices of its mesh.
    pub target: PosedTarget,
    /// The target for the vertices of its surface as stages see it; empty where nothing is measured.
    pub surface: Vec<Point3<f64>>,
    /// Whether the result was cached by an earlier run.
    pub reused: bool,
    /// The source, for the vertices of its surface; only where something is measured against it.
    pub source: Option<Vec<Point3<f64>>>,
}

impl PosedPose {
    /// The target in both numberings.
    pub fn posed(&self) -> Posed<'_> {
        Posed { mesh: &self.target.positions, surface: &self.surface }
    }

    /// The pose as one before another.
    pub fn frame(&self) -> Frame<'_> {
        Frame { result: self.posed(), source: self.source.as_deref() }
    }
}

impl Measurer<'_> {
    /// Whether the pose at `place`, or one after that looks at it, is measured and not only looked up.
    pub fn is_measuring(&self, place: usize) -> bool {
        let mut places = place..=place + MEASURED_BEFORE;
        places.any(|place| self.measured.get(place).is_some_and(Option::is_none))
    }

    /// Whether metrics or pictures ask for the posed source at `place`.
    pub fn wants_source(&self, place: usize) -> bool {
        self.is_measuring(place) && (self.metrics.needs_source() || self.thumbnails.is_some())
    }

    /// Measures pose `i`, which is at `place`, against the ground truth too if that is known.
    pub fn measure(
        &self,
        [i, place]: [usize; 2],
        posed: &PosedPose,
        before: [Option<Frame<'_>>; 2],
        cache: Option<PoseCache<'_>>,
        report: &mut PoseReport,
    ) {
        if let Some(measured) = &self.measured[place] {
            return self.record(measured, report);
        }
        let target = &self.prepared.target;
        let mut unreadable = false;
        let positions = self.ground_truth(i, &report.name).unwrap_or_else(|error| {
            // Metrics that need no ground truth are measured all the same.
            report.figures.warn(format!("not scored: {error}"));
            unreadable = true;
            None
        });
        let ground_truth = positions.as_ref().map(|[mesh, surface]| Posed { mesh, surface });
        let source = posed.source.as_deref();
        let (result, wants_field) = (posed.posed(), self.thumbnails.is_some());
        let measurements = self.metrics.measure(MetricInput { result, ground_truth, source, before, wants_field });
        let mut metrics = measurements.metrics();
        if let Some(ground_truth) = ground_truth {
            let rest = Posed { mesh: &target.sequence.rest.positions, surface: &target.seen_surface().positions };
            let input = MetricInput { wants_field: false, ..MetricInput::against(rest, ground_truth) };
            let baseline = self.metrics.measure_against_ground_truth(input);
            metrics.rest_baseline = baseline.statistics();
        }
        if let Some(cache) = cache.filter(|_| !unreadable) {
            cache.put_metrics(i, &metrics);
        }
        self.record(&metrics, report);
        if unreadable {
            let missing = self.metrics.names_with_ground_truth().map(|metric| (metric.to_owned(), String::new()));
            metrics.failed.extend(missing);
            let verdict = self.metrics.verdict(&metrics).unwrap_or_default();
            report.verdict = Some(verdict.with(Reason::unscored()));
        }
        if let Some(thumbnails) = self.thumbnails {
            let result = target.mirrored_positions(posed.surface.clone());
            let view = PoseView {
                name: &report.name,
                source,
                result: &result,
                measurements: &measurements,
                verdict: report.verdict.as_ref(),
                limit_ratio: self.metrics.limit_ratio(&metrics),
            };
            tracing::debug_span!("pictures").in_scope(|| thumbnails.add(i, &view));
        }
    }

    /// The known positions of pose `i` for the vertices of the target's mesh and of its surface; `None` if they are not known.
    fn ground_truth(&self, i: usize, name: &str) -> Result<Option<[Vec<Point3<f64>>; 2]>> {
        let Prepared { truth, formats, target, .. } = self.prepared;
        let Some(mesh) = truth.positions(i, name, &target.sequence.rest, formats)? else { return Ok(None) };
        let surface = target.mirrored_positions(target.surface.from_mesh(&mesh)?);
        Ok(Some([mesh, surface]))
    }

    /// Puts measurements and their verdict into the report of a pose.
    fn record(&self, metrics: &PoseMetrics, report: &mut PoseReport) {
        for (metric, error) in &metrics.failed {
            report.figures.warn(format!("metric {metric}: {error}"));
        }
        report.verdict = self.metrics.verdict(metrics);
        report.rest_verdict = self.metrics.rest_verdict(metrics);
        report.metrics = metrics.statistics.clone().into();
        report.rest_baseline = metrics.rest_baseline.clone().into();
    }
}
