use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How the terms of the energy count against each other; the defaults are the paper's.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct TermWeights {
    /// w1: deformation gradients of triangles that correspond.
    #[schemars(range(min = 1e-12))]
    pub gradient: f64,
    /// w2: smoothness of orphan triangles. At 0 they hold their edges at rest, as weakly as will do.
    #[schemars(range(min = 0.0))]
    pub smoothness: f64,
    /// w3: gaps between components, for each pair of vertices.
    #[schemars(range(min = 1e-12))]
    pub gaps: f64,
    /// w4: Laplacian details of orphan components.
    #[schemars(range(min = 0.0))]
    pub details: f64,
    /// w5: how strongly the target is held to `initial`. Detail smaller than about the diagonal over √w5 is as without; at 0 the
    /// steps only start there.
    #[schemars(range(min = 0.0))]
    pub prior: f64,
}

impl Default for TermWeights {
    fn default() -> Self {
        Self { gradient: 1.0, smoothness: 1.0, gaps: 0.1, details: 1.0, prior: 3.0 }
    }
}
