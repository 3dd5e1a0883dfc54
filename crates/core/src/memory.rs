//! How much memory the process may take: what needs much of it asks before it allocates.
//!
//! The program around the library sets limits and says how much is in use, by [`set_limits`]; without one, all is granted. What is
//! asked for is not counted afterwards: the system knows what is in use.

use std::sync::{PoisonError, RwLock};

use crate::{Error, Result};

/// Less than this is not asked for, so that small work pays nothing.
const SMALL: u64 = 1 << 20;

/// A limit on what the process has.
#[derive(Clone, Copy, Debug)]
pub struct Limit {
    /// The most that the process may have, in bytes.
    pub bytes: u64,
    /// What counts for this limit and is in use now, if the system tells.
    pub used: fn() -> Option<u64>,
}

static LIMITS: RwLock<Vec<Limit>> = RwLock::new(Vec::new());

/// Holds the process to all of `limits`, in place of those before.
pub fn set_limits(limits: Vec<Limit>) {
    *LIMITS.write().unwrap_or_else(PoisonError::into_inner) = limits;
}

/// Asks for `bytes` that `what`, in words, will have at once beside what is in use.
///
/// # Errors
///
/// [`Error::Memory`] if that is more than the process may have.
pub fn need(what: impl Into<String>, bytes: u64) -> Result<()> {
    if bytes < SMALL {
        return Ok(());
    }
    for limit in &*LIMITS.read().unwrap_or_else(PoisonError::into_inner) {
        let used = (limit.used)().unwrap_or(0);
        if !fits(bytes, used, limit.bytes) {
            return Err(Error::Memory { what: what.into(), needed: bytes, used, limit: limit.bytes });
        }
    }
    Ok(())
}

fn fits(needed: u64, used: u64, limit: u64) -> bool {
    used.saturating_add(needed) <= limit
}

/// The bytes of `count` values of type `T`.
pub fn bytes_of<T>(count: usize) -> u64 {
    (count as u64).saturating_mul(size_of::<T>() as u64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_fits_beside_what_is_in_use_is_granted_and_no_sum_overflows() {
        assert!(fits(3, 4, 7) && !fits(4, 4, 7) && !fits(u64::MAX, 4, 7));
        assert_eq!(bytes_of::<[f64; 3]>(2), 48);
        let error = Error::Memory { what: "it".into(), needed: 2_140_000_000, used: 1, limit: 999_000_000 };
        assert_eq!(error.to_string(), "it would take 2.1 GB of memory beside the 1 MB in use, and 999 MB are allowed");
    }
}
