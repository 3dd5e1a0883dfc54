//! The folders that may be looked at, and their files.

use std::{
    fs, io,
    path::{Component, Path, PathBuf},
    time::UNIX_EPOCH,
};

use mimesh_markers::notation::Notation;
use mimesh_pipeline::Formats;
use serde::Serialize;

use crate::{
    error::{ApiError, Result},
    regular,
};

/// The most entries of a folder that are listed.
const MAX_ENTRIES: usize = 10_000;

/// Folders under which files may be listed and opened; links are resolved first.
#[derive(Clone, Debug)]
pub struct Folders {
    roots: Vec<Root>,
}

/// A folder that may be looked at.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Root {
    /// Its name for people.
    pub name: String,
    /// Its path, without links.
    pub path: PathBuf,
}

/// What a folder holds.
#[derive(Clone, Debug, Serialize)]
pub struct Folder {
    path: PathBuf,
    parent: Option<PathBuf>,
    roots: Vec<Root>,
    entries: Vec<Entry>,
}

#[derive(Clone, Debug, Serialize)]
struct Entry {
    name: String,
    path: PathBuf,
    kind: EntryKind,
    bytes: u64,
    modified: u64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
enum EntryKind {
    Folder,
    Mesh,
    Pipeline,
    Markers,
    Other,
}

impl Folders {
    /// The folders `named`, each with a name for people; those that do not exist are left out.
    pub fn new(named: impl IntoIterator<Item = (String, PathBuf)>) -> Self {
        let mut roots: Vec<Root> = Vec::new();
        for (name, path) in named {
            let Ok(path) = fs::canonicalize(path) else { continue };
            if roots.iter().all(|root| root.path != path) {
                roots.push(Root { name, path });
            }
        }
        Self { roots }
    }

    /// The paths of all roots.
    pub fn paths(&self) -> Vec<PathBuf> {
        self.roots.iter().map(|root| root.path.clone()).collect()
    }

    /// The existing file or folder `path`, without links.
    ///
    /// # Errors
    ///
    /// [`Code::NotFound`](crate::error::Code::NotFound), whether it lies outside or does not exist: who asks learns nothing else.
    pub fn find(&self, path: &Path) -> Result<PathBuf> {
        let missing = || ApiError::not_found(format!("there is no `{}` in the folders that are open", path.display()));
        let found = fs::canonicalize(path).map_err(|_| missing())?;
        if self.holds(&found) {
            Ok(found)
        } else {
            Err(missing().hint("start the program with `--root DIR` for other folders"))
        }
    }

    /// The place `path` of a file that need not exist, in a folder without links.
    ///
    /// # Errors
    ///
    /// As [`find`](Self::find), for its folder.
    pub fn place(&self, path: &Path) -> Result<PathBuf> {
        if path.exists() {
            return self.find(path);
        }
        let name = path.file_name().ok_or_else(|| ApiError::bad(format!("`{}` names no file", path.display())))?;
        Ok(self.find(path.parent().unwrap_or(Path::new("")))?.join(name))
    }

    /// Whether the path without links lies under a root.
    pub fn holds(&self, path: &Path) -> bool {
        path.is_absolute()
            && path.components().all(|part| part != Component::ParentDir)
            && self.roots.iter().any(|root| path.starts_with(&root.path))
    }

    /// What the folder `path` holds; without a path the first root.
    ///
    /// # Errors
    ///
    /// As [`find`](Self::find), and for files.
    pub fn list(&self, path: Option<&Path>, formats: &Formats) -> Result<Folder> {
        let path = match (path, self.roots.first()) {
            (Some(path), _) => self.find(path)?,
            (None, Some(root)) => root.path.clone(),
            (None, None) => return Err(ApiError::not_found("no folder is open")),
        };
        let entries = fs::read_dir(&path).map_err(|error| unreadable(&path, &error))?;
        let mut entries: Vec<Entry> =
            entries.flatten().filter_map(|entry| self.entry(&entry.path(), formats)).collect();
        entries.sort_by(|a, b| (a.kind != EntryKind::Folder, &a.name).cmp(&(b.kind != EntryKind::Folder, &b.name)));
        entries.truncate(MAX_ENTRIES);
        let parent = path.parent().filter(|parent| self.holds(parent)).map(Path::to_path_buf);
        Ok(Folder { parent, roots: self.roots.clone(), entries, path })
    }

    fn entry(&self, path: &Path, formats: &Formats) -> Option<Entry> {
        let name = path.file_name()?.to_string_lossy().into_owned();
        if name.starts_with('.') || !self.holds(&fs::canonicalize(path).ok()?) {
            return None;
        }
        let metadata = fs::metadata(path).ok()?;
        let modified = metadata.modified().ok().and_then(|time| time.duration_since(UNIX_EPOCH).ok());
        let kind = if metadata.is_dir() { EntryKind::Folder } else { kind_of(path, metadata.len(), formats) };
        let modified = modified.map_or(0, |time| time.as_secs());
        Some(Entry { name, path: path.into(), kind, bytes: metadata.len(), modified })
    }
}

/// A YAML is a pipeline or markers by its first keys; other files are told by their names.
fn kind_of(path: &Path, bytes: u64, formats: &Formats) -> EntryKind {
    let extension = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    if ["yaml", "yml"].contains(&&*extension) {
        let text = if bytes < 1 << 20 { regular::read_text(path).unwrap_or_default() } else { String::new() };
        let has = |key: &str| text.lines().any(|line| line.starts_with(key));
        return if has("markers:") && !has("transfer:") && !has("output:") {
            EntryKind::Markers
        } else if has("source:") || has("target:") || has("targets:") || has("include:") {
            EntryKind::Pipeline
        } else {
            EntryKind::Other
        };
    }
    let is_mesh = formats.all().iter().any(|format| format.reads() && format.extensions().contains(&&*extension));
    match Notation::of(path) {
        _ if is_mesh => EntryKind::Mesh,
        Some(_) => EntryKind::Markers,
        None => EntryKind::Other,
    }
}

fn unreadable(path: &Path, error: &io::Error) -> ApiError {
    match error.kind() {
        io::ErrorKind::NotADirectory => ApiError::bad(format!("`{}` is a file, expected a folder", path.display())),
        _ => ApiError::not_found(format!("cannot read the folder `{}`: {error}", path.display())),
    }
}

#[cfg(test)]
mod tests {
    use mimesh_pipeline::Reach;

    use super::*;

    #[test]
    fn nothing_outside_the_roots_is_found() {
        let outer = tempfile::tempdir().unwrap();
        let root = outer.path().join("root");
        fs::create_dir_all(root.join("inner")).unwrap();
        fs::write(outer.path().join("secret"), "x").unwrap();
        fs::write(root.join("a.yaml"), "source: {}\n").unwrap();
        #[cfg(unix)]
        std::os::unix::fs::symlink(outer.path().join("secret"), root.join("link")).unwrap();
        let folders = Folders::new([("start".to_owned(), root.clone())]);
        for path in ["../secret", "inner/../../secret", "link", "..", "", "missing"] {
            assert_ne!(folders.find(&root.join(path)).is_err(), path.is_empty(), "{path}");
        }
        assert!(folders.find(Path::new("/etc/passwd")).is_err());
        assert!(folders.place(&root.join("../new.yaml")).is_err() && folders.place(&root.join("new.yaml")).is_ok());
        let formats = Formats::new(vec![], Reach::default());
        let listed = folders.list(None, &formats).unwrap();
        let names: Vec<_> = listed.entries.iter().map(|entry| (entry.name.as_str(), entry.kind)).collect();
        assert_eq!(names, [("inner", EntryKind::Folder), ("a.yaml", EntryKind::Pipeline)]);
        assert!(listed.parent.is_none() && folders.list(Some(outer.path()), &formats).is_err());
    }
}
