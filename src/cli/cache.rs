use std::path::PathBuf;

use serde_json::json;

use super::{Ended, terminal};
use crate::text::{bytes, count, pairs};
use crate::{
    diagnostic,
    pipeline::cache::{Cache, DEFAULT_LIMIT},
    status::Status,
};

/// Where results are kept from run to run.
#[derive(Debug, clap::Args)]
pub struct CacheOptions {
    /// Keep results of stages in this folder [default: $MIMESH_CACHE, else mimesh in the user's folder for caches]
    #[arg(long, value_name = "DIR", conflicts_with = "no_cache")]
    cache: Option<PathBuf>,
    /// Keep at most this many megabytes; what has not been used for longest goes first
    #[arg(long, value_name = "MB", conflicts_with = "no_cache")]
    cache_limit: Option<u64>,
    /// Compute everything, and keep nothing
    #[arg(long)]
    no_cache: bool,
}

impl CacheOptions {
    /// The cache, unless there is to be none.
    pub fn open(&self) -> diagnostic::Result<Option<Cache>> {
        if self.no_cache {
            return Ok(None);
        }
        let limit = self.cache_limit.map_or(DEFAULT_LIMIT, |megabytes| megabytes.saturating_mul(1 << 20));
        Cache::new(self.cache.as_deref(), limit).map(Some)
    }
}

/// Shows what is kept from earlier runs, or clears it.
///
/// Results of stages are kept under the hash of all that they depend on: they are never out of date, and may be cleared at any
/// time.
#[derive(Debug, clap::Args)]
#[command(
    name = "cache",
    after_help = "Examples:
  mimesh cache
  mimesh cache --clear"
)]
pub struct ShowCache {
    /// Remove all kept results
    #[arg(long)]
    clear: bool,
    /// The folder [default: $MIMESH_CACHE, else mimesh in the user's folder for caches]
    #[arg(long, value_name = "DIR")]
    cache: Option<PathBuf>,
    /// Print as JSON
    #[arg(long)]
    json: bool,
}

impl ShowCache {
    /// Runs the command.
    pub fn run(&self) -> Ended {
        let cache = Cache::new(self.cache.as_deref(), DEFAULT_LIMIT)?;
        let folder = cache.store.folder();
        if self.clear {
            let removed = cache.store.clear()?;
            if self.json {
                terminal::print_json(&json!({ "folder": folder, "removed": removed }));
            } else {
                let results = count(removed.entries, "result", "results");
                terminal::print(&format!("{results} removed ({}) from {}\n", bytes(removed.bytes), folder.display()));
            }
            return Ok(Status::Done);
        }
        let kept = cache.store.kept();
        let all: u64 = kept.values().map(|kept| kept.bytes).sum();
        if self.json {
            terminal::print_json(&json!({ "folder": folder, "kept": kept, "bytes": all }));
        } else {
            let rows = kept.iter().map(|(kind, kept)| {
                (kind.clone(), format!("{}, {}", count(kept.entries, "result", "results"), bytes(kept.bytes)))
            });
            let mut text = format!("{}\n", folder.display());
            text += &pairs(&rows.collect::<Vec<_>>());
            text += &format!("{} in all\n", bytes(all));
            terminal::print(&text);
        }
        Ok(Status::Done)
    }
}
