//! Exit statuses.

use std::process::ExitCode;

use crate::core;

/// How a command ended, for scripts; the numbers above 64 are those of BSD's `sysexits.h`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
pub enum Status {
    /// Everything was done.
    Done = 0,
    /// A fault of the program itself.
    Internal = 1,
    /// The command line was not understood.
    Usage = 2,
    /// Results are there, but worse than was asked for.
    Gate = 3,
    /// Some poses failed, the others were written.
    Partly = 4,
    /// A mesh, markers or a correspondence cannot be worked with.
    BadData = 65,
    /// A file that is read does not exist.
    MissingInput = 66,
    /// A result cannot be written.
    CannotWrite = 73,
    /// The pipeline file is wrong.
    BadPipeline = 78,
    /// Stopped by the user.
    Interrupted = 130,
}

impl Status {
    /// The status for an error of a stage or a file.
    pub fn of(error: &core::Error) -> Self {
        match error {
            core::Error::Io { action: "write", .. } => Self::CannotWrite,
            core::Error::Io { source, .. }
                if matches!(source.kind(), std::io::ErrorKind::NotFound | std::io::ErrorKind::IsADirectory) =>
            {
                Self::MissingInput
            }
            core::Error::Setting { .. } => Self::BadPipeline,
            core::Error::Other(_) => Self::Internal,
            _ => Self::BadData,
        }
    }

    /// The status of several mistakes together: a wrong pipeline first, since the others may follow from it.
    pub fn of_all(statuses: impl IntoIterator<Item = Self>) -> Self {
        statuses.into_iter().max().unwrap_or(Self::Internal)
    }
}

impl From<Status> for ExitCode {
    fn from(status: Status) -> Self {
        Self::from(status as u8)
    }
}

#[cfg(test)]
mod tests {
    use std::{io, path::Path};

    use super::*;

    #[test]
    fn errors_of_files_tell_missing_from_unreadable_and_from_unwritable() {
        let path = Path::new("a.obj");
        let missing = core::Error::read(path, io::ErrorKind::NotFound.into());
        let folder = core::Error::read(path, io::ErrorKind::IsADirectory.into());
        let denied = core::Error::read(path, io::ErrorKind::PermissionDenied.into());
        let full = core::Error::write(path, io::ErrorKind::StorageFull.into());
        assert_eq!([missing, folder, denied, full].map(|e| Status::of(&e) as u8), [66, 66, 65, 73]);
    }

    #[test]
    fn a_wrong_pipeline_outweighs_a_missing_file() {
        assert_eq!(Status::of_all([Status::MissingInput, Status::BadPipeline, Status::BadData]), Status::BadPipeline);
    }
}
