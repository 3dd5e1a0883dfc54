//! From a file to a mesh with its poses.

use std::sync::Arc;

use mimesh_core::{
    Error, Result,
    mesh::{ClipTime, Document, MeshSequence, Pose, Positions},
    stage::{FileInput, PoseChoice, RestShape, Selection},
};
use ufbx::Scene;

use super::{
    bind::{Bind, Transforms},
    clips,
    evaluator::{Blend, Evaluator, Run, Shape},
    file::{self, DAMAGED},
    materials,
    placed::{self, Placed},
    shapes::{self, NamedShape},
    surface::{self, Assembled},
};
use crate::{
    clip_frames::{ClipKeys, check_rest_time, frames},
    extras::Extras,
    names::{find, quoted},
};

/// The way out where a file has no part of a name.
const CHOOSE: &str = "name parts that the file has, by their nodes, meshes or materials";

/// The way out where a file has no shape of a name.
const CHOOSE_SHAPE: &str = "`mimesh inspect` lists the morph targets and clips of a file";

/// Files with more vertices are refused: a small file that shows one mesh under many nodes must not ask for all memory.
const MAX_VERTICES: usize = 1 << 26;

/// A pose to be.
struct Chosen {
    name: String,
    time: Option<ClipTime>,
    shape: Shape,
}

/// Reads the chosen meshes of the scene as one, in place, and the chosen poses.
///
/// # Errors
///
/// Those of [`file::read`], and [`Error::File`] that names the mesh, shape or clip that cannot be read.
pub fn read(input: &dyn FileInput, selection: &Selection) -> Result<MeshSequence> {
    let path = input.path();
    let unknown = |message: String| Error::file(path, message, CHOOSE_SHAPE);

    let scene = file::read(input, selection.keep_document)?;
    let mut placed = placed::placed(&scene);
    placed::choose(&scene, &mut placed, &selection.meshes).map_err(|message| Error::file(path, message, CHOOSE))?;
    let thin = placed::drop_thin(&scene, &mut placed);
    let runs = runs(&scene, &placed).map_err(|message| Error::file(path, message, DAMAGED))?;
    let mut warnings = warnings(&scene, &placed, &thin);
    let shapes = shapes::shapes(&scene, &placed);
    let clips = clips::clip_keys(&scene, &placed);
    let animations = clips::list(&scene);

    let rest = rest(&selection.rest, &shapes, &clips, &mut warnings).map_err(unknown)?;
    let chosen = choose(&selection.poses, &rest, &shapes, &clips, &mut warnings).map_err(unknown)?;
    let poses = chosen.iter().map(|pose| pose.shape.clone()).collect();
    let (to_metres, bind) = (file::to_metres(&scene.settings), Bind::new(&scene));
    let evaluator = Evaluator { to_metres, bind, runs, poses, scene };

    let transforms: Vec<Transforms> = evaluator.transforms(&rest);
    let is_morphed = rest.blend != Blend::None;
    let assembled = surface::assemble(&evaluator.scene, &placed, &evaluator.runs, &transforms, is_morphed);
    let Assembled { mut mesh, materials: used, mut left_out } = assembled;
    mesh.positions = evaluator.shape(&rest);
    let (names, images) = (placed::material_names(&evaluator.scene), selection.keep_document);
    mesh.materials = materials::materials(input, &evaluator.scene, &names, &used, images, &mut left_out);
    mesh.document = Document::new(Extras { left_out, ..Extras::default() });
    match mesh.validate() {
        Err(Error::Data { message, hint }) => return Err(Error::file(path, message, hint)),
        other => other?,
    }
    let evaluator = Arc::new(evaluator);
    let pose = |(index, pose): (usize, Chosen)| Pose {
        name: pose.name,
        time: pose.time,
        positions: Positions::Computed(evaluator.clone(), index),
    };
    let poses = chosen.into_iter().enumerate().map(pose).collect();
    Ok(MeshSequence { rest: mesh, poses, animations, warnings, ..MeshSequence::default() })
}

/// The vertices of placed meshes, one mesh after another.
fn runs(scene: &Scene, placed: &[Placed]) -> Result<Vec<Run>, String> {
    let mut end = 0;
    let run = |placed: &Placed| {
        let count = scene.meshes[placed.mesh].vertices.len();
        if count > MAX_VERTICES - end {
            return Err(format!("there are more than {MAX_VERTICES} vertices; choose some meshes with `meshes`"));
        }
        let vertices = end..end + count;
        end = vertices.end;
        Ok(Run { node: placed.node, mesh: placed.mesh, vertices })
    };
    placed.iter().map(run).collect()
}

/// Warnings of what the rest or the mesh leaves out.
fn warnings(scene: &Scene, placed: &[Placed], thin: &[String]) -> Vec<String> {
    let mut warnings = file::warnings(scene);
    warnings.extend(file::unit_and_axes(&scene.settings));
    let shaped = shapes::stored_shapes(scene, placed);
    if !shaped.is_empty() {
        let names = quoted(&shaped);
        warnings.push(format!("the rest pose has all morph targets at 0, unlike the file's default: {names}"));
    }
    if !thin.is_empty() {
        warnings.push(format!("polygons of fewer than three corners were left out: {}", quoted(thin)));
    }
    let holds = |mesh: &Placed| !scene.meshes[mesh.mesh].cache_deformers.is_empty();
    let cached: Vec<&String> = placed.iter().filter(|placed| holds(placed)).map(|placed| &placed.name).collect();
    if !cached.is_empty() {
        warnings.push(format!("point caches beside the file were not read: {}", quoted(&cached)));
    }
    let curves = scene.nurbs_surfaces.len() + scene.nurbs_curves.len() + scene.line_curves.len();
    if curves > 0 {
        warnings.push(format!("curves and NURBS surfaces were left out: {curves}"));
    }
    warnings
}

/// The shape of the rest; a time that a clip does not have is told in `warnings`.
fn rest(
    choice: &RestShape,
    shapes: &[NamedShape],
    clips: &[ClipKeys],
    warnings: &mut Vec<String>,
) -> Result<Shape, String> {
    match choice {
        RestShape::Stored => Ok(Shape::default()),
        RestShape::Pose(name) => {
            let shape = find("morph target", shapes.iter().map(|shape| shape.name.as_str()), name)?;
            Ok(Shape { clip: None, blend: Blend::Only(shapes[shape].channels.clone()) })
        }
        RestShape::Clip { name, seconds } => {
            let clip = find("clip", clips.iter().map(|clip| clip.name.as_str()), name)?;
            check_rest_time(name, clips[clip].span, *seconds, warnings)?;
            Ok(Shape { clip: Some((clip, *seconds)), blend: Blend::OfClip })
        }
    }
}

/// The poses; what clips add none is told in `warnings`.
fn choose(
    choice: &PoseChoice,
    rest: &Shape,
    shapes: &[NamedShape],
    clips: &[ClipKeys],
    warnings: &mut Vec<String>,
) -> Result<Vec<Chosen>, String> {
    match choice {
        PoseChoice::Nothing => Ok(Vec::new()),
        // Blend shapes move the mesh where the rest has it.
        PoseChoice::Shapes => Ok(shapes
            .iter()
            .map(|shape| Chosen {
                name: shape.name.clone(),
                time: None,
                shape: Shape { clip: rest.clip, blend: Blend::Only(shape.channels.clone()) },
            })
            .collect()),
        PoseChoice::Clips(choice) => {
            let frames = frames(choice, clips, warnings)?.into_iter();
            Ok(frames
                .map(|frame| Chosen {
                    name: frame.name,
                    time: Some(ClipTime { clip: clips[frame.clip].name.clone(), seconds: frame.seconds }),
                    shape: Shape { clip: Some((frame.clip, frame.seconds)), blend: Blend::OfClip },
                })
                .collect())
        }
    }
}
