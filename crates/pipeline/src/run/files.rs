//! The files of results: one for each pose, or one that takes all of them.

use std::{borrow::Cow, path::Path};

use mimesh_core::{
    Error, Result,
    stage::{MeshWriter, SequenceWriter, WriteError},
};
use mimesh_document::{Diagnostic, Kind, diagnostic};
use mimesh_markers::IntoDiagnostic;
use nalgebra::Point3;

use crate::{
    input::{Output, OutputChange, PoseInput, Prepared},
    staging::{Staged, Transaction},
};

/// A file in the making that takes all poses.
pub(super) struct PosesFile<'a> {
    // Dropped first, since some systems keep a file that is open.
    writer: Box<dyn SequenceWriter>,
    staged: Staged,
    /// The change of unit and axes before its poses are added.
    change: Option<&'a OutputChange>,
}

impl<'a> PosesFile<'a> {
    /// The files of a run that take all poses.
    ///
    /// # Errors
    ///
    /// If one cannot be begun.
    pub fn all(prepared: &'a Prepared, transaction: &Transaction) -> diagnostic::Result<Vec<Self>> {
        let mut files = Vec::new();
        for output in &prepared.outputs.meshes {
            let Output::Sequence(path) = output else { continue };
            if let Ok((format, _)) = prepared.formats.writer(path)
                && let Some(MeshWriter::Sequence(sequence)) = format.writer()
            {
                let (rest, change) = (prepared.written_rest(format), prepared.output_change(format));
                let (staged, file) = transaction.create(path).map_err(cannot_write)?;
                let started = sequence.start(rest, prepared.poses.len(), Box::new(file));
                let mut writer = started.map_err(|error| write_error(path, error).into_diagnostic())?;
                writer.set_poses_are(prepared.poses_are);
                files.push(Self { staged, writer, change });
            }
        }
        Ok(files)
    }

    /// Adds the target's `positions` in a pose.
    ///
    /// # Errors
    ///
    /// If they cannot be written.
    pub fn add(&mut self, pose: &PoseInput, positions: &[Point3<f64>]) -> Result<(), Diagnostic> {
        let positions = in_units_of(self.change, positions);
        let added = self.writer.add(&pose.name, pose.time.as_ref(), &positions);
        added.map_err(|error| write_error(self.staged.place(), error).into_diagnostic())
    }

    /// Ends the file; it is still at its temporary name. With it, sentences about what it does not keep.
    ///
    /// # Errors
    ///
    /// If it cannot be written.
    pub fn finish(self) -> diagnostic::Result<(Staged, Vec<String>)> {
        let Self { mut staged, writer, .. } = self;
        let place = staged.place().display().to_string();
        let warnings = writer.warnings().iter().map(|warning| format!("{place}: {warning}")).collect();
        staged.set_renamed(writer.renamed());
        writer.finish().map_err(|error| write_error(staged.place(), error).into_diagnostic())?;
        staged.close()?;
        Ok((staged, warnings))
    }
}

/// Writes the files of pose `i` alone, the target at `positions`.
///
/// # Errors
///
/// If one cannot be written.
pub(super) fn pose_files(
    prepared: &Prepared,
    transaction: &Transaction,
    i: usize,
    positions: &[Point3<f64>],
) -> Result<Vec<Staged>, Diagnostic> {
    let mut files = Vec::new();
    for output in &prepared.outputs.meshes {
        let Output::Poses(paths) = output else { continue };
        let path = &paths[i];
        if let Ok((format, _)) = prepared.formats.writer(path)
            && let Some(MeshWriter::Pose(writer)) = format.writer()
        {
            let rest = prepared.written_rest(format);
            let positions = in_units_of(prepared.output_change(format), positions);
            let write = |out: &mut dyn std::io::Write| {
                writer.write_in(folder_of(path), rest, &positions, out).map_err(|error| write_error(path, error))
            };
            files.push(transaction.stage(path, write).map_err(cannot_write)?);
        }
    }
    Ok(files)
}

/// Sentences about what files of one pose each do not keep, once for all poses.
pub(super) fn warnings_of_pose_files(prepared: &Prepared) -> Vec<String> {
    let mut warnings = Vec::new();
    for output in &prepared.outputs.meshes {
        if let Output::Poses(paths) = output
            && let Some(path) = paths.first()
            && let Ok((format, _)) = prepared.formats.writer(path)
            && let Some(MeshWriter::Pose(writer)) = format.writer()
        {
            let found = writer.warnings(folder_of(path), prepared.written_rest(format));
            warnings.extend(found.iter().map(|warning| format!("{}: {warning}", path.display())));
        }
    }
    warnings
}

/// `positions` after the change of a file's unit and axes, if there is one.
fn in_units_of<'p>(change: Option<&OutputChange>, positions: &'p [Point3<f64>]) -> Cow<'p, [Point3<f64>]> {
    change.map_or(Cow::Borrowed(positions), |change| Cow::Owned(change.positions(positions)))
}

/// The folder of a file.
fn folder_of(path: &Path) -> &Path {
    path.parent().unwrap_or(Path::new(""))
}

/// The error of writing `path`.
fn write_error(path: &Path, error: WriteError) -> Error {
    match error {
        WriteError::Io(error) => Error::write(path, error),
        WriteError::Mesh(Error::Data { message, hint }) => {
            Error::file(path, format!("cannot be written: {message}"), hint)
        }
        WriteError::Mesh(error) => error,
    }
}

/// An error of writing ends the run, so it is no fault of the pose.
fn cannot_write(diagnostic: Diagnostic) -> Diagnostic {
    Diagnostic { kind: Kind::CannotWrite, ..diagnostic }
}
