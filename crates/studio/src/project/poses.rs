//! Reading poses of the source.

use std::sync::Arc;

use mimesh_markers::IntoDiagnostic;
use mimesh_pipeline::input::read_pose;

use super::{recent::Posed, state::Project};
use crate::error::{ApiError, Result};

impl Project {
    /// The vertices of the source's file in pose `index`.
    ///
    /// # Errors
    ///
    /// If there is no such pose, or it cannot be read.
    pub fn pose(&self, index: usize) -> Result<Posed> {
        if let Some(posed) = self.recent.get(index) {
            return Ok(posed);
        }
        let pose = self.poses.get(index).ok_or_else(|| ApiError::bad(format!("there is no pose {index}")))?;
        let posed = read_pose(&self.meshes.sides[0], &self.formats, &pose.from);
        let posed = Arc::new(posed.map_err(|error| error.into_diagnostic().doing(format!("pose {}", pose.name)))?);
        self.recent.put(index, posed.clone());
        Ok(posed)
    }
}
