//! The rest and the poses that a selection asks for.

use mimesh_core::{
    mesh::ClipTime,
    stage::{PoseChoice, RestShape},
};

use super::{
    clips::Clip,
    evaluator::{Evaluator, Morphs, Shape},
};
use crate::{
    clip_frames::{ClipKeys, Frame, check_rest_time, frames},
    names::find,
};

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
            let shape = find("morph target", shapes.iter().map(|shape| shape.name.as_str()), name)?;
            let targets = shapes[shape].targets.clone();
            Ok(Shape { clip: None, morphs: Morphs::Only(targets) })
        }
        RestShape::Clip { name, seconds } => {
            let clip = find("clip", clips.iter().map(|clip| clip.name.as_str()), name)?;
            check_rest_time(name, clips[clip].span(), *seconds, warnings)?;
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
        PoseChoice::Clips(choice) => {
            let clips = clip_keys(evaluator);
            let pose = |frame: Frame| Chosen {
                time: Some(ClipTime { clip: clips[frame.clip].name.clone(), seconds: frame.seconds }),
                shape: Shape { clip: Some((frame.clip, frame.seconds)), morphs: Morphs::OfClip },
                name: frame.name,
            };
            Ok(frames(choice, &clips, warnings)?.into_iter().map(pose).collect())
        }
    }
}

/// The clips as frames are chosen from them.
fn clip_keys(evaluator: &Evaluator) -> Vec<ClipKeys> {
    let (nodes, morphing) = evaluator.moving_nodes();
    let keys = |clip: &Clip| ClipKeys {
        name: clip.name.clone(),
        span: clip.span(),
        key_times: clip.key_times(&nodes, &morphing),
    };
    evaluator.clips.iter().map(keys).collect()
}
