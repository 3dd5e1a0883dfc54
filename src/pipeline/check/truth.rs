use std::{
    collections::HashMap,
    path::{Path, PathBuf},
};

use nalgebra::Point3;

use super::{Check, PoseInput, Side, meshes::in_file};
use crate::{
    core::{Result, mesh::Mesh},
    pipeline::{At, Formats, document::path, resolve},
};

/// The known results.
#[derive(Clone, Debug, Default)]
pub enum Truth {
    /// There are none.
    #[default]
    None,
    /// A file a pose, in the order of poses.
    Files(Vec<PathBuf>),
    /// Positions by name of pose.
    Held(HashMap<String, Vec<Point3<f64>>>),
}

impl Truth {
    /// The known positions of pose `i`, called `name`, of the target `rest`; `None` if they are not known.
    ///
    /// # Errors
    ///
    /// If its file cannot be read, or is no pose of `rest`.
    pub fn positions(&self, i: usize, name: &str, rest: &Mesh, formats: &Formats) -> Result<Option<Vec<Point3<f64>>>> {
        match self {
            Self::None => Ok(None),
            Self::Held(by_name) => Ok(by_name.get(name).cloned()),
            Self::Files(files) => match formats.reader(&files[i]) {
                Ok(format) => format.read_pose(&files[i], rest).map(Some),
                Err(_) => Ok(None),
            },
        }
    }
}

impl Check<'_> {
    pub(super) fn truth(&mut self, pattern: Option<&Path>, target: Option<&Side>, poses: &[PoseInput]) -> Truth {
        let at = path(["truth"]);
        let Some(pattern) = pattern else {
            return match target {
                Some(target) if target.path.is_none() => Truth::Held(by_name(&target.sequence.poses)),
                _ => Truth::None,
            };
        };
        let text = pattern.to_string_lossy();
        if let Some(other) = resolve::placeholders(&text).into_iter().find(|name| *name != "pose") {
            self.wrong(
                &at,
                At::Value,
                format!("unknown placeholder `{{{other}}}`"),
                "`{pose}` stands for the pose's name",
            );
            return Truth::None;
        }
        if let Err(unknown) = self.formats.reader(pattern) {
            self.wrong(&at, At::Value, unknown.message, unknown.hint);
            return Truth::None;
        }
        if text.contains("{pose}") { self.truth_files(&text, poses) } else { self.truth_file(pattern, target, poses) }
    }

    fn truth_files(&mut self, pattern: &str, poses: &[PoseInput]) -> Truth {
        let path_of =
            |pose: &PoseInput| self.path(&path(["truth"]), Path::new(&resolve::with_pose(pattern, &pose.name)));
        let files: Vec<PathBuf> = poses.iter().map(path_of).collect();
        let missing: Vec<_> =
            files.iter().filter(|file| !file.is_file()).map(|file| file.display().to_string()).collect();
        if let Some(first) = missing.first() {
            let others = if missing.len() > 1 { format!(" (and {} more)", missing.len() - 1) } else { String::new() };
            let hint =
                "there must be a known result for every pose; `{pose}` stands for what the wildcards of `poses` match";
            self.missing(&path(["truth"]), format!("no such file: {first}{others}"), hint);
            return Truth::None;
        }
        for file in &files {
            self.input("truth", file, &path(["truth"]));
        }
        Truth::Files(files)
    }

    fn truth_file(&mut self, file: &Path, target: Option<&Side>, poses: &[PoseInput]) -> Truth {
        let file = self.path(&path(["truth"]), file);
        if !self.input("truth", &file, &path(["truth"])) {
            return Truth::None;
        }
        let Ok(format) = self.formats.reader(&file) else { return Truth::None };
        let sequence = match format.read(&file) {
            Ok(sequence) => sequence,
            Err(error) => {
                self.diagnostics.push(in_file(&file, error));
                return Truth::None;
            }
        };
        if let Some(target) = target {
            let (expected, found) = (target.sequence.rest.positions.len(), sequence.rest.positions.len());
            if expected != found {
                let message = format!("{} has {found} vertices, the target {expected}", file.display());
                self.wrong(&path(["truth"]), At::Value, message, "the truth is the target itself in its known poses");
                return Truth::None;
            }
        }
        let held = by_name(&sequence.poses);
        if let Some(missing) = poses.iter().find(|pose| !held.contains_key(&pose.name)) {
            let message = format!("{} holds no pose called `{}`", file.display(), missing.name);
            let hint = "for a file a pose, put `{pose}` into the name: `truth: truth-{pose}.obj`";
            self.missing(&path(["truth"]), message, hint);
        }
        Truth::Held(held)
    }
}

fn by_name(poses: &[crate::core::mesh::Pose]) -> HashMap<String, Vec<Point3<f64>>> {
    poses.iter().map(|pose| (pose.name.clone(), pose.positions.clone())).collect()
}
