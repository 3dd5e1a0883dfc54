//! The nodes that show a mesh, and those that are chosen.

use std::collections::{HashMap, HashSet};

use ufbx::{Mesh, Node, Scene};

use crate::names::{all_distinct, unknown_part};

/// A node that shows a mesh.
#[derive(Clone, Debug)]
pub struct Placed {
    /// The node, by its number in the scene.
    pub node: usize,
    /// Its mesh, by its number in the scene.
    pub mesh: usize,
    /// The name of the node, else of the mesh, else its number.
    pub name: String,
    /// The polygons to read, by number: those of three corners or more with a chosen material.
    pub polygons: Vec<usize>,
}

/// The nodes with a mesh, each before the nodes below it.
pub fn placed(scene: &Scene) -> Vec<Placed> {
    let mut pending: Vec<&Node> = vec![&scene.root_node];
    let mut found = Vec::new();
    while let Some(node) = pending.pop() {
        if let Some(mesh) = &node.mesh {
            let names = [&*node.element.name, &*mesh.element.name];
            let name = names.into_iter().find(|name| !name.is_empty()).map(str::to_owned);
            found.push(Placed {
                node: node.element.typed_id as usize,
                mesh: mesh.element.typed_id as usize,
                name: name.unwrap_or_else(|| format!("mesh-{}", mesh.element.typed_id)),
                polygons: (0..mesh.faces.len()).collect(),
            });
        }
        pending.extend(node.children.iter().rev().map(|child| &**child));
    }
    found
}

/// The names of the scene's materials, each once, by the number of the element.
pub fn material_names(scene: &Scene) -> HashMap<u32, String> {
    let given = scene.materials.iter().enumerate().map(|(index, material)| match &*material.element.name {
        "" => format!("material-{index}"),
        name => name.to_owned(),
    });
    scene.materials.iter().map(|material| material.element.element_id).zip(all_distinct(given)).collect()
}

/// The material of a polygon under a node, by the number of the element.
pub fn material_of(node: &Node, mesh: &Mesh, polygon: usize) -> Option<u32> {
    let slot = *mesh.face_material.get(polygon)? as usize;
    // A node may show the mesh with materials of its own.
    let material = node.materials.get(slot).or_else(|| mesh.materials.get(slot))?;
    Some(material.element.element_id)
}

/// Keeps the polygons whose node, mesh or material has one of `names`; all if there are no names.
///
/// # Errors
///
/// Names a name that nothing has, and the names that there are.
pub fn choose(scene: &Scene, placed: &mut Vec<Placed>, names: &[String]) -> Result<(), String> {
    if names.is_empty() {
        return Ok(());
    }
    let materials = material_names(scene);
    let mut known: HashSet<&String> = HashSet::new();
    let mut all: [Vec<String>; 3] = Default::default();
    for placed in placed.iter_mut() {
        let (node, mesh) = (&scene.nodes[placed.node], &scene.meshes[placed.mesh]);
        let own = [placed.name.as_str(), &*mesh.element.name];
        all.iter_mut().zip(own).filter(|(_, name)| !name.is_empty()).for_each(|(all, name)| all.push(name.into()));
        let of_mesh: Vec<_> = names.iter().filter(|name| own.contains(&name.as_str())).collect();
        known.extend(of_mesh.iter().copied());
        placed.polygons.retain(|&polygon| {
            let material = material_of(node, mesh, polygon).and_then(|material| materials.get(&material));
            let chosen = names.iter().find(|name| material == Some(name));
            known.extend(chosen);
            if let Some(material) = material.filter(|material| all[2].last() != Some(material)) {
                all[2].push(material.clone());
            }
            chosen.is_some() || !of_mesh.is_empty()
        });
    }
    placed.retain(|placed| !placed.polygons.is_empty());
    match names.iter().find(|name| !known.contains(name)) {
        None => Ok(()),
        Some(name) => Err(unknown_part(name, &all)),
    }
}

/// Takes out polygons of fewer than three corners; the names of the nodes that had some.
pub fn drop_thin(scene: &Scene, placed: &mut [Placed]) -> Vec<String> {
    let mut thin = Vec::new();
    for placed in placed {
        let faces = &scene.meshes[placed.mesh].faces;
        let before = placed.polygons.len();
        placed.polygons.retain(|&polygon| faces[polygon].num_indices > 2);
        if placed.polygons.len() < before {
            thin.push(placed.name.clone());
        }
    }
    thin
}
