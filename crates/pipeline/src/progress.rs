//! What a run reports while it is under way.

/// Receives the progress of a run.
pub trait Progress: Sync {
    /// A stage begins, e.g. `correspondence (nonrigid_fit)`.
    fn stage(&self, _name: &str) {}

    /// The poses begin; there are `count`.
    fn poses(&self, _count: usize) {}

    /// A pose is done, or has failed.
    fn pose_done(&self) {}
}
