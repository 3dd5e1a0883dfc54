//! Meshes and poses into files.

use std::{
    borrow::Cow,
    path::{Path, PathBuf},
};

use mimesh_core::{
    Error,
    mesh::{ClipTime, Mesh, Pose},
    stage::{MeshWriter, WriteError},
};
use mimesh_document::{Diagnostic, Kind, Location};
use mimesh_markers::IntoDiagnostic;
use mimesh_pipeline::{Formats, Reach, placeholder::with_pose, staging::Transaction};
use nalgebra::Point3;

use crate::error::Outcome;

/// A pose that is to be written.
pub struct SavedPose<'a> {
    /// Its name.
    pub name: &'a str,
    /// Its time in a clip.
    pub time: Option<&'a ClipTime>,
    /// Gives its positions.
    pub positions: Box<dyn Fn() -> mimesh_core::Result<Cow<'a, [Point3<f64>]>> + 'a>,
}

impl<'a> SavedPose<'a> {
    /// A pose of a file or of Python's memory.
    pub fn of(pose: &'a Pose) -> Self {
        Self { name: &pose.name, time: pose.time.as_ref(), positions: Box::new(|| pose.positions.get()) }
    }
}

/// Writes `rest` with `poses` into one file, or a file a pose where the name has `{pose}`; a file of one shape takes the rest.
///
/// # Errors
///
/// If no format writes such files, or they cannot be written; then none is.
pub fn save(path: &Path, rest: &Mesh, poses: &[SavedPose<'_>]) -> Outcome<Vec<PathBuf>> {
    let formats = Formats::new(vec![], Reach::new(path.parent()));
    let wrong =
        |message: String, hint: &str| Diagnostic::new(Kind::Usage, message).hint(hint).at(Location::File(path.into()));
    let (format, _) = formats.writer(path).map_err(|unknown| wrong(unknown.message, &unknown.hint))?;
    let name = path.to_string_lossy();
    let is_pattern = name.contains("{pose}");
    let files: Vec<PathBuf> = match is_pattern {
        true => poses.iter().map(|pose| with_pose(&name, pose.name).into()).collect(),
        false => vec![path.into()],
    };
    if files.is_empty() {
        return Err(wrong("there is no pose to write".into(), "leave `{pose}` out of the name").into());
    }
    let transaction = Transaction::begin(files.iter().map(PathBuf::as_path))?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut staged = vec![];
    match format.writer() {
        Some(MeshWriter::Pose(writer)) => {
            for (i, file) in files.iter().enumerate() {
                let positions = match is_pattern {
                    true => (poses[i].positions)().map_err(IntoDiagnostic::into_diagnostic)?,
                    false => Cow::Borrowed(&rest.positions[..]),
                };
                let write = |out: &mut dyn std::io::Write| {
                    writer.write_in(folder, rest, &positions, out).map_err(|error| write_error(file, error))
                };
                staged.push(transaction.stage(file, write)?);
            }
        }
        Some(MeshWriter::Sequence(_)) if is_pattern => {
            let hint = "leave `{pose}` out of the name";
            return Err(wrong("files of this format take all poses together".into(), hint).into());
        }
        Some(MeshWriter::Sequence(sequence)) => {
            let failed = |error| write_error(path, error).into_diagnostic();
            let (mut file, open) = transaction.create(path)?;
            let mut writer = sequence.start(rest, poses.len(), Box::new(open)).map_err(failed)?;
            for pose in poses {
                let positions = (pose.positions)().map_err(IntoDiagnostic::into_diagnostic)?;
                writer.add(pose.name, pose.time, &positions).map_err(failed)?;
            }
            writer.finish().map_err(failed)?;
            file.close()?;
            staged.push(file);
        }
        None => return Err(wrong("the format does not write".into(), "name a file of another format").into()),
    }
    transaction.commit(staged)?;
    Ok(files)
}

fn write_error(path: &Path, error: WriteError) -> Error {
    match error {
        WriteError::Io(error) => Error::write(path, error),
        WriteError::Mesh(Error::Data { message, hint }) => {
            Error::file(path, format!("cannot be written: {message}"), hint)
        }
        WriteError::Mesh(error) => error,
    }
}
