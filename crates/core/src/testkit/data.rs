//! Real meshes and programs that a test needs and the repository does not hold.

use std::{
    env, fs,
    io::{Write, stderr},
    path::{Path, PathBuf},
    thread,
};

/// The file or folder `name` of the meshes in `../shared/data`, beside the repository; the whole folder if `name` is empty.
///
/// Returns `None` where it is missing, after [`missing`] has reported that: the test then returns.
///
/// # Panics
/// If it is missing and the environment has `CI=true`.
#[track_caller]
pub fn data(name: &str) -> Option<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let path = Path::new("../shared/data").join(name);
    let found = fs::canonicalize(root.join(&path)).ok();
    if found.is_none() {
        missing(&path.display().to_string(), "tests/DATA.md lists where it comes from");
    }
    found
}

/// Reports on standard error that the calling test is skipped, why, and how to get what is missing.
///
/// # Panics
/// If the environment has `CI=true`, where no test may be skipped.
#[track_caller]
pub fn missing(what: &str, remedy: &str) {
    assert!(env::var("CI").as_deref() != Ok("true"), "{what} is missing, and CI=true allows no skipped test: {remedy}");
    let test = thread::current().name().unwrap_or("a test").to_owned();
    // Unlike `eprintln!`, this is shown for tests that pass too.
    let _ = writeln!(stderr(), "skipped {test}: {what} is missing; {remedy}");
}
