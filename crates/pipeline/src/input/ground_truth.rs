//! The known results of a target.

use std::{collections::HashMap, path::PathBuf};

use mimesh_core::{
    Result,
    mesh::{Mesh, Pose, Positions},
    stage::Selection,
};
use nalgebra::Point3;

use crate::formats::Formats;

/// The known results of a target.
#[derive(Clone, Debug, Default)]
pub enum GroundTruth {
    /// Nothing is known.
    #[default]
    None,
    /// A file a pose.
    Files {
        /// The files, in the order of poses.
        files: Vec<PathBuf>,
        /// The names of the parts of each that are read; all if there is none.
        meshes: Vec<String>,
    },
    /// Positions by the name of the pose.
    Held(HashMap<String, Positions>),
}

impl GroundTruth {
    /// The positions that `poses` hold.
    pub fn held(poses: &[Pose]) -> Self {
        Self::Held(poses.iter().map(|pose| (pose.name.clone(), pose.positions.clone())).collect())
    }

    /// Whether nothing is known.
    pub fn is_none(&self) -> bool {
        matches!(self, Self::None)
    }

    /// The known positions of pose `i`, called `name`, of the target `rest`; `None` if they are not known.
    ///
    /// # Errors
    ///
    /// If its file cannot be read, or is no pose of `rest`.
    pub fn positions(&self, i: usize, name: &str, rest: &Mesh, formats: &Formats) -> Result<Option<Vec<Point3<f64>>>> {
        match self {
            Self::None => Ok(None),
            Self::Held(by_name) => by_name.get(name).map(|positions| Ok(positions.get()?.into_owned())).transpose(),
            Self::Files { files, meshes } => match formats.reader(&files[i]) {
                Ok(_) => {
                    let selection = Selection { meshes: meshes.clone(), ..Selection::default() };
                    formats.read_pose(&files[i], &selection, rest).map(Some)
                }
                Err(_) => Ok(None),
            },
        }
    }
}
