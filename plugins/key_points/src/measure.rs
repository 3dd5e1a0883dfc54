use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How far poses are missed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Measure {
    /// The mean distance over all poses and vertices.
    #[default]
    Mean,
    /// The Frobenius norm of the distances over the number of vertices, mean over poses (eq. 22 to the letter).
    Frobenius,
}
