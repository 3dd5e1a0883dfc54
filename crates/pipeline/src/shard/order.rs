//! The poses that a run computes, in their order, and where the motion begins that each is a frame of.

use std::collections::BTreeMap;

/// The poses that a run computes.
///
/// Frames of one motion are found from those before. A part of a motion therefore begins some frames earlier, from rest, and these *warm*
/// frames are thrown away. What comes after them is near the exact result, and never stands for it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PoseOrder {
    /// The poses by number, ascending.
    poses: Vec<usize>,
    /// Where the motions of frames begin, but for those that begin with the first frame of all.
    begins: BTreeMap<usize, usize>,
    /// The number of warm frames before a part.
    warm: usize,
}

impl PoseOrder {
    /// All poses of a run, each as exact as the run makes it.
    pub fn all(poses: usize) -> Self {
        Self { poses: (0..poses).collect(), ..Self::default() }
    }

    /// These poses, which stand alone.
    pub fn alone(poses: Vec<usize>) -> Self {
        Self { poses, ..Self::default() }
    }

    /// These frames of one motion; each stretch of them begins so many frames earlier.
    pub fn in_motion(frames: Vec<usize>, warm: usize) -> Self {
        let mut begins = BTreeMap::new();
        let mut before = None;
        for &frame in &frames {
            let begin = match before {
                Some((last, begin)) if last + 1 == frame => begin,
                _ => frame.saturating_sub(warm),
            };
            before = Some((frame, begin));
            if begin > 0 {
                begins.insert(frame, begin);
            }
        }
        Self { poses: frames, begins, warm }
    }

    /// All frames of a motion that was computed in parts: `begins` has where those begin that are not exact.
    pub fn of_parts(poses: usize, begins: BTreeMap<usize, usize>, warm: usize) -> Self {
        Self { poses: (0..poses).collect(), begins, warm }
    }

    /// The poses by number, ascending.
    pub fn poses(&self) -> &[usize] {
        &self.poses
    }

    /// The number of poses.
    pub fn len(&self) -> usize {
        self.poses.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.poses.is_empty()
    }

    /// The frame at which the motion of `pose` begins, from rest; 0 where its result is exact.
    pub fn begin(&self, pose: usize) -> usize {
        self.begins.get(&pose).copied().unwrap_or(0)
    }

    /// The number of warm frames before a part.
    pub fn warm(&self) -> usize {
        self.warm
    }

    /// The places in this order of the poses one and two before the `place`-th, where they are the poses before it.
    pub fn before<const N: usize>(&self, place: usize) -> [Option<usize>; N] {
        std::array::from_fn(|back| {
            let before = place.checked_sub(back + 1)?;
            (self.poses[before] + back + 1 == self.poses[place]).then_some(before)
        })
    }

    /// Whether the poses before the `place`-th, as far as there are any, are all in this order.
    pub fn has_all_before<const N: usize>(&self, place: usize) -> bool {
        let pose = self.poses[place];
        self.before::<N>(place).iter().enumerate().all(|(back, before)| before.is_some() || pose <= back)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_stretch_of_a_motion_begins_warm() {
        let order = PoseOrder::in_motion(vec![1, 2, 10, 11, 20], 4);
        let begins: Vec<_> = order.poses().iter().map(|&frame| order.begin(frame)).collect();
        assert_eq!(begins, [0, 0, 6, 6, 16], "near the first frame nothing is thrown away but what is exact");
        let whole = PoseOrder::in_motion((0..9).collect(), 0);
        assert!((0..9).all(|frame| whole.begin(frame) == 0));
    }

    #[test]
    fn poses_before_one_are_those_of_the_run() {
        let order = PoseOrder::alone(vec![0, 1, 4, 5, 6]);
        assert_eq!(order.before::<2>(1), [Some(0), None]);
        assert_eq!(order.before::<2>(2), [None, None], "3 is not there");
        assert_eq!(order.before::<2>(4), [Some(3), Some(2)]);
        let all: Vec<_> = (0..5).map(|place| order.has_all_before::<2>(place)).collect();
        assert_eq!(all, [true, true, false, false, true]);
    }
}
