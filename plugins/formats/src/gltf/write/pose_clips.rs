//! The animations that show poses: when each has its turn.

use mimesh_core::mesh::{ClipTime, PosesAre};

use super::options::PoseAnimation;

/// The poses of a file in the making, in order.
#[derive(Debug, Default)]
pub struct PoseList {
    /// Their names, unique.
    pub names: Vec<String>,
    /// The times in clips of those that are frames of one.
    pub times: Vec<Option<ClipTime>>,
    /// What they are, if that was said.
    pub are: Option<PosesAre>,
}

/// An animation that shows one pose a key, and blends from each to the next in between.
#[derive(Debug, PartialEq)]
pub struct PoseClip {
    /// The name.
    pub name: String,
    /// Times in seconds, which increase, and the poses shown then.
    pub keys: Vec<(f32, usize)>,
}

impl PoseList {
    /// The animations that `animation` asks for; `play` shows `frames_per_second` poses a second.
    pub fn clips(&self, animation: PoseAnimation, frames_per_second: f64) -> Vec<PoseClip> {
        match self.resolved(animation) {
            PoseAnimation::Play if !self.names.is_empty() => {
                let keys = (0..self.names.len()).map(|pose| ((pose as f64 / frames_per_second) as f32, pose));
                vec![PoseClip { name: "poses".into(), keys: keys.collect() }]
            }
            PoseAnimation::ClipTimes => self.by_clip(),
            _ => Vec::new(),
        }
    }

    /// A sentence for each wish about animations that these poses do not allow.
    pub fn warnings(&self, animation: PoseAnimation) -> Vec<String> {
        let without = self.times.iter().filter(|time| time.is_none()).count();
        if animation != PoseAnimation::ClipTimes || without == 0 {
            return Vec::new();
        }
        vec![format!("{without} of {} poses have no time in a clip, and no animation shows them", self.times.len())]
    }

    /// The choice that `auto` stands for.
    fn resolved(&self, animation: PoseAnimation) -> PoseAnimation {
        match animation {
            PoseAnimation::Auto => {
                let in_clips = self.times.iter().all(Option::is_some);
                let guess = || PosesAre::of_names(self.names.iter().map(String::as_str));
                match self.are {
                    Some(PosesAre::Shapes) => PoseAnimation::None,
                    _ if in_clips => PoseAnimation::ClipTimes,
                    are if are.unwrap_or_else(guess) == PosesAre::Frames => PoseAnimation::Play,
                    _ => PoseAnimation::None,
                }
            }
            other => other,
        }
    }

    /// One animation a clip, in order of first use.
    fn by_clip(&self) -> Vec<PoseClip> {
        let mut clips: Vec<PoseClip> = Vec::new();
        for (pose, time) in self.times.iter().enumerate() {
            let Some(time) = time else { continue };
            let key = (time.seconds as f32, pose);
            match clips.iter_mut().find(|clip| clip.name == time.clip) {
                Some(clip) => clip.keys.push(key),
                None => clips.push(PoseClip { name: time.clip.clone(), keys: vec![key] }),
            }
        }
        for clip in &mut clips {
            // glTF has times increase, from 0 at the earliest; the sort keeps the order of equal ones.
            clip.keys.retain(|(seconds, _)| seconds.is_finite() && *seconds >= 0.0);
            clip.keys.sort_by(|a, b| a.0.total_cmp(&b.0));
            clip.keys.dedup_by_key(|key| key.0);
        }
        clips.retain(|clip| !clip.keys.is_empty());
        clips
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn list(poses: &[(&str, Option<(&str, f64)>)]) -> PoseList {
        let time = |(clip, seconds): (&str, f64)| ClipTime { clip: clip.into(), seconds };
        PoseList {
            names: poses.iter().map(|pose| pose.0.to_owned()).collect(),
            times: poses.iter().map(|pose| pose.1.map(time)).collect(),
            are: None,
        }
    }

    #[test]
    fn shapes_are_not_played_and_frames_are() {
        let shapes = list(&[("smile", None), ("frown", None)]);
        assert_eq!(shapes.clips(PoseAnimation::Auto, 2.0), []);
        assert_eq!(shapes.clips(PoseAnimation::None, 2.0), []);
        let played = vec![PoseClip { name: "poses".into(), keys: vec![(0.0, 0), (0.5, 1)] }];
        assert_eq!(shapes.clips(PoseAnimation::Play, 2.0), played);
        let frames = list(&[("01", None), ("02", None)]);
        assert_eq!(frames.clips(PoseAnimation::Auto, 2.0), played);
        assert_eq!(frames.clips(PoseAnimation::None, 2.0), []);
        assert_eq!(list(&[]).clips(PoseAnimation::Play, 2.0), []);
        // What is said goes before names.
        let told = |poses: PoseList, are| PoseList { are: Some(are), ..poses };
        assert_eq!(told(frames, PosesAre::Shapes).clips(PoseAnimation::Auto, 2.0), []);
        assert_eq!(told(shapes, PosesAre::Frames).clips(PoseAnimation::Auto, 2.0), played);
    }

    #[test]
    fn frames_of_clips_keep_their_times() {
        let poses = list(&[
            ("a", Some(("Run", 0.5))),
            ("b", Some(("Walk", 0.0))),
            ("c", Some(("Run", 0.25))),
            ("d", Some(("Run", 0.5))),
        ]);
        let run = PoseClip { name: "Run".into(), keys: vec![(0.25, 2), (0.5, 0)] };
        let walk = PoseClip { name: "Walk".into(), keys: vec![(0.0, 1)] };
        assert_eq!(poses.clips(PoseAnimation::Auto, 24.0), [run, walk]);
    }

    #[test]
    fn poses_without_a_time_are_told_where_times_are_asked_for() {
        let poses = list(&[("a", Some(("Run", 0.5))), ("b", None)]);
        assert_eq!(poses.clips(PoseAnimation::Auto, 24.0), []);
        assert_eq!(poses.clips(PoseAnimation::ClipTimes, 24.0).len(), 1);
        assert_eq!(poses.warnings(PoseAnimation::Auto), [""; 0]);
        let told = "1 of 2 poses have no time in a clip, and no animation shows them";
        assert_eq!(poses.warnings(PoseAnimation::ClipTimes), [told]);
    }
}
