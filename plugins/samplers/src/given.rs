//! The vertices that the user lists.

use std::collections::HashMap;

use mimesh_core::{
    Error, Result,
    mesh::{Surface, SurfacePoint},
    register,
    stage::Sampler,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

register!(Sampler: Given);

/// The vertices that the settings list.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Given {
    /// The vertices as the file of the mesh counts them, from 0.
    pub vertices: Vec<u32>,
}

#[typetag::serde(name = "given")]
impl Sampler for Given {
    fn sample(&self, surface: &Surface) -> Result<Vec<SurfacePoint>> {
        if self.vertices.is_empty() {
            return Err(Error::data("`vertices` lists no vertex", "list at least one, e.g. `vertices: [0, 120]`"));
        }
        let mut seen = HashMap::new();
        let point = |&given: &u32| {
            let Some(&on_surface) = surface.vertex_of.get(given as usize) else {
                return Err(Error::data(
                    format!("vertex {given} does not exist: expected 0 to {}", surface.vertex_of.len() - 1),
                    "count vertices from 0, in the order of the file",
                ));
            };
            let Some(vertex) = on_surface else {
                return Err(Error::data(
                    format!("vertex {given} belongs to no polygon"),
                    "give a vertex of the surface; `mimesh inspect MESH` counts those that are not",
                ));
            };
            match seen.insert(vertex, given) {
                None => Ok(SurfacePoint::Vertex(vertex)),
                Some(other) if other == given => {
                    Err(Error::data(format!("vertex {given} is listed twice"), "list it once"))
                }
                Some(other) => Err(Error::data(
                    format!("vertices {other} and {given} are the same point of the surface: a seam runs between them"),
                    "list one of the two",
                )),
            }
        };
        self.vertices.iter().map(point).collect()
    }
}
