//! What a page looks at.

use std::sync::Arc;

use nalgebra::Point3;
use serde::{Deserialize, Serialize};

use crate::{
    error::{ApiError, Result},
    markers::{Point, Side},
    project::Project,
};

/// The most shapes that are blended.
const MAX_BLEND: usize = 1_000;

/// A message of the page.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(tag = "type", rename_all = "snake_case", deny_unknown_fields)]
pub enum ToServer {
    /// What the page shows now.
    Look(Look),
    /// A point under the cursor.
    Drag(Drag),
}

/// What a page shows.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Look {
    /// Rises with every look.
    pub look: u64,
    /// The pose.
    pub pose: PoseRef,
    /// The meshes.
    pub channels: Vec<Channel>,
    /// The colour map.
    #[serde(default)]
    pub scalar: Option<String>,
    /// Whether results of all frames are to be computed ahead, to be played.
    #[serde(default)]
    pub ahead: bool,
}

/// A point that is dragged; it changes no document.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Drag {
    /// Rises with every drag.
    pub drag: u64,
    /// The pair.
    pub pair: u64,
    /// The side.
    pub side: Side,
    /// Where it is; `None` when the drag has ended.
    pub point: Option<Point>,
}

/// A pose, a blend of poses, or the rest.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(untagged)]
pub enum PoseRef {
    /// One of the poses.
    Index {
        /// Its place.
        index: usize,
    },
    /// Rest + Σ weight × (pose − rest).
    Blend {
        /// Places and weights.
        blend: Vec<(usize, f64)>,
    },
    /// The rest.
    #[default]
    Rest,
}

/// A mesh in a pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Channel {
    /// The source.
    Source,
    /// The target by the fast preview.
    Preview,
    /// The target by the pipeline's own transfer.
    Result,
    /// The known result.
    Truth,
}

impl PoseRef {
    /// The place of the pose, if it is one.
    pub fn index(&self) -> Option<usize> {
        match self {
            Self::Index { index } => Some(*index),
            _ => None,
        }
    }

    /// Whether `project` has all poses of it.
    ///
    /// # Errors
    ///
    /// If it has not, and for weights that are not finite.
    pub fn check(&self, project: &Project) -> Result<()> {
        let count = project.poses.len();
        let named: Vec<(usize, f64)> = match self {
            Self::Rest => vec![],
            Self::Index { index } => vec![(*index, 1.0)],
            Self::Blend { blend } => blend.clone(),
        };
        if named.len() > MAX_BLEND {
            return Err(ApiError::bad(format!("a blend of {} poses, expected at most {MAX_BLEND}", named.len())));
        }
        match named.iter().find(|(i, weight)| *i >= count || !weight.is_finite()) {
            Some((i, _)) => {
                Err(ApiError::bad(format!("there is no pose {i}: {count} are there, or its weight is not finite")))
            }
            None => Ok(()),
        }
    }
}

impl Project {
    /// The vertices of the source's file in a pose.
    ///
    /// # Errors
    ///
    /// If a pose cannot be read.
    pub fn source_at(&self, pose: &PoseRef) -> Result<Arc<Vec<Point3<f64>>>> {
        pose.check(self)?;
        let rest = &self.meshes.sides[0].sequence.rest.positions;
        match pose {
            PoseRef::Rest => Ok(Arc::new(rest.clone())),
            PoseRef::Index { index } => self.pose(*index),
            PoseRef::Blend { blend } => {
                let mut sum = rest.clone();
                for (index, weight) in blend.iter().filter(|(_, weight)| *weight != 0.0) {
                    let posed = self.pose(*index)?;
                    sum.iter_mut()
                        .zip(rest)
                        .zip(&*posed)
                        .for_each(|((sum, rest), posed)| *sum += (posed - rest) * *weight);
                }
                Ok(Arc::new(sum))
            }
        }
    }
}
