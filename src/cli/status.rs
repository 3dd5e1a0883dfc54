//! Exit statuses of the program.

use std::process::ExitCode;

use mimesh_document::diagnostic::Kind;

/// The exit status of a command, for scripts.
///
/// The numbers above 64 are those of BSD's `sysexits.h`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
pub enum Status {
    /// Everything was done.
    Done = 0,
    /// The program itself has a bug.
    Internal = 1,
    /// The command line was not understood.
    Usage = 2,
    /// All results were written, but they break a quality gate.
    Gate = 3,
    /// Some poses or runs failed; the others were written.
    Partly = 4,
    /// A mesh, a file of markers or a correspondence is unusable.
    BadData = 65,
    /// An input file does not exist.
    MissingInput = 66,
    /// There is not enough memory for the work.
    Memory = 71,
    /// A result cannot be written.
    CannotWrite = 73,
    /// Another process is writing the same results or computes what is needed, or poses to merge are missing; later the command will
    /// succeed.
    Busy = 75,
    /// The pipeline file is wrong.
    BadPipeline = 78,
    /// The user stopped the command.
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
            Kind::Busy => Self::Busy,
            Kind::Memory => Self::Memory,
            Kind::BadPipeline => Self::BadPipeline,
        }
    }
}

impl From<Status> for ExitCode {
    fn from(status: Status) -> Self {
        Self::from(status as u8)
    }
}
