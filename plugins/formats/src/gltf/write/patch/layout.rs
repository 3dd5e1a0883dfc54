//! Whether the placements of a document describe a mesh, and which nodes show a mesh of the file.

use std::collections::HashMap;

use mimesh_core::mesh::Mesh;
use serde_json::Value;

use super::stored::{list, number};
use crate::gltf::document::{GltfDocument, Placement, Transforms};

/// Whether the placements of `document` are about the vertices of `mesh`.
///
/// A stage that made another mesh of it, e.g. a finer one, may have kept the document.
pub fn describes(document: &GltfDocument, mesh: &Mesh) -> bool {
    let mut end = 0;
    let in_order = document.placements.iter().all(|placement| {
        let follows = placement.vertices.start == end && fits(document, placement);
        end = placement.vertices.end;
        follows
    });
    in_order && end == mesh.positions.len() && end > 0
}

fn fits(document: &GltfDocument, placement: &Placement) -> bool {
    let count = placement.vertices.len();
    let transforms = match &placement.scene_from_stored {
        Transforms::Uniform(_) => count,
        Transforms::Skinned(matrices) => matrices.len(),
    };
    let node = list(&document.json, "nodes").get(placement.node);
    let Some(mesh) = list(&document.json, "meshes").get(placement.mesh) else { return false };
    placement.stored.len() == count
        && transforms == count
        && node.is_some_and(|node| number(node, "mesh") == Some(placement.mesh))
        && placement.primitives.iter().all(|&primitive| {
            let primitive = list(mesh, "primitives").get(primitive);
            primitive.and_then(|primitive| vertex_count(&document.json, primitive)) == Some(count)
        })
}

/// The accessor of a primitive's positions.
pub fn position(primitive: &Value) -> Option<usize> {
    number(primitive.get("attributes")?, "POSITION")
}

/// The vertices of a primitive, by its positions or else by any attribute.
pub fn vertex_count(json: &Value, primitive: &Value) -> Option<usize> {
    let attributes = primitive.get("attributes")?.as_object()?;
    let accessor = position(primitive).or_else(|| attributes.values().find_map(super::stored::whole))?;
    number(list(json, "accessors").get(accessor)?, "count")
}

/// The morph targets of a mesh: those of the primitive that has most.
pub fn target_count(mesh: &Value) -> usize {
    list(mesh, "primitives").iter().map(|primitive| list(primitive, "targets").len()).max().unwrap_or(0)
}

/// A node of the file with the placements of its mesh.
#[derive(Debug)]
pub struct Shown {
    /// The node.
    pub node: usize,
    /// Its mesh.
    pub mesh: usize,
    /// Entries of the document's placements.
    pub placements: Vec<usize>,
}

/// The nodes of all placements, in order.
pub fn shown(document: &GltfDocument) -> Vec<Shown> {
    let mut nodes: Vec<Shown> = Vec::new();
    let mut entries = HashMap::new();
    for (index, &Placement { node, mesh, .. }) in document.placements.iter().enumerate() {
        let entry = *entries.entry(node).or_insert(nodes.len());
        match nodes.get_mut(entry) {
            Some(shown) => shown.placements.push(index),
            None => nodes.push(Shown { node, mesh, placements: vec![index] }),
        }
    }
    nodes
}

/// The name of mesh `index` for messages.
pub fn mesh_name(json: &Value, index: usize) -> String {
    let name =
        list(json, "meshes").get(index).and_then(|mesh| mesh.get("name")?.as_str()).filter(|name| !name.is_empty());
    name.map_or_else(|| format!("mesh-{index}"), str::to_owned)
}
