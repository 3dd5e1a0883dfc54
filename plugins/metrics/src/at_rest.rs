//! Metrics that all poses have the same statistics of.

use std::sync::LazyLock;

use mimesh_core::{
    Result,
    stage::{BoundMetric, Measured, MetricContext, MetricInput},
};

/// What was measured once, at rest, for every pose.
pub struct AtRest<'a> {
    context: MetricContext<'a>,
    /// All but the field.
    measured: Measured,
    field: LazyLock<Vec<f64>, MakeField<'a>>,
}

/// Makes a field for pictures, once one is asked for.
pub type MakeField<'a> = Box<dyn FnOnce() -> Vec<f64> + Send + 'a>;

impl<'a> AtRest<'a> {
    /// `measured` of the meshes of `context`.
    pub fn boxed(context: MetricContext<'a>, measured: Measured) -> Box<dyn BoundMetric + 'a> {
        Self::with_field(context, measured, Box::new(Vec::new))
    }

    /// The same with a field.
    pub fn with_field(
        context: MetricContext<'a>,
        measured: Measured,
        field: MakeField<'a>,
    ) -> Box<dyn BoundMetric + 'a> {
        Box::new(Self { context, measured, field: LazyLock::new(field) })
    }
}

impl BoundMetric for AtRest<'_> {
    fn measure(&self, input: MetricInput<'_>) -> Result<Measured> {
        self.context.check(&input)?;
        let field = if input.wants_field { self.field.clone() } else { vec![] };
        Ok(Measured { field, ..self.measured.clone() })
    }
}
