//! Clips: the animation stacks of a file.

use std::collections::HashSet;

use mimesh_core::mesh::Animation;
use ufbx::{AnimCurve, AnimProp, AnimStack, ElementType, Node, Scene};

use super::{bind::skin, placed::Placed};
use crate::{clip_frames::ClipKeys, names::all_distinct};

/// The names of the clips: without the object before `|`, which Blender writes, where they stay apart.
pub fn names(scene: &Scene) -> Vec<String> {
    let given = |(index, stack): (usize, &AnimStack)| match &*stack.element.name {
        "" => index.to_string(),
        name => name.to_owned(),
    };
    let full: Vec<String> = scene.anim_stacks.iter().map(|stack| &**stack).enumerate().map(given).collect();
    let short: Vec<String> = full
        .iter()
        .map(|name| name.rsplit('|').next().filter(|last| !last.is_empty()).unwrap_or(name).into())
        .collect();
    let is_distinct = short.iter().collect::<HashSet<_>>().len() == short.len();
    all_distinct(if is_distinct { short } else { full })
}

/// The clips, with the keys that move the placed meshes.
pub fn clip_keys(scene: &Scene, placed: &[Placed]) -> Vec<ClipKeys> {
    let moving = moving_elements(scene, placed);
    let keys = |(stack, name): (&AnimStack, String)| {
        let curves = props(stack).filter(|prop| moving.contains(&prop.element.element_id)).flat_map(curves);
        let mut key_times: Vec<f64> =
            curves.flat_map(|curve| &curve.keyframes).map(|key| key.time).filter(|time| time.is_finite()).collect();
        key_times.sort_by(f64::total_cmp);
        key_times.dedup();
        ClipKeys { name, span: span(stack), key_times }
    };
    scene.anim_stacks.iter().map(|stack| &**stack).zip(names(scene)).map(keys).collect()
}

/// The clips as a file's list of them.
pub fn list(scene: &Scene) -> Vec<Animation> {
    let bones: HashSet<u32> = scene
        .skin_clusters
        .iter()
        .filter_map(|cluster| cluster.bone_node.as_ref())
        .map(|bone| bone.element.element_id)
        .collect();
    let describe = |(stack, name): (&AnimStack, String)| {
        let kind = |prop: &AnimProp| match prop.element.type_ {
            ElementType::BlendChannel => Some("morph targets"),
            ElementType::Node if bones.contains(&prop.element.element_id) => Some("skeleton"),
            ElementType::Node => Some("nodes"),
            _ => None,
        };
        let moved: HashSet<&str> = props(stack).filter_map(kind).collect();
        let channels = ["morph targets", "skeleton", "nodes"].into_iter().filter(|what| moved.contains(what));
        Animation { name, seconds: span(stack)[1], channels: channels.map(str::to_owned).collect() }
    };
    scene.anim_stacks.iter().map(|stack| &**stack).zip(names(scene)).map(describe).collect()
}

/// The times of a clip as the file gives them, else of its first and last key.
fn span(stack: &AnimStack) -> [f64; 2] {
    if stack.time_begin < stack.time_end && (stack.time_end - stack.time_begin).is_finite() {
        return [stack.time_begin, stack.time_end];
    }
    let curves = || props(stack).flat_map(curves).filter(|curve| !curve.keyframes.is_empty());
    let first = curves().map(|curve| curve.min_time).fold(f64::INFINITY, f64::min);
    let last = curves().map(|curve| curve.max_time).fold(f64::NEG_INFINITY, f64::max);
    if first.is_finite() && last.is_finite() { [first, last] } else { [0.0; 2] }
}

fn props(stack: &AnimStack) -> impl Iterator<Item = &AnimProp> {
    stack.layers.iter().flat_map(|layer| &layer.anim_props)
}

fn curves(prop: &AnimProp) -> impl Iterator<Item = &AnimCurve> {
    prop.anim_value.curves.iter().flatten().map(|curve| &**curve)
}

/// The nodes and blend shapes that move placed meshes.
fn moving_elements(scene: &Scene, placed: &[Placed]) -> HashSet<u32> {
    let mut moving = HashSet::new();
    let mut add_with_ancestors = |node: &Node| {
        let above = std::iter::successors(Some(node), |node| node.parent.as_deref());
        moving.extend(above.map(|node| node.element.element_id));
    };
    for placed in placed {
        let mesh = &scene.meshes[placed.mesh];
        match skin(mesh) {
            None => add_with_ancestors(&scene.nodes[placed.node]),
            Some(skin) => skin.clusters.iter().filter_map(|c| c.bone_node.as_deref()).for_each(&mut add_with_ancestors),
        }
    }
    for placed in placed {
        let deformers = &scene.meshes[placed.mesh].blend_deformers;
        moving.extend(deformers.iter().flat_map(|deformer| &deformer.channels).map(|c| c.element.element_id));
    }
    moving
}
