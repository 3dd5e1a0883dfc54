//! Which poses of a run a part of it computes.

use std::{fmt, str::FromStr};

use mimesh_document::Diagnostic;

use super::frames::Frames;

/// Some of the poses of a run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PoseSelection {
    /// These frames.
    Frames(Frames),
    /// One of several shards, which together are all poses.
    Shard(Shard),
}

/// One of equal parts: all poses belong to exactly one, and their sizes differ by at most one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// Its number, from 0.
    pub number: usize,
    /// The number of parts, at least one.
    pub of: usize,
}

impl PoseSelection {
    /// The poses of a run with so many of them, in order; a shard may have none.
    ///
    /// # Errors
    ///
    /// Those of [`Frames::of`].
    pub fn of(&self, poses: usize) -> Result<Vec<usize>, Diagnostic> {
        match self {
            Self::Frames(frames) => frames.of(poses),
            Self::Shard(shard) => Ok(shard.range(poses).collect()),
        }
    }
}

impl Shard {
    /// The poses of this shard, of a run with so many of them.
    pub fn range(self, poses: usize) -> std::ops::Range<usize> {
        // The first shards have one pose more than the others.
        let (least, more) = (poses / self.of, poses % self.of);
        let start = |number: usize| number * least + number.min(more);
        start(self.number)..start(self.number + 1)
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let expected = "expected I/N with I from 0 below N, e.g. `0/4` to `3/4`";
        let number = |text: &str| text.trim().parse::<usize>().ok();
        let parts = text.split_once('/').and_then(|(number_of, of)| Some((number(number_of)?, number(of)?)));
        match parts {
            None => Err(expected.into()),
            Some((_, 0)) => Err(format!("there are no parts; {expected}")),
            Some((number, of)) if number >= of => Err(format!("shards of {of} count from 0 to {}; {expected}", of - 1)),
            Some((number, of)) => Ok(Self { number, of }),
        }
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.number, self.of)
    }
}

impl fmt::Display for PoseSelection {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Frames(frames) => write!(f, "frames {frames}"),
            Self::Shard(shard) => write!(f, "shard {shard}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_are_all_poses_once_and_of_even_size() {
        for poses in 0..40 {
            for of in 1..50 {
                let ranges: Vec<_> = (0..of).map(|number| Shard { number, of }.range(poses)).collect();
                let together: Vec<usize> = ranges.iter().cloned().flatten().collect();
                assert_eq!(together, (0..poses).collect::<Vec<_>>(), "{poses} poses in {of} shards");
                let sizes = ranges.iter().map(ExactSizeIterator::len);
                let (most, least) = (sizes.clone().max(), sizes.min());
                assert!(most.zip(least).is_some_and(|(most, least)| most - least <= 1), "{poses} poses in {of} shards");
            }
        }
    }

    #[test]
    fn shards_are_read_and_what_is_none_is_told() {
        assert_eq!("1/4".parse(), Ok(Shard { number: 1, of: 4 }));
        assert_eq!("3/4".parse::<Shard>().unwrap().to_string(), "3/4");
        for wrong in ["", "1", "/", "4/4", "0/0", "-1/4", "1/4/2", "a/b"] {
            assert!(wrong.parse::<Shard>().unwrap_err().contains("e.g. `0/4` to `3/4`"), "{wrong}");
        }
    }
}
