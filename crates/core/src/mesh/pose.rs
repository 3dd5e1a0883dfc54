use std::{borrow::Cow, fmt, sync::Arc};

use nalgebra::Point3;

use crate::Result;

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

/// The positions of a pose: held, or computed or read each time they are asked for.
///
/// Positions that cannot be read equal none.
#[derive(Clone)]
pub enum Positions {
    /// Held in memory.
    Held(Vec<Point3<f64>>),
    /// The pose of this number among those that a file's reader computes.
    Computed(Arc<dyn ComputePoses>, usize),
}

impl Positions {
    /// The positions, #V × 3.
    ///
    /// # Errors
    ///
    /// [`Error::Io`](crate::Error::Io) if they are read from a file that is not there any more, or has changed.
    pub fn get(&self) -> Result<Cow<'_, [Point3<f64>]>> {
        Ok(match self {
            Self::Held(positions) => Cow::Borrowed(positions),
            Self::Computed(poses, index) => Cow::Owned(poses.positions(*index)?),
        })
    }
}

/// Computes or reads poses one by one, so that memory does not grow with their number.
pub trait ComputePoses: Send + Sync {
    /// The positions of pose `index`, #V × 3; the same at every call.
    ///
    /// # Errors
    ///
    /// [`Error::Io`](crate::Error::Io) if they cannot be read.
    fn positions(&self, index: usize) -> Result<Vec<Point3<f64>>>;
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
        matches!((self.get(), other.get()), (Ok(a), Ok(b)) if a == b)
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
