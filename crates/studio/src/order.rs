//! One order for the steps of several histories, so that undo takes back what was done last, whatever it was.

use std::sync::atomic::{AtomicU64, Ordering};

/// A number that is larger than all before it.
pub fn next() -> u64 {
    static LAST: AtomicU64 = AtomicU64::new(0);
    LAST.fetch_add(1, Ordering::Relaxed) + 1
}
