//! The clips of a file: found by name, and cut into frames.

use std::collections::HashSet;

use mimesh_core::stage::{ClipChoice, ClipTimes};

use crate::names::{all_distinct, find, quoted, shown};

/// The clips of a file are cut into no more poses together.
///
/// Larger numbers come from a mistake in the frames a second or in the file: a few bytes of keys can ask for any of them.
const MAX_POSES: usize = 1_000_000;

/// A clip of a file, as far as choosing frames needs it.
#[derive(Clone, Debug)]
pub struct ClipKeys {
    /// The name, unique in the file.
    pub name: String,
    /// The first and the last time in seconds.
    pub span: [f64; 2],
    /// The times of the keys that move the mesh, in order, each once.
    pub key_times: Vec<f64>,
}

/// A frame of a clip.
#[derive(Debug)]
pub struct Frame {
    /// The name of the pose, unique among the frames.
    pub name: String,
    /// The clip, by number.
    pub clip: usize,
    /// The time in the clip.
    pub seconds: f64,
}

/// Checks the time of a rest in the clip called `name` of a span; one outside it is told in `warnings`.
///
/// # Errors
///
/// If `seconds` is no number.
pub fn check_rest_time(name: &str, span: [f64; 2], seconds: f64, warnings: &mut Vec<String>) -> Result<(), String> {
    if !seconds.is_finite() {
        return Err(format!("time {seconds} of the clip `{}`: expected a number of seconds", shown(name)));
    }
    let [first, last] = span;
    if seconds > last + slack(last) || seconds < first.min(0.0) {
        let end = if seconds > last { last } else { first };
        warnings.push(format!(
            "the clip `{}` has no time {seconds} s: the rest is that of {end} s, its nearest",
            shown(name)
        ));
    }
    Ok(())
}

/// The frames of clips, in order of the clips and of their times; what clips add none is told in `warnings`.
///
/// # Errors
///
/// Names the clip that the file does not have, or the times that it does not have.
pub fn frames(choice: &ClipChoice, clips: &[ClipKeys], warnings: &mut Vec<String>) -> Result<Vec<Frame>, String> {
    if clips.is_empty() && choice.clips.is_empty() {
        return Err("the file has no clip".into());
    }
    let names = || clips.iter().map(|clip| clip.name.as_str());
    let mut chosen: Vec<usize> = match &choice.clips[..] {
        [] => (0..clips.len()).collect(),
        chosen => chosen.iter().map(|name| find("clip", names(), name)).collect::<Result<_, _>>()?,
    };
    let mut seen = HashSet::new();
    chosen.retain(|clip| seen.insert(*clip));
    let (mut frames, mut still) = (Vec::new(), Vec::new());
    for clip in chosen {
        let keys = &clips[clip];
        let name = &keys.name;
        if keys.key_times.is_empty() {
            still.push(name.clone());
            continue;
        }
        let times = times(choice, keys, MAX_POSES - frames.len())?;
        // At least two digits, so that the names of a short clip do not change with its length.
        let digits = (times.len().max(1) - 1).to_string().len().max(2);
        for (number, &seconds) in times.iter().enumerate() {
            let name = if times.len() == 1 { name.clone() } else { format!("{name}-{number:0digits$}") };
            frames.push(Frame { name, clip, seconds });
        }
    }
    if !still.is_empty() {
        warnings.push(format!("clips that do not move the mesh: {}", quoted(&still)));
    }
    let names = all_distinct(frames.iter().map(|frame| frame.name.clone()));
    frames.iter_mut().zip(names).for_each(|(frame, name)| frame.name = name);
    Ok(frames)
}

fn too_many(clip: &ClipKeys) -> String {
    format!("with the clip `{}` the poses are more than {MAX_POSES}: choose some clips", shown(&clip.name))
}

/// Times of keys are f32, so that a given time up to `end` may miss one by its rounding.
fn slack(end: f64) -> f64 {
    1e-6 * end.max(1.0)
}

/// The times at which to look at a clip.
///
/// # Errors
///
/// If the clip has no such times, or more than `most`.
fn times(choice: &ClipChoice, clip: &ClipKeys, most: usize) -> Result<Vec<f64>, String> {
    let [first, last] = clip.span;
    let [start, end] = choice.range.unwrap_or([first, last]);
    if !(start <= end && end - start < f64::INFINITY) {
        return Err(format!(
            "range {start} to {end} of the clip `{}`: expected a start before the end",
            shown(&clip.name)
        ));
    }
    let slack = slack(start.abs().max(end.abs()));
    if start > last + slack {
        return Err(format!("the clip `{}` ends at {last} s, before {start} s", shown(&clip.name)));
    }
    match choice.times {
        ClipTimes::Keys => {
            let is_inside = |time: &f64| (start - slack..=end + slack).contains(time);
            let times: Vec<f64> = clip.key_times.iter().copied().filter(is_inside).collect();
            if times.len() > most {
                return Err(too_many(clip));
            }
            Ok(times)
        }
        ClipTimes::PerSecond(rate) if rate > 0.0 && rate.is_finite() => {
            let end = end.min(last.max(start));
            let count = ((end - start + slack) * rate).floor();
            if count >= MAX_POSES as f64 {
                return Err(format!(
                    "{rate} poses a second of the clip `{}` are more than {MAX_POSES}",
                    shown(&clip.name)
                ));
            }
            if count >= most as f64 {
                return Err(too_many(clip));
            }
            Ok((0..=count as usize).map(|frame| (start + frame as f64 / rate).min(end)).collect())
        }
        ClipTimes::PerSecond(rate) => Err(format!("{rate} poses a second: expected a number above 0")),
    }
}
