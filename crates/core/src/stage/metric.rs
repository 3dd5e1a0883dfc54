use std::fmt::Debug;

use nalgebra::Point3;

use super::{TransferPair, TriangleMap};
use crate::{
    Error, Figures, Result,
    mesh::{Mesh, Surface},
};

/// Judges a posed target: against the known result, against its own rest, or against what the source did.
///
/// # Contract
///
/// - figures are finite, in percent of the rest diagonal or dimensionless as their doc says;
/// - a result equal to the truth has no error;
/// - source and target at rest break no limit of its own;
/// - one rigid motion of result, truth and source changes no figure beyond rounding;
/// - it gives no number that it does not name before;
/// - a pose that it cannot judge, for want of a truth or a source, has no figures.
#[typetag::serde(tag = "type")]
pub trait Metric: Debug + Send + Sync {
    /// Does once what depends on rest meshes.
    ///
    /// # Errors
    ///
    /// [`Error::Setting`] for settings out of range, [`Error::Data`] for rest meshes that cannot be judged.
    fn bind<'a>(&self, subject: MetricContext<'a>) -> Result<Box<dyn BoundMetric + 'a>>;

    /// Names of its figures that are numbers, the one that says most first; for checks before anything is measured.
    ///
    /// Over poses a figure is averaged: as a root mean square if its name ends with `rms`, not at all if it is `worst`, the number of
    /// a component, a marker or the like.
    fn figures(&self) -> Vec<&'static str>;

    /// What is worth a second look, and what is bad, of its figures.
    fn limits(&self) -> Vec<Limit> {
        vec![]
    }

    /// Whether it says nothing without a known result.
    fn needs_truth(&self) -> bool {
        false
    }

    /// Whether it is measured where a pipeline names no metrics.
    fn by_default(&self) -> bool {
        false
    }
}

crate::stage_kind!(Metric, "metric");

/// What a [`Metric`] is bound to.
#[derive(Clone, Copy, Debug)]
pub struct MetricContext<'a> {
    /// The target at rest.
    pub rest: &'a Mesh,
    /// Its surface.
    pub surface: &'a Surface,
    /// What the target's motion comes from; `None` if only results are known.
    pub pair: Option<TransferPair<'a>>,
    /// Where on the source each part of the target took its motion from, where the method has such a map.
    pub map: Option<&'a TriangleMap>,
}

/// A metric that knows the rest meshes.
pub trait BoundMetric: Send + Sync {
    /// What there is to say of one pose.
    ///
    /// # Errors
    ///
    /// [`Error::Shape`] if vertex counts differ, [`Error::Data`] for what cannot be measured.
    fn measure(&self, pose: MetricInput<'_>) -> Result<Measured>;
}

/// One pose to judge.
#[derive(Clone, Copy, Debug)]
pub struct MetricInput<'a> {
    /// The result, for the vertices of the target's mesh.
    pub result: &'a [Point3<f64>],
    /// The known result, for the vertices of the target's mesh.
    pub truth: Option<&'a [Point3<f64>]>,
    /// The source in this pose, for the vertices of its surface.
    pub source: Option<&'a [Point3<f64>]>,
    /// One and two poses before, in the order of the run, where they did not fail: frames, if the run is a motion. A metric of motions
    /// cannot tell whether it is; it should say nothing alarming of poses that are unrelated.
    pub before: [Option<Frame<'a>>; 2],
}

/// A pose before the one that is judged.
#[derive(Clone, Copy, Debug)]
pub struct Frame<'a> {
    /// The result, for the vertices of the target's mesh.
    pub result: &'a [Point3<f64>],
    /// The source, for the vertices of its surface.
    pub source: Option<&'a [Point3<f64>]>,
}

/// What a metric says of one pose.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Measured {
    /// The figures; none if the pose cannot be judged.
    pub figures: Figures,
    /// Figures that are about one thing among many, and which that is, in words, e.g. `marker 28`.
    pub about: Vec<(&'static str, String)>,
    /// For pictures: how bad each vertex of the target's mesh is (≥ 0, NaN where unknown); empty if that makes no sense.
    pub field: Vec<f64>,
    /// What `field` is, with its unit, in a word or two, e.g. `error, %`.
    pub field_unit: &'static str,
    /// The end of the colours for `field`: a value that is bad.
    pub field_high: f64,
}

/// From where on a figure is bad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limit {
    /// The figure; what counts is its size without its sign.
    pub figure: &'static str,
    /// Above this a person should look.
    pub doubtful: f64,
    /// Above this something is wrong.
    pub bad: f64,
}

impl<'a> MetricContext<'a> {
    /// A target of which nothing but results is known.
    pub fn alone(rest: &'a Mesh, surface: &'a Surface) -> Self {
        Self { rest, surface, pair: None, map: None }
    }

    /// Checks that `pose` has as many vertices as the meshes.
    ///
    /// # Errors
    ///
    /// [`Error::Shape`] that names what differs.
    pub fn check(&self, pose: &MetricInput<'_>) -> Result<()> {
        let count = self.rest.positions.len();
        Error::check_shape("vertices of the result (#V)", count, pose.result.len())?;
        if let Some(truth) = pose.truth {
            Error::check_shape("vertices of the truth (#V)", count, truth.len())?;
        }
        if let (Some(pair), Some(source)) = (self.pair, pose.source) {
            Error::check_shape("vertices of the posed source (#V)", pair.source.vertex_count(), source.len())?;
        }
        for frame in pose.before.iter().flatten() {
            Error::check_shape("vertices of the result before (#V)", count, frame.result.len())?;
            if let (Some(pair), Some(source)) = (self.pair, frame.source) {
                Error::check_shape("vertices of the source before (#V)", pair.source.vertex_count(), source.len())?;
            }
        }
        Ok(())
    }
}

impl<'a> MetricInput<'a> {
    /// A result of which nothing else is known.
    pub fn alone(result: &'a [Point3<f64>]) -> Self {
        Self { result, truth: None, source: None, before: [None; 2] }
    }

    /// A result and what it should be.
    pub fn against(result: &'a [Point3<f64>], truth: &'a [Point3<f64>]) -> Self {
        Self { truth: Some(truth), ..Self::alone(result) }
    }
}
