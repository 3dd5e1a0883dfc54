//! What a run computes and writes: all of it, a part, or the files of all poses once parts have computed them.

use mimesh_document::{Diagnostic, Kind};

use super::{frames::in_ranges, selection::PoseSelection};
use crate::input::Prepared;

/// Remedy: compute some frames before a part of a motion and throw them away.
pub const WARM_FRAMES: &str = "warm_frames";

/// What a run computes and writes.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Extent {
    /// All poses and all files.
    #[default]
    Whole,
    /// Some poses and the files that hold one of them each; the results are cached for a merge.
    Part(Part),
    /// All files, of poses that parts have computed.
    Merge(Merge),
}

/// Some poses of a run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Part {
    /// How they were chosen.
    pub selection: PoseSelection,
    /// The poses by number, ascending; perhaps none.
    pub poses: Vec<usize>,
    /// The number of poses of the run.
    pub of: usize,
    /// How many frames of a motion are computed before each stretch of frames, and thrown away.
    pub warm: Option<usize>,
}

/// How the poses are found that parts have computed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Merge {
    /// For a motion: the number of warm frames before each part.
    pub warm: Option<usize>,
}

impl Extent {
    /// Whether only files of one pose each are written.
    pub fn is_part(&self) -> bool {
        matches!(self, Self::Part(_))
    }

    /// The part, if it is one.
    pub fn part(&self) -> Option<&Part> {
        match self {
            Self::Part(part) => Some(part),
            _ => None,
        }
    }

    /// Whether no pose is computed.
    pub fn is_merge(&self) -> bool {
        matches!(self, Self::Merge(_))
    }
}

impl Part {
    /// The poses of `prepared` that are `selection`; nothing is computed.
    ///
    /// # Errors
    ///
    /// [`Kind::Usage`] if there are no such poses, and if they are frames of one motion that cannot be split without `warm`.
    pub fn new(prepared: &Prepared, selection: &PoseSelection, warm: Option<usize>) -> Result<Self, Diagnostic> {
        let of = prepared.poses.len();
        let part = Self { selection: selection.clone(), poses: selection.of(of)?, of, warm };
        match prepared.pipeline.transfer.as_ref().is_some_and(|transfer| transfer.gives_motion()) {
            true => part.check_motion().map(|()| part),
            false => Ok(part),
        }
    }

    /// Checks that frames of one motion may be computed in this part.
    ///
    /// # Errors
    ///
    /// [`Kind::Usage`] if it lacks frames and none are computed before to come near them.
    pub fn check_motion(&self) -> Result<(), Diagnostic> {
        if self.poses.is_empty() || self.poses.len() == self.of || self.warm.is_some() {
            return Ok(());
        }
        let message = format!(
            "frames of one motion depend on those before, so that {} of {} cannot be computed alone",
            self.ranges(),
            self.of
        );
        let diagnostic = Diagnostic::new(Kind::Usage, message).hint("run it whole");
        Err(diagnostic.remedy(
            WARM_FRAMES,
            "",
            "begin each part so many frames earlier, from rest, for results near the exact ones",
        ))
    }

    /// The poses by number, as `0-3,7`.
    pub fn ranges(&self) -> String {
        in_ranges(&self.poses)
    }
}
