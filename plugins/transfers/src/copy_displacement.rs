//! Copies displacements, as a baseline.

use mimesh_core::{
    Error, Figures, Result,
    mesh::{Surface, SurfacePoint, check_finite},
    register,
    spatial::{Orientation, Similarity},
    stage::{BindInput, BoundTransfer, Transfer, Transferred},
};
use nalgebra::Point3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{alignment::Alignment, gradient::figures};

register!(Transfer: CopyDisplacement);

/// Adds to each target vertex the displacement of its source point, turned and scaled to the target: x̃ = x + s R (ũ − u).
///
/// Most tools do this. It is fine for small shapes such as wrinkles; it stretches and shears what rotates. A baseline to
/// compare with, for targets of any number of components.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct CopyDisplacement {
    /// How source and target are turned to each other at rest.
    pub orientation: Orientation,
}

#[typetag::serde(name = "copy_displacement")]
impl Transfer for CopyDisplacement {
    fn bind(&self, input: BindInput<'_>) -> Result<Box<dyn BoundTransfer>> {
        let (pair, map) = (input.pair, input.require_map()?);
        let points = map.source_points(pair)?;
        let alignment = Alignment::new(pair, map, self.orientation);
        Ok(Box::new(Bound {
            source: pair.source.clone(),
            rest: pair.target.positions.clone(),
            points,
            target_from_source: alignment.target_from_source,
            figures: figures(&alignment),
        }))
    }
}

#[derive(Debug)]
struct Bound {
    source: Surface,
    rest: Vec<Point3<f64>>,
    points: Vec<SurfacePoint>,
    target_from_source: Similarity,
    figures: Figures,
}

impl BoundTransfer for Bound {
    fn transfer(&self, posed: &[Point3<f64>]) -> Result<Transferred> {
        Error::check_shape("posed source vertices (#V)", self.source.vertex_count(), posed.len())?;
        check_finite(posed)?;
        let Similarity { scale, rotation, .. } = self.target_from_source;
        let moved = |(rest, point): (&Point3<f64>, &SurfacePoint)| {
            let displacement =
                point.position(&self.source, posed) - point.position(&self.source, &self.source.positions);
            rest + rotation * displacement * scale
        };
        let positions: Vec<_> = self.rest.iter().zip(&self.points).map(moved).collect();
        check_finite(&positions)?;
        Ok(Transferred { positions, figures: Figures::default() })
    }

    fn figures(&self) -> Figures {
        self.figures.clone()
    }
}
