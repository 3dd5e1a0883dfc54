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
    /// Whether triangles count by area in E1 and E2, so that results depend neither on how finely a region is meshed nor on the
    /// unit of the file. `false` for the paper, whose eqs. 6 and 7 count all the same.
    pub areas: bool,
    /// Weight of a pair of two neighbouring orphans in E2, beside that of an orphan and a neighbour that corresponds. 2 for the
    /// paper, whose eq. 7 counts such a pair from both sides.
    #[schemars(range(min = 1e-12))]
    pub orphan_pairs: f64,
}

impl TermWeights {
    /// The weight of a triangle in E1 but for w1.
    pub fn of_triangle(&self, area: f64) -> f64 {
        if self.areas { area } else { 1.0 }
    }

    /// The weight of two neighbours in E2 but for w2.
    pub fn of_pair(&self, areas: [f64; 2], both_are_orphans: bool) -> f64 {
        self.of_triangle((areas[0] + areas[1]) / 2.0) * if both_are_orphans { self.orphan_pairs } else { 1.0 }
    }
}

impl Default for TermWeights {
    fn default() -> Self {
        Self { gradient: 1.0, smoothness: 1.0, gaps: 0.1, details: 1.0, prior: 3.0, areas: true, orphan_pairs: 1.0 }
    }
}
