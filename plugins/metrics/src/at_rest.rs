//! Metrics that all poses have the same statistics of.

use mimesh_core::{
    Result,
    stage::{BoundMetric, Measured, MetricContext, MetricInput},
};

/// What was measured once, at rest, for every pose.
pub struct AtRest<'a> {
    context: MetricContext<'a>,
    measured: Measured,
}

impl<'a> AtRest<'a> {
    /// `measured` of the meshes of `context`.
    pub fn boxed(context: MetricContext<'a>, measured: Measured) -> Box<dyn BoundMetric + 'a> {
        Box::new(Self { context, measured })
    }
}

impl BoundMetric for AtRest<'_> {
    fn measure(&self, input: MetricInput<'_>) -> Result<Measured> {
        self.context.check(&input)?;
        Ok(self.measured.clone())
    }
}
