//! glTF 2.0, binary and text: rigged, morphing and animated meshes in, one file with all poses out.
//!
//! In ([`read`]): the meshes of the default scene, one after another, each where its node or its joints place it; morph targets by
//! themselves or frames of clips are poses. The document model is that of `gltf-json`. Numbers are decoded here, since the `gltf`
//! crate reads quantised positions wrongly and panics on some damaged files.
//! Out ([`write`]): for a mesh that was read from a glTF, that file with morph targets added; for others a node an object, a primitive a
//! material, vertices cut along seams, one morph target a pose. [`document`] is what the two share.

pub(crate) mod document;
mod read;
#[cfg(test)]
mod tests;
mod write;

use mimesh_core::{
    Result,
    mesh::{Mesh, MeshSequence},
    plugin::check_ranges,
    register,
    spatial::{LengthUnit, MeshUnits, UpAxis},
    stage::{
        FileInput, Format, MeshWriter, ScenePoint, Selection, SequenceFile, SequenceFormat, SequenceWriter, WriteError,
    },
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use write::PoseAnimation;

use read::Asset;
use write::{Options, size, start};

register!(Format: Glb);
register!(Format: Gltf);

/// Binary glTF 2.0: one file with the rest mesh, a named morph target a pose, and animations that show them.
///
/// Vertices of the mesh keep their numbers in a mesh of one object; copies along seams follow them. Positions are f32.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Glb {
    /// Poses a second in the animation; the first is shown at 0 seconds.
    #[schemars(range(min = 0.001, max = 1_000_000.0))]
    pub frames_per_second: f64,
    /// Write the normals of every pose too: lit viewers need them, but they double the size.
    pub pose_normals: bool,
    /// The animation that shows the poses. Without one all morph targets are at 0 when the file is opened.
    pub animation: PoseAnimation,
    /// The unit of the target mesh; the file is in metres. A target that is a glTF itself stays as it is.
    pub unit: LengthUnit,
    /// The upward axis of the target mesh; the file has Y up. A target that is a glTF itself stays as it is.
    pub up: UpAxis,
}

impl Default for Glb {
    fn default() -> Self {
        Self {
            frames_per_second: 24.0,
            pose_normals: true,
            animation: PoseAnimation::default(),
            unit: LengthUnit::default(),
            up: UpAxis::default(),
        }
    }
}

impl Glb {
    fn options(&self) -> Options {
        let &Self { frames_per_second, pose_normals, animation, unit, up } = self;
        Options { frames_per_second, pose_normals, animation, unit, up, binary: true }
    }
}

/// glTF 2.0 as text with its numbers inside: as `glb`, a third larger, for tools that take no binary files.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Gltf {
    /// Poses a second in the animation; the first is shown at 0 seconds.
    #[schemars(range(min = 0.001, max = 1_000_000.0))]
    pub frames_per_second: f64,
    /// Write the normals of every pose too: lit viewers need them, but they double the size.
    pub pose_normals: bool,
    /// The animation that shows the poses. Without one all morph targets are at 0 when the file is opened.
    pub animation: PoseAnimation,
    /// The unit of the target mesh; the file is in metres. A target that is a glTF itself stays as it is.
    pub unit: LengthUnit,
    /// The upward axis of the target mesh; the file has Y up. A target that is a glTF itself stays as it is.
    pub up: UpAxis,
}

impl Default for Gltf {
    fn default() -> Self {
        let Glb { frames_per_second, pose_normals, animation, unit, up } = Glb::default();
        Self { frames_per_second, pose_normals, animation, unit, up }
    }
}

impl Gltf {
    fn options(&self) -> Options {
        let &Self { frames_per_second, pose_normals, animation, unit, up } = self;
        Options { frames_per_second, pose_normals, animation, unit, up, binary: false }
    }
}

#[typetag::serde(name = "glb")]
impl Format for Glb {
    fn extensions(&self) -> &'static [&'static str] {
        &["glb", "vrm"]
    }

    fn recognises(&self, start: &[u8], _: u64) -> Option<bool> {
        Some(start.starts_with(b"glTF"))
    }

    fn read(&self, input: &dyn FileInput, selection: &Selection) -> Result<MeshSequence> {
        read::read(input, selection)
    }

    fn references(&self, input: &dyn FileInput) -> Vec<String> {
        Asset::references(input)
    }

    fn holds_poses(&self) -> bool {
        true
    }

    fn holds_points(&self) -> bool {
        true
    }

    fn read_points(&self, input: &dyn FileInput) -> Result<Vec<ScenePoint>> {
        read::points(input)
    }

    fn writer(&self) -> Option<MeshWriter<'_>> {
        Some(MeshWriter::Sequence(self))
    }

    fn reads_in(&self) -> MeshUnits {
        MeshUnits::METRES_Y_UP
    }

    fn with_units(&self, units: MeshUnits) -> Option<Box<dyn Format>> {
        let (unit, up) = (units.unit.unwrap_or(self.unit), units.up.unwrap_or(self.up));
        Some(Box::new(Self { unit, up, ..self.clone() }))
    }
}

impl SequenceFormat for Glb {
    fn check_size(&self, mesh: &Mesh, poses: usize) -> Result<()> {
        size::check(&self.options(), mesh, poses)
    }

    fn start(
        &self,
        mesh: &Mesh,
        poses: usize,
        file: Box<dyn SequenceFile>,
    ) -> Result<Box<dyn SequenceWriter>, WriteError> {
        check_ranges(self)?;
        start(self.options(), mesh, poses, file)
    }
}

#[typetag::serde(name = "gltf")]
impl Format for Gltf {
    fn extensions(&self) -> &'static [&'static str] {
        &["gltf"]
    }

    fn recognises(&self, start: &[u8], _: u64) -> Option<bool> {
        let text = String::from_utf8_lossy(start);
        let has = |key: &str| text.contains(key);
        let is_object = text.trim_start_matches('\u{feff}').trim_start().starts_with('{');
        Some(is_object && (has("\"asset\"") || has("\"accessors\"") || has("\"bufferViews\"")))
    }

    fn read(&self, input: &dyn FileInput, selection: &Selection) -> Result<MeshSequence> {
        read::read(input, selection)
    }

    fn references(&self, input: &dyn FileInput) -> Vec<String> {
        Asset::references(input)
    }

    fn holds_poses(&self) -> bool {
        true
    }

    fn holds_points(&self) -> bool {
        true
    }

    fn read_points(&self, input: &dyn FileInput) -> Result<Vec<ScenePoint>> {
        read::points(input)
    }

    fn writer(&self) -> Option<MeshWriter<'_>> {
        Some(MeshWriter::Sequence(self))
    }

    fn reads_in(&self) -> MeshUnits {
        MeshUnits::METRES_Y_UP
    }

    fn with_units(&self, units: MeshUnits) -> Option<Box<dyn Format>> {
        let (unit, up) = (units.unit.unwrap_or(self.unit), units.up.unwrap_or(self.up));
        Some(Box::new(Self { unit, up, ..self.clone() }))
    }
}

impl SequenceFormat for Gltf {
    fn start(
        &self,
        mesh: &Mesh,
        poses: usize,
        file: Box<dyn SequenceFile>,
    ) -> Result<Box<dyn SequenceWriter>, WriteError> {
        check_ranges(self)?;
        start(self.options(), mesh, poses, file)
    }
}
