//! Runs that die, disks that are full and folders that are closed: results are those of one run, old or new, and nothing is left over.
#![cfg(all(feature = "bundled", target_os = "linux"))]

mod calls;
#[path = "../common/mod.rs"]
mod common;
mod disks;
mod inputs;
mod kills;
mod places;
mod refused;
mod sets;
mod stopped;
mod strangers;
mod together;
