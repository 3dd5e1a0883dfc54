//! `mimesh cache`, and the options of the cache that several commands have.

use std::{path::PathBuf, sync::OnceLock};

use mimesh_document::{Diagnostic, Kind, diagnostic, files::hash_file};
use mimesh_markers::IntoDiagnostic;
use mimesh_pipeline::{
    cache::{Cache, DEFAULT_LIMIT, WITHOUT_CACHE},
    text::{bytes, count, pairs},
};
use serde_json::json;

use crate::cli::{CommandResult, status::Status, terminal};

/// The options of the cache.
#[derive(Debug, clap::Args)]
pub struct CacheOptions {
    /// Cache results of stages in this folder [default: $MIMESH_CACHE, else mimesh in the user's folder for caches]
    #[arg(long, value_name = "DIR", conflicts_with = "no_cache")]
    cache: Option<PathBuf>,
    /// Limit the cache to this many megabytes; the least recently used results are removed first
    #[arg(long, value_name = "MB", conflicts_with = "no_cache")]
    cache_limit: Option<u64>,
    /// Compute everything, and cache nothing
    #[arg(long)]
    no_cache: bool,
}

impl CacheOptions {
    /// Opens the cache; `None` with `--no-cache`.
    ///
    /// # Errors
    ///
    /// A diagnostic if there is no folder for it.
    pub fn open(&self) -> diagnostic::Result<Option<Cache>> {
        if self.no_cache {
            return Ok(None);
        }
        let limit = self.cache_limit.map_or(DEFAULT_LIMIT, |megabytes| megabytes.saturating_mul(1 << 20));
        Cache::new(self.cache.as_deref(), limit, program()?).map(Some)
    }

    /// Opens the cache that parts of a run share, for `command`, which cannot do without.
    ///
    /// # Errors
    ///
    /// A diagnostic with `--no-cache`, and those of [`open`](Self::open).
    pub fn open_shared(&self, command: &str) -> diagnostic::Result<Cache> {
        self.open()?.ok_or_else(|| {
            let message = format!("--no-cache: `mimesh {command}` works with what is cached");
            Diagnostic::new(Kind::Usage, message).hint("leave it out, or name a folder by `--cache DIR`").into()
        })
    }

    /// The options as they were given, for another command.
    pub fn arguments(&self) -> Vec<String> {
        let folder = self.cache.iter().flat_map(|folder| ["--cache".into(), folder.display().to_string()]);
        let limit = self.cache_limit.iter().flat_map(|megabytes| ["--cache-limit".into(), megabytes.to_string()]);
        folder.chain(limit).collect()
    }
}

/// Shows the cached results of earlier runs, or clears them.
///
/// Results of stages are cached under the hash of everything they depend on. They are never out of date, and you may
/// clear them at any time.
#[derive(Debug, clap::Args)]
#[command(
    name = "cache",
    after_help = "Examples:
  mimesh cache
  mimesh cache --clear"
)]
pub struct CacheCommand {
    /// Remove all cached results
    #[arg(long)]
    clear: bool,
    /// The folder of the cache [default: $MIMESH_CACHE, else mimesh in the user's folder for caches]
    #[arg(long, value_name = "DIR")]
    cache: Option<PathBuf>,
    /// Print the usage as JSON
    #[arg(long)]
    json: bool,
}

impl CacheCommand {
    /// Runs the command.
    pub fn run(&self) -> CommandResult {
        let cache = Cache::new(self.cache.as_deref(), DEFAULT_LIMIT, String::new())?;
        let folder = cache.store.folder();
        if self.clear {
            let removed = cache.store.clear().map_err(IntoDiagnostic::into_diagnostic)?;
            if self.json {
                terminal::print_json(&json!({ "folder": terminal::shown(folder), "removed": removed }));
            } else {
                let results = count(removed.entries, "result", "results");
                terminal::print(&format!("{results} removed ({}) from {}\n", bytes(removed.bytes), folder.display()));
            }
            return Ok(Status::Done);
        }
        let usage = cache.store.usage();
        let total: u64 = usage.values().map(|usage| usage.bytes).sum();
        if self.json {
            terminal::print_json(&json!({ "folder": terminal::shown(folder), "kept": usage, "bytes": total }));
        } else {
            let rows = usage.iter().map(|(kind, usage)| {
                (kind.clone(), format!("{}, {}", count(usage.entries, "result", "results"), bytes(usage.bytes)))
            });
            let mut text = format!("{}\n", folder.display());
            text += &pairs(&rows.collect::<Vec<_>>());
            text += &format!("{} in total\n", bytes(total));
            terminal::print(&text);
        }
        Ok(Status::Done)
    }
}

/// What gives the identity of the program around the command line, if that is another one.
static IDENTITY: OnceLock<fn() -> diagnostic::Result<String>> = OnceLock::new();

/// Takes `identity` for that of the program.
pub(super) fn set_identity(identity: Option<fn() -> diagnostic::Result<String>>) {
    if let Some(identity) = identity {
        // A process has one command line.
        let _ = IDENTITY.set(identity);
    }
}

/// The identity of this program for the cache: the hash of its own file, or what the program around it says.
///
/// An edited stage changes the hash, so that its results are computed anew even if its version stays.
fn program() -> diagnostic::Result<String> {
    if let Some(identity) = IDENTITY.get() {
        return identity();
    }
    let hash = std::env::current_exe().and_then(|file| hash_file(&file));
    hash.map_err(|error| {
        let message = format!("the program cannot read its own file, whose hash the cache needs: {error}");
        Diagnostic::new(Kind::Internal, message).remedy(WITHOUT_CACHE, "", "run without the cache").into()
    })
}
