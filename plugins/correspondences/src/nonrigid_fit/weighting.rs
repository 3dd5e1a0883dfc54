use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How triangles and vertices count in the sums of an energy.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Weighting {
    /// By their share of the area, so that weights mean the same at any resolution.
    #[default]
    Area,
    /// All alike, as the papers print.
    Uniform,
}
