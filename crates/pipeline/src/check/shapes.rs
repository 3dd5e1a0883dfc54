//! The slot `shapes`: which poses are taken, under which names, and what becomes of them.

use std::collections::{HashMap, HashSet};

use mimesh_core::mesh::PosesAre;
use mimesh_document::{At, path};

use super::{
    findings::{Findings, Scope},
    shape_names::rename,
    shape_patterns::{Patterns, Shape},
    shape_regions::regions,
};
use crate::{
    input::{PoseInput, RestMesh},
    shapes::{ShapeEdit, ShapeSettings, side},
    text::some_of,
};

/// The poses that `settings` take, under the names of their results, each with what becomes of it.
pub(super) fn shapes(
    scope: Scope<'_>,
    found: &mut Findings,
    settings: Option<&ShapeSettings>,
    poses: Vec<PoseInput>,
    target: Option<&RestMesh>,
    has_map: bool,
) -> (Vec<PoseInput>, Vec<ShapeEdit>) {
    let Some(settings) = settings else {
        let edits = vec![ShapeEdit::default(); poses.len()];
        return (poses, edits);
    };
    let names: Vec<String> = poses.iter().map(|pose| pose.name.clone()).collect();
    let patterns = Patterns { scope, names: &names };
    let taken = taken(&patterns, found, settings, &poses);
    let mut shapes = mirrored(&patterns, found, settings, taken);
    let region = regions(&patterns, found, settings, &poses, target, has_map);
    let strengths = patterns.by_shape(found, "strengths", &settings.strengths);
    for shape in &mut shapes {
        let of_shape = strengths.get(&shape.shape).map(|strength| **strength);
        shape.edit.strength = of_shape.or(settings.strength).unwrap_or(1.0);
        shape.edit.region = region.get(&shape.shape).cloned();
    }
    rename(&patterns, found, settings, &mut shapes);
    // That the results of two of one name collide follows, and needs no diagnostic.
    let mut seen = HashSet::new();
    shapes.retain(|shape| seen.insert(shape.pose.name.clone()));
    shapes.into_iter().map(|shape| (shape.pose, shape.edit)).unzip()
}

/// Refuses masks for frames of a motion: all that a mask leaves out would stand still while the rest moves on.
pub(super) fn check_masks(
    scope: Scope<'_>,
    found: &mut Findings,
    settings: Option<&ShapeSettings>,
    poses_are: PosesAre,
) {
    if poses_are == PosesAre::Frames && settings.is_some_and(|settings| !settings.masks.is_empty()) {
        let message =
            "masks are for shapes, and the poses are frames of a motion: all outside of a mask would stand still";
        let hint =
            "leave `masks` out; if the poses are shapes that stand alone, say `poses_are: shapes` under `source`";
        found.wrong(scope, &path(["shapes", "masks"]), At::Key, message, hint);
    }
}

/// The shapes that `only` and `except` leave.
fn taken(patterns: &Patterns<'_>, found: &mut Findings, settings: &ShapeSettings, poses: &[PoseInput]) -> Vec<Shape> {
    let before = found.diagnostics.len();
    let mut fitting = |key: &str, items: &[String]| {
        let mut any = vec![false; poses.len()];
        for item in items {
            let fits = patterns.fits(found, &path(["shapes", key]), At::Value, item);
            any.iter_mut().zip(fits).for_each(|(any, fits)| *any |= fits);
        }
        any
    };
    let only = settings.only.as_ref().map(|only| fitting("only", &only.items));
    let except = settings.except.as_ref().map(|except| fitting("except", &except.items));
    let is_taken = |i: usize| only.as_ref().is_none_or(|only| only[i]) && except.as_ref().is_none_or(|e| !e[i]);
    let shape = |(_, pose): (usize, &PoseInput)| Shape {
        shape: pose.name.clone(),
        pose: pose.clone(),
        edit: ShapeEdit::default(),
    };
    let taken: Vec<Shape> = poses.iter().enumerate().filter(|(i, _)| is_taken(*i)).map(shape).collect();
    // Where a name is wrong, that none is left follows.
    if taken.is_empty() && !poses.is_empty() && found.diagnostics.len() == before {
        let hint = format!("shapes: {}", some_of(patterns.names));
        found.wrong(patterns.scope, &path(["shapes"]), At::Value, "`only` and `except` leave no shape", hint);
    }
    taken
}

/// The shapes with those of one side made from those of the other.
fn mirrored(
    patterns: &Patterns<'_>,
    found: &mut Findings,
    settings: &ShapeSettings,
    mut shapes: Vec<Shape>,
) -> Vec<Shape> {
    let Some(mirror) = settings.mirror else { return shapes };
    let mut made = 0;
    let mut result: Vec<Shape> = Vec::new();
    let from: HashMap<String, PoseInput> = shapes
        .iter()
        .filter_map(|shape| Some((side(&shape.shape).filter(|(side, _)| *side == mirror.from)?.1, shape.pose.clone())))
        .collect();
    // Shapes that are made anew keep their places; the others come after those that they are made from.
    let known: Vec<String> = shapes.iter().map(|shape| shape.shape.clone()).collect();
    let mirror_of = |name: &str, pose: &PoseInput| Shape {
        shape: name.to_owned(),
        pose: PoseInput { name: name.to_owned(), ..pose.clone() },
        edit: ShapeEdit { mirrored: Some(mirror.axis), ..ShapeEdit::default() },
    };
    for shape in shapes.drain(..) {
        if let Some(pose) = from.get(&shape.shape) {
            made += 1;
            result.push(mirror_of(&shape.shape, pose));
            continue;
        }
        let other = side(&shape.shape).filter(|(side, _)| *side == mirror.from).map(|(_, other)| other);
        let other = other.filter(|other| !known.contains(other)).map(|other| mirror_of(&other, &shape.pose));
        made += usize::from(other.is_some());
        result.push(shape);
        result.extend(other);
    }
    if made == 0 {
        let hint = "names of sides end or begin with left and right, as `eyeBlinkLeft`, `eyeBlink_L` or `L_Blink`";
        found.wrong(
            patterns.scope,
            &path(["shapes", "mirror"]),
            At::Value,
            "no shape is of the side to mirror from",
            hint,
        );
    }
    result
}
