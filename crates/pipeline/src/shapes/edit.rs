//! What becomes of one shape.

use std::sync::Arc;

use serde::Serialize;

use crate::{axis::Axis, input::PoseInput};

/// What becomes of one shape once the target has it.
#[derive(Clone, Debug, PartialEq)]
pub struct ShapeEdit {
    /// It is mirrored along this axis.
    pub mirrored: Option<Axis>,
    /// The part of the target that it may move; all if there is none.
    pub region: Option<Arc<Region>>,
    /// The factor of its motion.
    pub strength: f64,
}

impl Default for ShapeEdit {
    fn default() -> Self {
        Self { mirrored: None, region: None, strength: 1.0 }
    }
}

impl ShapeEdit {
    /// Whether the shape stays as it is.
    pub fn is_none(&self) -> bool {
        self.mirrored.is_none() && self.region.is_none() && self.strength == 1.0
    }
}

/// A part of the target's surface.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub enum Region {
    /// The vertices for which this is `true` (#V).
    Inside(Vec<bool>),
    /// The share of the motion that each vertex takes (#V).
    Shares(Vec<f64>),
    /// What follows a vertex of the source that this pose moves.
    #[serde(skip)]
    MovedBy(PoseInput),
}
