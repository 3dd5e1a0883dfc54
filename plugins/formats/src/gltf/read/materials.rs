//! Materials: their names and base colours.

use std::collections::HashSet;

use mimesh_core::mesh;

use super::asset::Asset;
use crate::names::all_distinct;

/// The names of materials, or their numbers; a name that an earlier one has is told apart by a number.
pub fn names(materials: &[gltf::json::Material]) -> Vec<String> {
    let given = |(index, material): (usize, &gltf::json::Material)| {
        let name = material.name.clone().filter(|name| !name.is_empty());
        name.unwrap_or_else(|| format!("material-{index}"))
    };
    all_distinct(materials.iter().enumerate().map(given))
}

/// The materials that are `used`, by number.
pub fn read(asset: &Asset, used: &HashSet<usize>) -> Vec<mesh::Material> {
    let names = names(&asset.root.materials).into_iter().enumerate().filter(|(index, _)| used.contains(index));
    names
        .map(|(index, name)| mesh::Material { name, base_color: base_color(asset, index), ..Default::default() })
        .collect()
}

/// The base colour, white where the file gives none that can be read.
fn base_color(asset: &Asset, index: usize) -> [f64; 4] {
    let factor = asset.json["materials"][index]["pbrMetallicRoughness"]["baseColorFactor"].as_array();
    let numbers: Option<Vec<f64>> = factor.and_then(|factor| factor.iter().map(|value| value.as_f64()).collect());
    numbers.and_then(|numbers| numbers.try_into().ok()).unwrap_or([1.0; 4])
}
