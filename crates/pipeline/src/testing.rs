//! Small stages for the unit tests of pipelines.

use mimesh_core::{
    Error, Figures, Result, register,
    stage::{BindInput, BoundTransfer, Correspondence, Transfer, TransferPair, Transferred, TriangleMap},
};
use nalgebra::Point3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

register!(Correspondence: TestCorrespondence);
register!(Transfer: TestTransfer);
register!(Transfer: TestForeign);

/// Pairs triangles by number.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct TestCorrespondence {
    /// How many markers it asks for.
    pub needs: usize,
}

#[typetag::serde(name = "test_correspondence")]
impl Correspondence for TestCorrespondence {
    fn correspond(&self, pair: TransferPair<'_>) -> Result<TriangleMap> {
        let count = pair.source.triangle_count();
        let whole = |t: u32| Some(t.min(count as u32 - 1));
        let partners = (0..pair.target.triangle_count() as u32).map(whole).collect();
        Ok(TriangleMap { source_triangle_count: count, triangles: partners, ..TriangleMap::default() })
    }

    fn markers_needed(&self) -> usize {
        self.needs
    }
}

/// Gives each target vertex the position of the source vertex of its number.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct TestTransfer {
    /// A factor on positions.
    #[schemars(range(min = 0.0))]
    pub strength: f64,
}

#[typetag::serde(name = "test_transfer")]
impl Transfer for TestTransfer {
    fn bind(&self, input: BindInput<'_>) -> Result<Box<dyn BoundTransfer>> {
        Ok(Box::new(Bound { count: input.pair.target.vertex_count() }))
    }
}

/// A transfer that is written elsewhere, and perhaps around another one.
#[derive(Debug, Default, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct TestForeign {
    /// Its name there.
    pub class: String,
    /// Its settings there.
    pub settings: serde_json::Map<String, serde_json::Value>,
}

#[typetag::serde(name = "test_foreign")]
impl Transfer for TestForeign {
    fn bind(&self, input: BindInput<'_>) -> Result<Box<dyn BoundTransfer>> {
        TestTransfer::default().bind(input)
    }
}

#[derive(Debug)]
struct Bound {
    count: usize,
}

impl BoundTransfer for Bound {
    fn transfer(&self, posed: &[Point3<f64>]) -> Result<Transferred> {
        Error::check_shape("posed source vertices (#V)", self.count, posed.len())?;
        Ok(Transferred { positions: posed.to_vec(), figures: Figures::default() })
    }

    fn figures(&self) -> Figures {
        Figures::default()
    }
}
