use std::{borrow::Cow, fmt, sync::Arc};

use nalgebra::Point3;

/// A posed mesh: positions for the vertices of a rest mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Pose {
    /// The name: of the file without extension, of the morph target, or of the clip with the number of the frame.
    pub name: String,
    /// The time in a clip, if it is a frame of one.
    pub time: Option<ClipTime>,
    /// Posed V.
    pub positions: Positions,
}

impl Pose {
    /// A pose that belongs to no clip, with `positions` (#V × 3).
    pub fn new(name: impl Into<String>, positions: Vec<Point3<f64>>) -> Self {
        Self { name: name.into(), time: None, positions: positions.into() }
    }
}

/// A time in a clip.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ClipTime {
    /// The clip's name.
    pub clip: String,
    /// Seconds from the clip's start.
    pub seconds: f64,
}

/// The positions of a pose: held, or computed each time they are asked for.
#[derive(Clone)]
pub enum Positions {
    /// Held in memory.
    Held(Vec<Point3<f64>>),
    /// The pose of this number among those that a file's reader computes.
    Computed(Arc<dyn ComputePoses>, usize),
}

impl Positions {
    /// The positions, #V × 3.
    pub fn get(&self) -> Cow<'_, [Point3<f64>]> {
        match self {
            Self::Held(positions) => Cow::Borrowed(positions),
            Self::Computed(poses, index) => Cow::Owned(poses.positions(*index)),
        }
    }
}

/// Computes poses one by one, so that memory does not grow with their number.
pub trait ComputePoses: Send + Sync {
    /// The positions of pose `index`, #V × 3; the same at every call.
    fn positions(&self, index: usize) -> Vec<Point3<f64>>;
}

impl Default for Positions {
    fn default() -> Self {
        Self::Held(Vec::new())
    }
}

impl From<Vec<Point3<f64>>> for Positions {
    fn from(positions: Vec<Point3<f64>>) -> Self {
        Self::Held(positions)
    }
}

impl PartialEq for Positions {
    fn eq(&self, other: &Self) -> bool {
        self.get() == other.get()
    }
}

impl fmt::Debug for Positions {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Held(positions) => f.debug_tuple("Held").field(positions).finish(),
            Self::Computed(_, index) => f.debug_tuple("Computed").field(index).finish(),
        }
    }
}
