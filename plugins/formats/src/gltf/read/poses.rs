//! The rest and the poses that a selection asks for.

use std::collections::HashSet;

use mimesh_core::{
    mesh::ClipTime,
    stage::{ClipChoice, ClipTimes, PoseChoice, RestShape},
};

use super::{
    asset::quoted,
    clips::{self, Clip},
    evaluator::{Evaluator, Morphs, Shape},
    names::all_distinct,
};

/// No clip is cut into more poses: such numbers come from a mistake in the frames a second or in the file.
const MAX_POSES: usize = 1_000_000;

/// A morph target of the file that counts as a shape by itself.
#[derive(Debug)]
pub struct NamedShape {
    /// The name, unique in the file.
    pub name: String,
    /// The runs of vertices that it moves, and their targets.
    pub targets: Vec<(usize, usize)>,
}

/// A pose to be.
#[derive(Debug)]
pub struct Chosen {
    /// The name, unique in the file.
    pub name: String,
    /// The clip and the time that it is of.
    pub time: Option<ClipTime>,
    /// The shape.
    pub shape: Shape,
}

/// The shape of the rest; a time that a clip does not have is told in `warnings`.
///
/// # Errors
///
/// Names the shape or clip that the file does not have, and those that it has.
pub fn rest(
    choice: &RestShape,
    shapes: &[NamedShape],
    clips: &[Clip],
    warnings: &mut Vec<String>,
) -> Result<Shape, String> {
    match choice {
        RestShape::Stored => Ok(Shape::default()),
        RestShape::Pose(name) => {
            let found = shapes.iter().find(|shape| shape.name == *name);
            let targets = found.map(|shape| shape.targets.clone()).ok_or_else(|| {
                let names: Vec<_> = shapes.iter().map(|shape| &shape.name).collect();
                match &names[..] {
                    [] => format!("no morph target is called `{name}`: the file has none"),
                    names => format!("no morph target is called `{name}`: the file has {}", quoted(names)),
                }
            })?;
            Ok(Shape { clip: None, morphs: Morphs::Only(targets) })
        }
        RestShape::Clip { name, seconds } => {
            let clip = clips::find(clips, name)?;
            if !seconds.is_finite() {
                return Err(format!("time {seconds} of the clip `{name}`: expected a number of seconds"));
            }
            let [first, last] = clips[clip].span();
            if *seconds > last + slack(last) || *seconds < first.min(0.0) {
                let end = if *seconds > last { last } else { first };
                warnings.push(format!(
                    "the clip `{name}` has no time {seconds} s: the rest is that of {end} s, its nearest"
                ));
            }
            Ok(Shape { clip: Some((clip, *seconds)), morphs: Morphs::OfClip })
        }
    }
}

/// The poses; what clips add none is told in `warnings`.
///
/// # Errors
///
/// Names the clip that the file does not have, or the times that it does not have.
pub fn choose(
    choice: &PoseChoice,
    rest: &Shape,
    shapes: &[NamedShape],
    evaluator: &Evaluator,
    warnings: &mut Vec<String>,
) -> Result<Vec<Chosen>, String> {
    match choice {
        PoseChoice::Nothing => Ok(Vec::new()),
        // Morph targets move the mesh where the rest has it.
        PoseChoice::Shapes => Ok(shapes
            .iter()
            .map(|shape| Chosen {
                name: shape.name.clone(),
                time: None,
                shape: Shape { clip: rest.clip, morphs: Morphs::Only(shape.targets.clone()) },
            })
            .collect()),
        PoseChoice::Clips(choice) => frames(choice, evaluator, warnings),
    }
}

/// The poses of clips, in order of the clips and of their times.
fn frames(choice: &ClipChoice, evaluator: &Evaluator, warnings: &mut Vec<String>) -> Result<Vec<Chosen>, String> {
    let clips = &evaluator.clips;
    if clips.is_empty() && choice.clips.is_empty() {
        return Err("the file has no clip".into());
    }
    let mut chosen: Vec<usize> = match &choice.clips[..] {
        [] => (0..clips.len()).collect(),
        names => names.iter().map(|name| clips::find(clips, name)).collect::<Result<_, _>>()?,
    };
    let mut seen = HashSet::new();
    chosen.retain(|clip| seen.insert(*clip));
    let (nodes, morphing) = evaluator.moving_nodes();
    let (mut frames, mut still) = (Vec::new(), Vec::new());
    for clip in chosen {
        let key_times = clips[clip].key_times(&nodes, &morphing);
        let name = &clips[clip].name;
        if key_times.is_empty() {
            still.push(name.clone());
            continue;
        }
        let times = times(choice, &clips[clip], &key_times)?;
        // At least two digits, so that the names of a short clip do not change with its length.
        let digits = (times.len().max(1) - 1).to_string().len().max(2);
        for (number, &seconds) in times.iter().enumerate() {
            let pose = if times.len() == 1 { name.clone() } else { format!("{name}-{number:0digits$}") };
            let time = Some(ClipTime { clip: name.clone(), seconds });
            frames.push(Chosen {
                name: pose,
                time,
                shape: Shape { clip: Some((clip, seconds)), morphs: Morphs::OfClip },
            });
        }
    }
    if !still.is_empty() {
        warnings.push(format!("clips that do not move the mesh: {}", quoted(&still)));
    }
    let names = all_distinct(frames.iter().map(|frame| frame.name.clone()));
    frames.iter_mut().zip(names).for_each(|(frame, name)| frame.name = name);
    Ok(frames)
}

/// Times of keys are f32, so that a given time up to `end` may miss one by its rounding.
fn slack(end: f64) -> f64 {
    1e-6 * end.max(1.0)
}

/// The times at which to look at a clip.
fn times(choice: &ClipChoice, clip: &Clip, key_times: &[f64]) -> Result<Vec<f64>, String> {
    let [first, last] = clip.span();
    let [start, end] = choice.range.unwrap_or([first, last]);
    if !(start <= end && end - start < f64::INFINITY) {
        return Err(format!("range {start} to {end} of the clip `{}`: expected a start before the end", clip.name));
    }
    let slack = slack(start.abs().max(end.abs()));
    if start > last + slack {
        return Err(format!("the clip `{}` ends at {last} s, before {start} s", clip.name));
    }
    match choice.times {
        ClipTimes::Keys => {
            let is_inside = |time: &f64| (start - slack..=end + slack).contains(time);
            Ok(key_times.iter().copied().filter(is_inside).collect())
        }
        ClipTimes::PerSecond(rate) if rate > 0.0 && rate.is_finite() => {
            let end = end.min(last.max(start));
            let count = ((end - start + slack) * rate).floor();
            if count >= MAX_POSES as f64 {
                return Err(format!("{rate} poses a second of the clip `{}` are more than {MAX_POSES}", clip.name));
            }
            Ok((0..=count as usize).map(|frame| (start + frame as f64 / rate).min(end)).collect())
        }
        ClipTimes::PerSecond(rate) => Err(format!("{rate} poses a second: expected a number above 0")),
    }
}
