//! Materials as a glTF holds them.

use mimesh_core::mesh::Mesh;
use serde_json::{Value, json};

use super::plan::Plan;

/// The materials that primitives name.
pub struct Materials<'a> {
    names: Vec<&'a str>,
    /// One a name, in order of first use.
    pub json: Vec<Value>,
}

impl<'a> Materials<'a> {
    /// Those of the primitives of `plan`, with the looks that `mesh` has for them.
    pub fn new(plan: &'a Plan, mesh: &Mesh) -> Self {
        let mut names: Vec<&str> = Vec::new();
        let primitives = plan.objects.iter().flat_map(|object| &object.primitives);
        for name in primitives.filter_map(|primitive| primitive.material.as_deref()) {
            if !names.contains(&name) {
                names.push(name);
            }
        }
        let json = names.iter().map(|name| material(mesh, name)).collect();
        Self { names, json }
    }

    /// The number of a material that a primitive names.
    pub fn index(&self, name: &str) -> usize {
        self.names.iter().position(|other| *other == name).expect("every material in use has an entry")
    }
}

/// A matt material; without a known colour it is white.
fn material(mesh: &Mesh, name: &str) -> Value {
    let known = mesh.materials.iter().find(|material| material.name == name);
    let color = known.map_or([1.0; 4], |material| material.base_color.map(|x| x.clamp(0.0, 1.0)));
    let mut json = json!({
        "name": name,
        "pbrMetallicRoughness": { "baseColorFactor": color, "metallicFactor": 0.0, "roughnessFactor": 1.0 },
    });
    if color[3] < 1.0 {
        json["alphaMode"] = "BLEND".into();
    }
    json
}
