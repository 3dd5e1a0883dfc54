//! Exit statuses.

use std::process::ExitCode;

use crate::diagnostic::Kind;

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

impl From<Kind> for Status {
    fn from(kind: Kind) -> Self {
        match kind {
            Kind::Internal => Self::Internal,
            Kind::Usage => Self::Usage,
            Kind::BadData => Self::BadData,
            Kind::MissingInput => Self::MissingInput,
            Kind::CannotWrite => Self::CannotWrite,
            Kind::BadPipeline => Self::BadPipeline,
        }
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
    use crate::core;

    #[test]
    fn errors_of_files_tell_missing_from_unreadable_and_from_unwritable() {
        let path = Path::new("a.obj");
        let missing = core::Error::read(path, io::ErrorKind::NotFound.into());
        let folder = core::Error::read(path, io::ErrorKind::IsADirectory.into());
        let denied = core::Error::read(path, io::ErrorKind::PermissionDenied.into());
        let full = core::Error::write(path, io::ErrorKind::StorageFull.into());
        assert_eq!([missing, folder, denied, full].map(|e| Status::from(Kind::of(&e)) as u8), [66, 66, 65, 73]);
    }

    #[test]
    fn a_wrong_pipeline_outweighs_a_missing_file() {
        assert_eq!(Kind::of_all([Kind::MissingInput, Kind::BadPipeline, Kind::BadData]), Kind::BadPipeline);
    }
}
