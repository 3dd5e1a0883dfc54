//! Whose files are ours: a journal of another user is nothing that we may act upon.

use std::{fs, path::Path};

/// The user to whom the file at `path` belongs, if it is not the one to whom our files in `folder` belong.
///
/// What cannot be told counts as ours: then nothing can be written there either, or the system knows no users.
#[cfg(unix)]
pub(super) fn other_owner(path: &Path, folder: &Path) -> Option<u32> {
    use std::os::unix::fs::MetadataExt;
    let owner = fs::symlink_metadata(path).ok()?.uid();
    let ours = tempfile::tempfile_in(folder).ok()?.metadata().ok()?.uid();
    (owner != ours).then_some(owner)
}

/// Other systems tell no users by numbers.
#[cfg(not(unix))]
pub(super) fn other_owner(path: &Path, _: &Path) -> Option<u32> {
    let _ = fs::symlink_metadata(path);
    None
}
