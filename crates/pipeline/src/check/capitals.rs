//! Files whose names differ in capitals only, where a file system takes these for one name.

use std::{
    collections::HashMap,
    path::{Path, PathBuf},
};

/// Files so far, by their names without capitals.
#[derive(Debug, Default)]
pub(super) struct Capitals {
    files: HashMap<String, PathBuf>,
    /// Whether a folder ignores capitals.
    folders: HashMap<PathBuf, bool>,
}

impl Capitals {
    /// Adds a file by its identity; the other one that the system takes for the same, if there is one.
    pub fn add(&mut self, file: &Path) -> Option<PathBuf> {
        let other = match self.files.entry(file.to_string_lossy().to_lowercase()) {
            std::collections::hash_map::Entry::Vacant(entry) => {
                entry.insert(file.into());
                return None;
            }
            std::collections::hash_map::Entry::Occupied(entry) => entry.get().clone(),
        };
        let folder = existing_folder(file);
        let ignored = self.folders.entry(folder.into()).or_insert_with(|| ignores_capitals(folder));
        (other != file && *ignored).then_some(other)
    }
}

/// Whether `folder` takes `a` and `A` for one name: found by a file that is there for a moment. Where none can be made, it does not.
fn ignores_capitals(folder: &Path) -> bool {
    let Ok(file) = tempfile::Builder::new().prefix(".mimesh-name-").tempfile_in(folder) else { return false };
    let upper = file.path().file_name().map(|name| name.to_string_lossy().to_uppercase());
    upper.is_some_and(|name| folder.join(name).symlink_metadata().is_ok())
}

/// The nearest folder around `file` that exists.
pub(super) fn existing_folder(file: &Path) -> &Path {
    // A link that leads nowhere is there too.
    let exists = |folder: &&Path| folder.as_os_str().is_empty() || folder.symlink_metadata().is_ok();
    match file.ancestors().skip(1).find(exists) {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_differ_in_capitals_are_one_where_the_folder_takes_them_for_one() {
        let folder = tempfile::tempdir().unwrap();
        let (lower, upper) = (folder.path().join("a.obj"), folder.path().join("A.OBJ"));
        std::fs::write(&lower, "").unwrap();
        let is_one = upper.exists();
        let mut capitals = Capitals::default();
        assert_eq!(capitals.add(&lower), None);
        assert_eq!(capitals.add(&lower), None);
        assert_eq!(capitals.add(&upper), is_one.then_some(lower));
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "nothing is left");
    }
}
