//! The files that a run writes.

use std::path::{Path, PathBuf};

/// The files that a run writes.
#[derive(Clone, Debug, Default)]
pub struct Outputs {
    /// The results, in the order of the pipeline.
    pub meshes: Vec<Output>,
    /// The file that takes the correspondence, if it is to be written.
    pub correspondence: Option<PathBuf>,
    /// Pages that show the results.
    pub pages: Vec<PathBuf>,
    /// Sheets of pictures.
    pub sheets: Vec<PathBuf>,
    /// The report of the run, in the folder of the first pattern.
    pub report: PathBuf,
}

/// The results of one pattern.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Output {
    /// A file a pose, in the order of poses.
    Poses(Vec<PathBuf>),
    /// One file for rest and poses.
    Sequence(PathBuf),
}

impl Outputs {
    /// Every file that the run writes.
    pub fn files(&self) -> Vec<&Path> {
        let meshes = self.meshes.iter().flat_map(Output::files);
        let others = self.pages.iter().chain(&self.sheets).chain(&self.correspondence).chain([&self.report]);
        meshes.chain(others).map(PathBuf::as_path).collect()
    }

    /// The files that hold one of `poses` each.
    pub fn files_of(&self, poses: &[usize]) -> Vec<&Path> {
        let mut all = Vec::new();
        for output in &self.meshes {
            if let Output::Poses(files) = output {
                all.extend(poses.iter().map(|&i| files[i].as_path()));
            }
        }
        all
    }

    /// The files that show or hold all poses, without the report.
    pub fn files_of_all(&self) -> Vec<&Path> {
        let sequences = self.meshes.iter().filter(|output| matches!(output, Output::Sequence(_)));
        let others = self.pages.iter().chain(&self.sheets).chain(&self.correspondence).map(PathBuf::as_path);
        sequences.flat_map(Output::files).map(PathBuf::as_path).chain(others).collect()
    }

    /// Whether the run draws pictures.
    pub fn are_visual(&self) -> bool {
        !self.pages.is_empty() || !self.sheets.is_empty()
    }
}

impl Output {
    /// The files.
    pub fn files(&self) -> &[PathBuf] {
        match self {
            Self::Poses(files) => files,
            Self::Sequence(file) => std::slice::from_ref(file),
        }
    }
}
