//! The meshes of the default scene, and those of them that are chosen.

use std::collections::HashSet;

use super::{
    asset::{Asset, follow, get},
    materials,
    primitive::is_thin,
};
use crate::names::unknown_part;

/// A node that shows a mesh.
#[derive(Clone, Debug)]
pub struct Placed {
    /// The node.
    pub node: usize,
    /// Its mesh.
    pub mesh: usize,
    /// The name of the node, else of the mesh, else its number.
    pub name: String,
    /// The primitives to read, by number.
    pub primitives: Vec<usize>,
}

/// The nodes with a mesh in the default scene, else the first, else in no scene at all; parents before children.
///
/// # Errors
///
/// Names the node, scene or mesh that does not exist.
pub fn placed(asset: &Asset) -> Result<Vec<Placed>, String> {
    let root = &asset.root;
    let mut found = Vec::new();
    for index in nodes(asset)? {
        let node = &root.nodes[index];
        if let Some(mesh) = node.mesh {
            let shown = follow(&root.meshes, mesh, "mesh")?;
            let name = node.name.as_ref().filter(|name| !name.is_empty()).or(shown.name.as_ref());
            let name = name.filter(|name| !name.is_empty()).cloned();
            let name = name.unwrap_or_else(|| format!("mesh-{mesh}"));
            found.push(Placed {
                node: index,
                mesh: mesh.value(),
                name,
                primitives: (0..shown.primitives.len()).collect(),
            });
        }
    }
    Ok(found)
}

/// The nodes of the default scene, else the first, else of no scene at all; each followed by those below it.
///
/// # Errors
///
/// Names the node or scene that does not exist, and a node that stands in two places.
pub fn nodes(asset: &Asset) -> Result<Vec<usize>, String> {
    let root = &asset.root;
    let mut pending = roots(asset)?;
    pending.reverse();
    let (mut found, mut seen) = (Vec::new(), HashSet::new());
    while let Some(index) = pending.pop() {
        let node = get(&root.nodes, index, "node")?;
        if !seen.insert(index) {
            return Err(format!("node {index} stands in two places of the scene"));
        }
        found.push(index);
        pending.extend(node.children.iter().flatten().rev().map(|child| child.value()));
    }
    Ok(found)
}

/// The nodes to start from.
fn roots(asset: &Asset) -> Result<Vec<usize>, String> {
    let root = &asset.root;
    let scene = match root.scene {
        Some(scene) => Some(follow(&root.scenes, scene, "scene")?),
        None => root.scenes.first(),
    };
    if let Some(scene) = scene {
        return Ok(scene.nodes.iter().map(|node| node.value()).collect());
    }
    let children: HashSet<_> =
        root.nodes.iter().flat_map(|node| node.children.iter().flatten()).map(|c| c.value()).collect();
    Ok((0..root.nodes.len()).filter(|node| !children.contains(node)).collect())
}

/// Keeps the primitives whose node, mesh or material has one of `names`; all if there are no names.
///
/// # Errors
///
/// Names a name that nothing has, and the names that there are.
pub fn choose(asset: &Asset, placed: &mut Vec<Placed>, names: &[String]) -> Result<(), String> {
    if names.is_empty() {
        return Ok(());
    }
    let materials = materials::names(&asset.root.materials);
    let mut known = HashSet::new();
    let mut all: [Vec<String>; 3] = Default::default();
    for placed in placed.iter_mut() {
        let mesh = &asset.root.meshes[placed.mesh];
        let mesh_name = mesh.name.as_deref().unwrap_or_default();
        placed.primitives.retain(|&index| {
            let primitive = &mesh.primitives[index];
            let material = primitive.material.and_then(|material| materials.get(material.value()));
            let own = [Some(placed.name.as_str()), Some(mesh_name), material.map(String::as_str)];
            let named = all.iter_mut().zip(own);
            named.for_each(|(all, name)| all.extend(name.filter(|name| !name.is_empty()).map(str::to_owned)));
            let chosen: Vec<_> = names.iter().filter(|name| own.contains(&Some(name.as_str()))).collect();
            known.extend(chosen.iter().copied());
            !chosen.is_empty()
        });
    }
    placed.retain(|placed| !placed.primitives.is_empty());
    match names.iter().find(|name| !known.contains(name)) {
        None => Ok(()),
        Some(name) => Err(unknown_part(name, &all)),
    }
}

/// Takes out the primitives of points and lines; the names of the nodes that had some.
pub fn drop_thin(asset: &Asset, placed: &mut [Placed]) -> Vec<String> {
    let mut thin = Vec::new();
    for placed in placed {
        let primitives = &asset.root.meshes[placed.mesh].primitives;
        let before = placed.primitives.len();
        placed.primitives.retain(|&index| !is_thin(&primitives[index]));
        if placed.primitives.len() < before {
            thin.push(placed.name.clone());
        }
    }
    thin
}
