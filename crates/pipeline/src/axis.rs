//! Axes of the coordinates.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// An axis of the coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Axis {
    /// The first coordinate.
    X,
    /// The second coordinate.
    Y,
    /// The third coordinate.
    Z,
}

impl Axis {
    /// All axes, by number.
    pub const ALL: [Self; 3] = [Self::X, Self::Y, Self::Z];

    /// Its number: 0 to 2.
    pub fn index(self) -> usize {
        self as usize
    }

    /// Its name, as in YAML.
    pub fn name(self) -> &'static str {
        ["x", "y", "z"][self.index()]
    }
}
