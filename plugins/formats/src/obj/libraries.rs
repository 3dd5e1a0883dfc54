//! The `mtllib` lines of a file, for results in other folders.

use std::{
    ops::Range,
    path::{Path, PathBuf},
};

use crate::{
    names::quoted,
    paths::{relative, resolved},
};

/// The `mtllib` lines of a file.
#[derive(Debug)]
pub struct LibraryLines {
    /// The folder of the file, without links.
    folder: PathBuf,
    lines: Vec<Line>,
}

/// A line and the libraries that it names.
#[derive(Debug)]
struct Line {
    /// Where the names stand.
    place: Range<usize>,
    /// The libraries that exist, as they are called from the folder of the file.
    names: Vec<String>,
}

impl LibraryLines {
    /// The lines of the file `path` at `places`, and the libraries that each of them names.
    pub fn new(path: &Path, places: Vec<Range<usize>>, names: Vec<Vec<String>>) -> Self {
        let lines = places.into_iter().zip(names).map(|(place, names)| Line { place, names }).collect();
        Self { folder: resolved(path.parent().unwrap_or(Path::new(""))), lines }
    }

    /// What takes the place of names for a file in `folder`: the same libraries as they are called from there.
    ///
    /// Lines stay as they are in the folder of the file, and those whose libraries do not exist or have an absolute path.
    pub fn moved_to(&self, folder: &Path) -> Vec<(Range<usize>, String)> {
        let folder = resolved(folder);
        if folder == self.folder {
            return Vec::new();
        }
        let moved = |line: &Line| {
            if line.names.is_empty() || line.names.iter().any(|name| Path::new(name).is_absolute()) {
                return None;
            }
            let called = line.names.iter().map(|name| relative(&folder, &resolved(&self.folder.join(name))));
            // A name may hold spaces if it stands alone.
            Some((line.place.clone(), called.collect::<Vec<_>>().join("\nmtllib ")))
        };
        self.lines.iter().filter_map(moved).collect()
    }

    /// The sentence about lines that are others in a file in `folder`.
    pub fn warning(&self, folder: &Path) -> Option<String> {
        let moved = self.moved_to(folder);
        let names: Vec<&str> = moved.iter().flat_map(|(_, names)| names.split("\nmtllib ")).collect();
        (!names.is_empty())
            .then(|| format!("`mtllib` names the material library by its path from the new folder: {}", quoted(&names)))
    }
}
