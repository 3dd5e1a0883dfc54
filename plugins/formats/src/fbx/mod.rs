//! FBX, binary and ASCII: meshes of the scene in; their blend shapes and the frames of their clips as poses.
//!
//! The crate `ufbx` reads the file and evaluates its animation; we place the vertices:
//! - [`file`]: the bytes, and the unit and axes;
//! - [`placed`]: the nodes with a mesh, and those that are chosen;
//! - [`bind`], [`shapes`] and [`clips`]: what places and moves vertices;
//! - [`evaluator`]: positions in any state of that;
//! - [`surface`], [`colors`], [`materials`] and [`reader`]: the mesh.

mod bind;
mod clips;
mod colors;
mod evaluator;
mod file;
mod materials;
mod placed;
mod reader;
mod shapes;
mod surface;

use mimesh_core::{
    Result,
    mesh::MeshSequence,
    register,
    spatial::MeshUnits,
    stage::{FileInput, Format, Selection},
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

register!(Format: Fbx);

/// FBX, binary or ASCII, for reading: meshes with skins, blend shapes and clips, in metres with Y up.
///
/// Vertices and polygons are numbered as in the file, mesh after mesh. Skinned meshes rest in their bind pose.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Fbx {}

#[typetag::serde(name = "fbx")]
impl Format for Fbx {
    fn extensions(&self) -> &'static [&'static str] {
        &["fbx"]
    }

    fn read(&self, input: &dyn FileInput, selection: &Selection) -> Result<MeshSequence> {
        reader::read(input, selection)
    }

    fn reads_in(&self) -> MeshUnits {
        MeshUnits::METRES_Y_UP
    }

    fn holds_poses(&self) -> bool {
        true
    }
}
