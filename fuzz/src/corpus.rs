//! Files to begin with, and those that broke a promise once.

use std::{
    fs, io,
    path::{Path, PathBuf},
};

/// The folder of this crate.
pub fn home() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).to_owned()
}

/// The files in a folder below [`home`], by name; none if there is no such folder.
///
/// # Errors
///
/// Those of the system.
pub fn files(folder: &str, target: &str) -> io::Result<Vec<(String, Vec<u8>)>> {
    let folder = home().join(folder).join(target);
    if !folder.is_dir() {
        return Ok(Vec::new());
    }
    let mut found = Vec::new();
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        found.push((path.file_name().unwrap_or_default().to_string_lossy().into_owned(), fs::read(&path)?));
    }
    found.sort();
    Ok(found)
}

/// Puts a file into a folder below [`home`]; its name is the hash of its contents.
///
/// # Errors
///
/// Those of the system.
pub fn put(folder: &str, target: &str, bytes: &[u8]) -> io::Result<PathBuf> {
    let folder = home().join(folder).join(target);
    fs::create_dir_all(&folder)?;
    let path = folder.join(format!("{:016x}", hash(bytes)));
    fs::write(&path, bytes)?;
    Ok(path)
}

/// A hash that is the same on every machine: FNV-1a.
pub fn hash(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3))
}
