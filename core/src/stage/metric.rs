use std::fmt::Debug;

use nalgebra::Point3;

use crate::{Figures, Result, mesh::Mesh};

/// Judges a posed target, against the known result or against its own rest.
///
/// # Contract
///
/// - figures are finite, in percent of the rest diagonal or dimensionless as their doc says;
/// - a result equal to the truth has no error.
#[typetag::serde(tag = "type")]
pub trait Metric: Debug + Send + Sync {
    /// The figures of one pose.
    ///
    /// # Errors
    ///
    /// [`Error::Shape`](crate::Error::Shape) if vertex counts differ.
    fn measure(&self, input: MetricInput<'_>) -> Result<Figures>;
}

/// What a [`Metric`] judges.
#[derive(Clone, Copy, Debug)]
pub struct MetricInput<'a> {
    /// The target at rest.
    pub rest: &'a Mesh,
    /// The result, for the vertices of `rest`.
    pub result: &'a [Point3<f64>],
    /// The known result, for the vertices of `rest`.
    pub truth: &'a [Point3<f64>],
}

crate::stage_kind!(Metric, "metric");
