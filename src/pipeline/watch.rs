/// Is told how a run gets on.
pub trait Watch: Sync {
    /// A stage begins, e.g. `correspondence (nonrigid_fit)`.
    fn stage(&self, _what: &str) {}

    /// The poses begin; there are `count`.
    fn poses(&self, _count: usize) {}

    /// A pose is done, or has failed.
    fn pose_done(&self) {}
}

/// Tells nobody.
#[derive(Clone, Copy, Debug, Default)]
pub struct Unwatched;

impl Watch for Unwatched {}
