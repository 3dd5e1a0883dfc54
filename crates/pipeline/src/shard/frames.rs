//! Frames by number, as farms name them: `7`, `0-24`, `0-99:10`, `1-3,5,7-20:2`.

use std::{collections::BTreeSet, fmt, str::FromStr};

use mimesh_document::{Diagnostic, Kind};

use crate::text::count;

/// What is shown where frames cannot be read.
const EXAMPLE: &str = "expected frames from 0 as `7`, `0-24`, `0-99:10` or `1-3,5,7-20:2`";

/// Frames in the order of a run, counted from 0, as they were given.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Frames {
    ranges: Vec<Range>,
}

/// Every `step`-th frame from `first` to `last`, which both belong to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Range {
    first: usize,
    last: usize,
    step: usize,
}

impl Frames {
    /// The frames of a run with so many poses, in order, each once.
    ///
    /// # Errors
    ///
    /// [`Kind::Usage`] if a frame lies beyond the last pose.
    pub fn of(&self, poses: usize) -> Result<Vec<usize>, Diagnostic> {
        let largest = self.ranges.iter().map(|range| range.last).max().unwrap_or(0);
        if largest >= poses {
            let message = format!("frame {largest} of {}", count(poses, "pose", "poses"));
            let hint = format!("frames count from 0, so that the last is {}", poses.saturating_sub(1));
            return Err(Diagnostic::new(Kind::Usage, message).hint(hint));
        }
        let all = self.ranges.iter().flat_map(|range| (range.first..=range.last).step_by(range.step));
        Ok(all.collect::<BTreeSet<_>>().into_iter().collect())
    }
}

impl FromStr for Frames {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let ranges = text.split(',').map(|part| range(part.trim())).collect::<Result<_, _>>()?;
        Ok(Self { ranges })
    }
}

/// `7`, `0-24` or `0-99:10`.
fn range(text: &str) -> Result<Range, String> {
    let (ends, step) = match text.split_once(':') {
        Some((ends, step)) => (ends, Some(number(step)?)),
        None => (text, None),
    };
    let (first, last) = match ends.split_once('-') {
        Some((first, last)) => (number(first)?, number(last)?),
        None if step.is_some() => return Err(format!("`{text}` has a step, but no end; {EXAMPLE}")),
        None => (number(ends)?, number(ends)?),
    };
    if last < first {
        return Err(format!("`{text}` ends before it begins; {EXAMPLE}"));
    }
    match step {
        Some(0) => Err(format!("`{text}` has no step; {EXAMPLE}")),
        step => {
            let step = step.unwrap_or(1);
            // The last frame that is reached.
            Ok(Range { first, last: first + (last - first) / step * step, step })
        }
    }
}

fn number(text: &str) -> Result<usize, String> {
    let digits = text.trim();
    let is_number = !digits.is_empty() && digits.bytes().all(|byte| byte.is_ascii_digit());
    digits.parse().ok().filter(|_| is_number).ok_or_else(|| format!("`{digits}` is no frame; {EXAMPLE}"))
}

/// Ascending frames in the notation that [`Frames`] reads, as short as ranges make it: `0-3,7`.
pub fn in_ranges(frames: &[usize]) -> String {
    let mut ranges: Vec<Range> = Vec::new();
    for &frame in frames {
        match ranges.last_mut() {
            Some(range) if range.last + 1 == frame => range.last = frame,
            _ => ranges.push(Range { first: frame, last: frame, step: 1 }),
        }
    }
    Frames { ranges }.to_string()
}

impl fmt::Display for Frames {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, Range { first, last, step }) in self.ranges.iter().enumerate() {
            let comma = if i == 0 { "" } else { "," };
            write!(f, "{comma}{first}")?;
            if first != last {
                write!(f, "-{last}")?;
            }
            if first != last && *step != 1 {
                write!(f, ":{step}")?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: &str, poses: usize) -> Vec<usize> {
        text.parse::<Frames>().unwrap().of(poses).unwrap()
    }

    #[test]
    fn numbers_ranges_steps_and_lists() {
        assert_eq!(of("7", 8), [7]);
        assert_eq!(of("0-3", 4), [0, 1, 2, 3]);
        assert_eq!(of("1-3,5,7-20:6", 30), [1, 2, 3, 5, 7, 13, 19]);
        assert_eq!(of(" 5 , 1-2 , 2 ", 6), [1, 2, 5], "in order, each once");
        assert_eq!(of("0-9:4", 9), [0, 4, 8], "a frame that is not reached may lie beyond the last");
    }

    #[test]
    fn what_cannot_be_read_is_named_with_an_example() {
        for wrong in ["", "a", "1-", "-1", "1--2", "1,", "3-1", "1-3:0", "1-3:", "4:2", "1-2-3", "+1", "1.5", "９"] {
            let told = wrong.parse::<Frames>().unwrap_err();
            assert!(told.contains("expected frames from 0 as `7`"), "{wrong}: {told}");
        }
        assert!("99999999999999999999999".parse::<Frames>().is_err());
    }

    #[test]
    fn frames_beyond_the_last_name_how_many_there_are_and_cost_nothing() {
        let diagnostic = "0-9999999999".parse::<Frames>().unwrap().of(12).unwrap_err();
        assert_eq!(diagnostic.kind, Kind::Usage);
        assert_eq!(
            diagnostic.to_string(),
            "frame 9999999999 of 12 poses\n  hint: frames count from 0, so that the last is 11"
        );
    }

    #[test]
    fn ranges_are_short_and_are_read_again() {
        assert_eq!(in_ranges(&[0, 1, 2, 3, 7]), "0-3,7");
        assert_eq!(in_ranges(&[5]), "5");
        assert_eq!(in_ranges(&[]), "");
        let frames = [0, 2, 3, 9, 10, 11];
        assert_eq!(of(&in_ranges(&frames), 12), frames);
        assert_eq!("1-3,5,7-19:6".parse::<Frames>().unwrap().to_string(), "1-3,5,7-19:6");
    }
}
