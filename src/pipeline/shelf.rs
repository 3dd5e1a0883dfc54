//! Poses that are kept from run to run.

use super::{
    cache::{Cache, Key, Moved, Recipes},
    judge::Said,
};

/// Results of poses that are kept from run to run.
#[derive(Clone, Copy, Debug)]
pub struct Shelf<'a> {
    /// The cache.
    pub cache: &'a Cache,
    /// What the results depend on.
    pub recipes: &'a Recipes,
    /// Whether poses are frames of one motion.
    pub motion: bool,
}

impl Shelf<'_> {
    /// The kept result of pose `i`.
    pub fn get(&self, i: usize) -> Option<Moved> {
        self.cache.get(self.kind(), self.key(i)?)
    }

    /// What metrics said of pose `i`.
    pub fn said(&self, i: usize) -> Option<Said> {
        self.cache.get("judged", self.recipes.judged(i, self.motion)?)
    }

    /// Keeps what metrics said of pose `i`.
    pub fn put_said(&self, i: usize, said: &Said) {
        if let Some(key) = self.recipes.judged(i, self.motion) {
            self.cache.put("judged", key, said);
        }
    }

    /// Keeps the result of pose `i`.
    pub fn put(&self, i: usize, moved: &Moved) {
        if let Some(key) = self.key(i) {
            self.cache.put(self.kind(), key, moved);
        }
    }

    fn kind(&self) -> &'static str {
        if self.motion { "frame" } else { "pose" }
    }

    fn key(&self, i: usize) -> Option<Key> {
        if self.motion { self.recipes.frame(i) } else { self.recipes.pose(i) }
    }
}
