//! The files that a run wrote, where they are now.

use std::path::{Path, PathBuf};

use mimesh_pipeline::Report;

/// The files that a run wrote. If the folder of the report was moved, they are looked for beside the report.
pub struct WrittenFiles {
    files: Vec<WrittenFile>,
}

/// A file, with its size in bytes when it was written.
struct WrittenFile {
    path: PathBuf,
    bytes: u64,
}

impl WrittenFiles {
    /// The files of the run whose report is `file`.
    pub fn new(report: &Report, file: &Path) -> Self {
        let folder = file.parent().unwrap_or(Path::new(""));
        let moved = |path: &Path| {
            let beside = report.place.parent().and_then(|old_folder| path.strip_prefix(old_folder).ok());
            beside.map_or_else(|| path.into(), |beside| folder.join(beside))
        };
        let files = report.outputs.iter();
        Self { files: files.map(|output| WrittenFile { path: moved(&output.path), bytes: output.bytes }).collect() }
    }

    /// The paths of all files, whether they are still there or not.
    pub fn paths(&self) -> impl Iterator<Item = &Path> {
        self.files.iter().map(|file| &*file.path)
    }

    /// The file with the file name of `path`, if it is unchanged.
    pub fn find(&self, path: &Path) -> Option<&Path> {
        let file = self.files.iter().find(|file| file.path.file_name() == path.file_name());
        file.filter(|file| file.is_unchanged()).map(|file| &*file.path)
    }

    /// A sentence on the files that are missing or have another size; `None` if there are none.
    pub fn changes(&self) -> Option<String> {
        let changed: Vec<_> = self.files.iter().filter(|file| !file.is_unchanged()).collect();
        let first = changed.first()?.path.display();
        Some(match changed.len() {
            1 => format!("{first} is missing or has changed, and is not drawn"),
            count => format!("{first} and {} more are missing or have changed, and are not drawn", count - 1),
        })
    }
}

impl WrittenFile {
    fn is_unchanged(&self) -> bool {
        std::fs::metadata(&self.path).is_ok_and(|found| found.len() == self.bytes)
    }
}
