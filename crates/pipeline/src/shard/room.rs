//! Room in the cache for all poses of runs that are split.

use mimesh_core::memory::bytes_of;
use mimesh_document::{Diagnostic, Kind};

use crate::{cache::Cache, input::Prepared, text};

/// Remedy: let the cache grow; the argument is its new limit in megabytes.
pub const LARGER_CACHE: &str = "larger_cache";

/// The part of the cache's limit that poses may fill: other results are there too, and a clean-up leaves less than the limit.
const SHARE: f64 = 0.8;

/// Checks that the poses of `runs` stay in `cache` until a merge takes them: beyond its limit the longest unused are removed.
///
/// # Errors
///
/// [`Kind::Usage`] if they do not fit, and files of all poses are to be made of them.
pub fn check_room(runs: &[Prepared], cache: &Cache) -> Result<(), Diagnostic> {
    let merged = runs.iter().filter(|run| !run.outputs.files_of_all().is_empty());
    let bytes = |run: &Prepared| bytes_of::<[f64; 3]>(run.poses.len() * run.target.sequence.rest.positions.len());
    let needed: u64 = merged.map(bytes).sum();
    if needed as f64 <= SHARE * cache.store.limit() as f64 {
        return Ok(());
    }
    let message = format!(
        "all poses together take {} in the cache, which may grow to {}: the first would be gone before the last are there",
        text::bytes(needed),
        text::bytes(cache.store.limit())
    );
    let megabytes = (needed as f64 / SHARE / f64::from(1 << 20)).ceil() as u64;
    Err(Diagnostic::new(Kind::Usage, message).remedy(LARGER_CACHE, megabytes.to_string(), "let it grow"))
}
