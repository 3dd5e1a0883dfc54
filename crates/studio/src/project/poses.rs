//! Poses of the source that were read lately.

use std::{
    collections::VecDeque,
    sync::{Arc, Mutex, PoisonError},
};

use mimesh_markers::IntoDiagnostic;
use mimesh_pipeline::input::read_pose;
use nalgebra::Point3;

use super::Project;
use crate::error::{ApiError, Result};

/// The most bytes of poses that are held.
const MAX_BYTES: usize = 256 << 20;

/// Poses that were read lately, the latest last.
#[derive(Debug, Default)]
pub struct RecentPoses(Mutex<VecDeque<(usize, Arc<Vec<Point3<f64>>>)>>);

impl Project {
    /// The vertices of the source's file in pose `index`.
    ///
    /// # Errors
    ///
    /// If there is no such pose, or it cannot be read.
    pub fn pose(&self, index: usize) -> Result<Arc<Vec<Point3<f64>>>> {
        let mut recent = self.recent.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(at) = recent.iter().position(|(i, _)| *i == index)
            && let Some(found) = recent.remove(at)
        {
            let posed = found.1.clone();
            recent.push_back(found);
            return Ok(posed);
        }
        drop(recent);
        let pose = self.poses.get(index).ok_or_else(|| ApiError::bad(format!("there is no pose {index}")))?;
        let posed = read_pose(&self.meshes.sides[0], &self.formats, &pose.from);
        let posed = Arc::new(posed.map_err(|error| error.into_diagnostic().doing(format!("pose {}", pose.name)))?);
        let mut recent = self.recent.0.lock().unwrap_or_else(PoisonError::into_inner);
        recent.push_back((index, posed.clone()));
        let most = MAX_BYTES / (24 * posed.len().max(1));
        while recent.len() > most.max(2) {
            recent.pop_front();
        }
        Ok(posed)
    }
}
