//! Room in the cache for all poses of runs that are split.

use mimesh_core::memory::bytes_of;
use mimesh_document::{Diagnostic, Kind};

use crate::{cache::Cache, input::Prepared, text};

/// Remedy: let the cache grow; the argument is its new limit in megabytes.
pub const LARGER_CACHE: &str = "larger_cache";

/// The part of the cache's limit that poses may fill: other results are there too, and a clean-up leaves less than the limit.
const SHARE: f64 = 0.8;

/// The limit in megabytes within which the cache keeps all poses of `runs` until a merge takes them.
pub fn megabytes_of_poses<'a>(runs: impl IntoIterator<Item = &'a Prepared>) -> u64 {
    megabytes_for(runs.into_iter().map(bytes_of_poses).sum())
}

/// The bytes that the poses of a run take in the cache.
pub fn bytes_of_poses(run: &Prepared) -> u64 {
    bytes_of::<[f64; 3]>(run.poses.len() * run.target.sequence.rest.positions.len())
}

fn megabytes_for(bytes: u64) -> u64 {
    (bytes as f64 / SHARE / f64::from(1 << 20)).ceil() as u64
}

/// Checks that the poses of `runs` stay in `cache` until a merge takes them: beyond its limit the longest unused are removed.
///
/// # Errors
///
/// [`Kind::Usage`] if they do not fit, and files of all poses are to be made of them.
pub fn check_room(runs: &[Prepared], cache: &Cache) -> Result<(), Diagnostic> {
    let merged = runs.iter().filter(|run| !run.outputs.files_of_all().is_empty());
    let needed: u64 = merged.map(bytes_of_poses).sum();
    if needed as f64 <= SHARE * cache.store.limit() as f64 {
        return Ok(());
    }
    let message = format!(
        "all poses together take {} in the cache, which may grow to {}: the first would be gone before the last are there",
        text::bytes(needed),
        text::bytes(cache.store.limit())
    );
    Err(Diagnostic::new(Kind::Usage, message).remedy(LARGER_CACHE, megabytes_for(needed).to_string(), "let it grow"))
}
