//! Poses of the source that were read lately.

use std::{
    collections::VecDeque,
    sync::{Arc, Mutex, MutexGuard, PoisonError},
};

use nalgebra::Point3;

/// The most bytes of poses that are held.
const MAX_BYTES: usize = 256 << 20;

/// The vertices of a pose.
pub type Posed = Arc<Vec<Point3<f64>>>;

/// Poses that were read lately, the latest last.
#[derive(Debug, Default)]
pub struct RecentPoses(Mutex<VecDeque<(usize, Posed)>>);

impl RecentPoses {
    /// The pose `index`, if it is there.
    pub fn get(&self, index: usize) -> Option<Posed> {
        let mut recent = self.lock();
        let at = recent.iter().position(|(i, _)| *i == index)?;
        let found = recent.remove(at)?;
        let posed = found.1.clone();
        recent.push_back(found);
        Some(posed)
    }

    /// Takes a pose that was read; the oldest leave when there are too many.
    pub fn put(&self, index: usize, posed: Posed) {
        let most = (MAX_BYTES / (24 * posed.len().max(1))).max(2);
        let mut recent = self.lock();
        recent.retain(|(i, _)| *i != index);
        recent.push_back((index, posed));
        while recent.len() > most {
            recent.pop_front();
        }
    }

    fn lock(&self) -> MutexGuard<'_, VecDeque<(usize, Posed)>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
