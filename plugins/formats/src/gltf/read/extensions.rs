//! Extensions that a file requires: only those that change what is read are refused.

use std::collections::BTreeSet;

use gltf::json::{Accessor, Index, mesh::Primitive};
use serde_json::{Map, Value};

use super::{asset::Asset, draco};
use crate::names::{quoted, shown};

/// The way out where a mesh is compressed.
pub const UNCOMPRESS: &str = "export it without compression, or undo it: `npx @gltf-transform/cli copy in.glb out.glb`";

/// Extensions of geometry that the readers know.
const KNOWN: [&str; 4] = ["KHR_mesh_quantization", draco::NAME, "EXT_meshopt_compression", "KHR_meshopt_compression"];

/// Refuses what cannot be read without an extension, where the primitives that `is_needed` chooses use it.
///
/// # Errors
///
/// A message that names mesh, primitive and extension, and a way out.
pub fn check(asset: &Asset, is_needed: &dyn Fn(usize, usize) -> bool) -> Result<(), (String, &'static str)> {
    let required: BTreeSet<&str> = asset.root.extensions_required.iter().map(String::as_str).collect();
    for (mesh_index, mesh) in asset.root.meshes.iter().enumerate() {
        for (index, primitive) in mesh.primitives.iter().enumerate() {
            if !is_needed(mesh_index, index) {
                continue;
            }
            let name = mesh.name.as_deref().map_or_else(|| mesh_index.to_string(), |name| format!("`{}`", shown(name)));
            let place = format!("mesh {name}, primitive {index}");
            if let Some(extension) = without_data(asset, primitive) {
                let message = format!("{place} is compressed with {}, which is not supported", shown(extension));
                return Err((message, UNCOMPRESS));
            }
            let used = used_by(asset, primitive);
            let unknown =
                used.iter().find(|&&name| required.contains(name) && !KNOWN.contains(&name) && !is_look(name));
            if let Some(extension) = unknown {
                let message = format!("{place} requires the extension {}, which is not supported", shown(extension));
                return Err((message, "export it without the extension"));
            }
        }
    }
    Ok(())
}

/// A sentence about the nodes whose extensions are not followed; `None` if there are none.
pub fn unread_of_nodes(asset: &Asset) -> Option<String> {
    let required: BTreeSet<&String> = asset.root.extensions_required.iter().collect();
    let mut names = BTreeSet::new();
    for extensions in asset.root.nodes.iter().filter_map(|node| node.extensions.as_ref()) {
        let is_unread =
            |name: &&String| *name == "EXT_mesh_gpu_instancing" || (required.contains(name) && !is_look(name));
        names.extend(extensions.others.keys().filter(is_unread).cloned());
    }
    let names: Vec<_> = names.into_iter().collect();
    (!names.is_empty()).then(|| format!("extensions of nodes are not followed: {}", quoted(&names)))
}

/// Whether an extension changes looks alone.
fn is_look(name: &str) -> bool {
    let prefixes = ["KHR_materials_", "KHR_texture_", "EXT_texture_", "MSFT_texture_", "KHR_lights_", "EXT_lights_"];
    prefixes.iter().any(|prefix| name.starts_with(prefix))
}

/// The extension that holds the positions of a primitive whose accessor has none.
fn without_data<'a>(asset: &'a Asset, primitive: &'a Primitive) -> Option<&'a str> {
    let position = super::primitive::attribute(primitive, gltf::json::mesh::Semantic::Positions)?;
    let is_unpacked = asset.unpacked.contains_key(&position.value());
    if draco::has_data(asset, position) || is_unpacked {
        return None;
    }
    let used = primitive.extensions.iter().flat_map(|extensions| extensions.others.keys());
    used.map(String::as_str).find(|name| !is_look(name))
}

/// The extensions of a primitive, its accessors, and their buffer views and buffers.
fn used_by<'a>(asset: &'a Asset, primitive: &'a Primitive) -> BTreeSet<&'a str> {
    let root = &asset.root;
    let targets = primitive.targets.iter().flatten().filter_map(|target| target.positions);
    let accessors = primitive.attributes.values().copied().chain(primitive.indices).chain(targets);
    let mut used = BTreeSet::new();
    let mut add = |others: Option<&'a Map<String, Value>>| {
        used.extend(others.into_iter().flat_map(Map::keys).map(String::as_str))
    };
    add(primitive.extensions.as_ref().map(|extensions| &extensions.others));
    for accessor in accessors.filter_map(|index: Index<Accessor>| root.accessors.get(index.value())) {
        add(accessor.extensions.as_ref().map(|extensions| &extensions.others));
        let sparse = accessor.sparse.iter().flat_map(|sparse| [sparse.indices.buffer_view, sparse.values.buffer_view]);
        for view in
            accessor.buffer_view.into_iter().chain(sparse).filter_map(|view| root.buffer_views.get(view.value()))
        {
            add(view.extensions.as_ref().map(|extensions| &extensions.others));
            let buffer = root.buffers.get(view.buffer.value());
            add(buffer.and_then(|buffer| Some(&buffer.extensions.as_ref()?.others)));
        }
    }
    used
}
