//! Materials: their names and base colours.

use std::collections::HashSet;

use mimesh_core::mesh;

use super::asset::Asset;

/// The names of materials, or their numbers; a name that an earlier one has is told apart by the number.
pub fn names(materials: &[gltf::json::Material]) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for (index, material) in materials.iter().enumerate() {
        names.push(match material.name.as_deref().filter(|name| !name.is_empty()) {
            None => format!("material-{index}"),
            Some(name) if materials[..index].iter().any(|earlier| earlier.name.as_deref() == Some(name)) => {
                format!("{name}-{index}")
            }
            Some(name) => name.into(),
        });
    }
    names
}

/// The materials that are `used`, by number.
pub fn read(asset: &Asset, used: &HashSet<usize>) -> Vec<mesh::Material> {
    let names = names(&asset.root.materials).into_iter().enumerate().filter(|(index, _)| used.contains(index));
    names.map(|(index, name)| mesh::Material { name, base_color: base_color(asset, index) }).collect()
}

/// The base colour, white where the file gives none that can be read.
fn base_color(asset: &Asset, index: usize) -> [f64; 4] {
    let factor = asset.json["materials"][index]["pbrMetallicRoughness"]["baseColorFactor"].as_array();
    let numbers: Option<Vec<f64>> = factor.and_then(|factor| factor.iter().map(|value| value.as_f64()).collect());
    numbers.and_then(|numbers| numbers.try_into().ok()).unwrap_or([1.0; 4])
}
