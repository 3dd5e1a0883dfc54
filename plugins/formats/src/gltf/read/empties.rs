//! Nodes that stand for points: empties of Blender and the like.

use std::collections::HashSet;

use mimesh_core::{
    Error, Result,
    stage::{FileInput, ScenePoint},
};
use nalgebra::Point3;

use super::{
    asset::{Asset, DAMAGED},
    nodes::Nodes,
    scene,
};

/// The named nodes of the default scene without a mesh, a camera, a light or a joint, where the file has them at rest.
///
/// A node above one of those is no point but its group. Joints are the nodes that a skin names.
///
/// # Errors
///
/// The errors of [`Asset::read`], and [`Error::File`] that names the node or scene that cannot be read.
pub fn points(input: &dyn FileInput) -> Result<Vec<ScenePoint>> {
    let damaged = |message: String| Error::file(input.path(), message, DAMAGED);
    let asset = Asset::read(input)?;
    let nodes = Nodes::new(&asset).map_err(damaged)?;
    let shown = scene::nodes(&asset).map_err(damaged)?;
    let worlds = nodes.worlds(&nodes.locals);
    nodes.check(&asset, &worlds).map_err(damaged)?;
    let joints: HashSet<usize> = (asset.root.skins.iter())
        .flat_map(|skin| skin.joints.iter().chain(&skin.skeleton))
        .map(|joint| joint.value())
        .collect();
    let is_used = |node: usize| {
        let json = &asset.json["nodes"][node];
        let extensions = &json["extensions"];
        let is_light = ["KHR_lights_punctual", "EXT_lights_ies"].iter().any(|light| !extensions[light].is_null());
        !json["mesh"].is_null() || !json["camera"].is_null() || is_light || joints.contains(&node)
    };
    // Groups of what is used are found from below.
    let mut used = HashSet::new();
    for &node in shown.iter().filter(|&&node| is_used(node)) {
        // Above a node that was seen before all are known.
        for above in nodes.with_ancestors(node) {
            if !used.insert(above) {
                break;
            }
        }
    }
    // Parents come before children.
    let mut below_joints = joints.clone();
    for &node in &shown {
        if nodes.parents[node].is_some_and(|parent| below_joints.contains(&parent)) {
            below_joints.insert(node);
        }
    }
    let point = |&node: &usize| {
        let name = asset.root.nodes[node].name.clone().filter(|name| !name.is_empty() && !used.contains(&node))?;
        let position = Point3::from(worlds[node].fixed_view::<3, 1>(0, 3).into_owned());
        let has_children = asset.root.nodes[node].children.as_ref().is_some_and(|children| !children.is_empty());
        let below_joint = below_joints.contains(&node);
        Some(ScenePoint { name, position, is_doubtful: has_children || below_joint })
    };
    Ok(shown.iter().filter_map(point).collect())
}
