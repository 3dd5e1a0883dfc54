use std::fmt::Debug;

use nalgebra::Point3;

use super::{Statistic, TransferPair, TriangleMap};
use crate::{
    Error, Figures, Result,
    mesh::{Mesh, Surface},
};

/// Measures a posed target against the known result, against its own rest or against the motion of the source.
///
/// # Contract
///
/// - every number that it gives is finite and declared in [`statistics`](Metric::statistics);
/// - lengths are in percent of the diagonal at rest, so that no statistic depends on the unit of the files;
/// - a result equal to the ground truth has no error;
/// - source and target at rest exceed none of its own limits;
/// - one rigid motion of result, ground truth and source changes no statistic beyond rounding;
/// - a pose that it cannot measure, for want of a ground truth or a source, has no statistics.
#[typetag::serde(tag = "type")]
pub trait Metric: Debug + Send + Sync {
    /// Does once the work that depends on rest meshes alone.
    ///
    /// # Errors
    ///
    /// [`Error::Setting`] for settings out of range, [`Error::Data`] for rest meshes that cannot be measured.
    fn bind<'a>(&self, context: MetricContext<'a>) -> Result<Box<dyn BoundMetric + 'a>>;

    /// The numbers that it can give of a pose, the primary one first.
    ///
    /// Gates, tables over poses and verdicts are made from this declaration. A list of numbers, such as a curve, needs none: it is
    /// averaged over poses number by number.
    fn statistics(&self) -> Vec<Statistic>;

    /// What is wrong where a statistic is above its limit, and what helps, in the words of someone who looks at the result; empty if the
    /// names of the statistics say it.
    fn fault(&self) -> &'static str {
        ""
    }

    /// Whether it gives no statistics without a known result.
    fn needs_ground_truth(&self) -> bool {
        false
    }

    /// Whether it gives no statistics without a triangle map.
    fn needs_map(&self) -> bool {
        false
    }

    /// Whether it is measured where a pipeline names no metrics.
    fn by_default(&self) -> bool {
        false
    }

    /// Whether it looks at rest meshes, markers and the map alone, so that all poses have the same statistics.
    ///
    /// Its faults are then reported once for the run, and not with every pose.
    fn is_of_rest(&self) -> bool {
        false
    }
}

crate::stage_kind!(Metric, "metric");

/// The meshes at rest that a [`Metric`] is bound to.
#[derive(Clone, Copy, Debug)]
pub struct MetricContext<'a> {
    /// The target at rest.
    pub rest: &'a Mesh,
    /// The surface of `rest`.
    pub surface: &'a Surface,
    /// Source, target and markers of the transfer; `None` if only results are known.
    pub pair: Option<TransferPair<'a>>,
    /// The points of the source that parts of the target take their motion from; `None` if the method has no such map.
    pub map: Option<&'a TriangleMap>,
}

/// A metric that knows the rest meshes.
pub trait BoundMetric: Send + Sync {
    /// Measures one pose.
    ///
    /// # Errors
    ///
    /// [`Error::Shape`] if vertex counts differ, [`Error::Data`] for positions that cannot be measured.
    fn measure(&self, input: MetricInput<'_>) -> Result<Measured>;
}

/// The target in one pose, in the numbering of its file and in that of its surface.
#[derive(Clone, Copy, Debug)]
pub struct Posed<'a> {
    /// Positions of the vertices of the target's mesh.
    pub mesh: &'a [Point3<f64>],
    /// The same positions for the vertices of its surface (#V), as [`Surface::from_mesh`] gives them.
    pub surface: &'a [Point3<f64>],
}

/// One pose to measure.
#[derive(Clone, Copy, Debug)]
pub struct MetricInput<'a> {
    /// The result.
    pub result: Posed<'a>,
    /// The known result.
    pub ground_truth: Option<Posed<'a>>,
    /// The source in this pose: positions of the vertices of its surface.
    pub source: Option<&'a [Point3<f64>]>,
    /// One and two poses before, in the order of the run; `None` where they failed or there are none.
    ///
    /// They are frames if the run is a motion. A metric of motions cannot know that, so it must not alarm where poses are
    /// unrelated.
    pub before: [Option<Frame<'a>>; 2],
    /// Whether [`Measured::field`] is looked at; a metric may leave it empty where it is not.
    pub wants_field: bool,
}

/// A pose before the one that is measured.
#[derive(Clone, Copy, Debug)]
pub struct Frame<'a> {
    /// The result.
    pub result: Posed<'a>,
    /// The source: positions of the vertices of its surface.
    pub source: Option<&'a [Point3<f64>]>,
}

/// Statistics of one pose.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Measured {
    /// The values of the declared statistics; none if the pose cannot be measured.
    pub statistics: Figures,
    /// Statistics that belong to one thing among many, with the name of that thing, e.g. `marker 28`.
    pub about: Vec<(&'static str, String)>,
    /// For pictures: the error at each vertex of the target's mesh (≥ 0, NaN where unknown); empty if that makes no sense, or is not
    /// asked for.
    pub field: Vec<f64>,
    /// Name and unit of `field` in a word or two, e.g. `error, %`.
    pub field_unit: &'static str,
    /// The value of `field` at the end of the colour scale.
    pub field_high: f64,
}

impl<'a> MetricContext<'a> {
    /// A target of which nothing but results is known.
    pub fn alone(rest: &'a Mesh, surface: &'a Surface) -> Self {
        Self { rest, surface, pair: None, map: None }
    }

    /// The target at rest, as a pose of itself.
    pub fn at_rest(&self) -> Posed<'a> {
        Posed { mesh: &self.rest.positions, surface: &self.surface.positions }
    }

    /// Checks that `input` has as many vertices as the meshes.
    ///
    /// # Errors
    ///
    /// [`Error::Shape`] that names the positions whose count differs.
    pub fn check(&self, input: &MetricInput<'_>) -> Result<()> {
        self.check_target("vertices of the result (#V)", input.result)?;
        if let Some(ground_truth) = input.ground_truth {
            self.check_target("vertices of the truth (#V)", ground_truth)?;
        }
        self.check_source("vertices of the posed source (#V)", input.source)?;
        for frame in input.before.iter().flatten() {
            self.check_target("vertices of the result before (#V)", frame.result)?;
            self.check_source("vertices of the source before (#V)", frame.source)?;
        }
        Ok(())
    }

    fn check_target(&self, what: &'static str, posed: Posed<'_>) -> Result<()> {
        Error::check_shape(what, self.rest.positions.len(), posed.mesh.len())?;
        Error::check_shape(what, self.surface.vertex_count(), posed.surface.len())
    }

    fn check_source(&self, what: &'static str, posed: Option<&[Point3<f64>]>) -> Result<()> {
        let (Some(pair), Some(posed)) = (self.pair, posed) else { return Ok(()) };
        Error::check_shape(what, pair.source.vertex_count(), posed.len())
    }
}

impl<'a> Posed<'a> {
    /// Positions of a mesh without seams, whose surface has the same vertices.
    pub fn without_seams(positions: &'a [Point3<f64>]) -> Self {
        Self { mesh: positions, surface: positions }
    }
}

impl<'a> MetricInput<'a> {
    /// A result of which nothing else is known, with a field.
    pub fn alone(result: Posed<'a>) -> Self {
        Self { result, ground_truth: None, source: None, before: [None; 2], wants_field: true }
    }

    /// A result and the positions that it should have.
    pub fn against(result: Posed<'a>, ground_truth: Posed<'a>) -> Self {
        Self { ground_truth: Some(ground_truth), ..Self::alone(result) }
    }
}
