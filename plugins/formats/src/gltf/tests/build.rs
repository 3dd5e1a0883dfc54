//! Small GLBs, and what is written for them.

use mimesh_core::{
    mesh::{ClipTime, Mesh},
    stage::{MeshWriter, SequenceWriter},
    testkit::memory_file::MemoryFile,
};
use nalgebra::Point3;
use serde_json::{Value, json};

use crate::{
    Glb,
    gltf::write::{binary::Binary, output::Output},
};
use mimesh_core::stage::Format;

/// A GLB in the making.
pub struct Builder {
    file: MemoryFile,
    output: Output,
    pub binary: Binary,
    pub json: Value,
}

impl Builder {
    pub fn new(json: Value) -> Self {
        let file = MemoryFile::default();
        let (output, binary) = Output::new(Box::new(file.clone()), true).unwrap();
        Self { file, output, binary, json }
    }

    /// The attributes of a square of `side` in the plane z = 0 with normals along z, and its indices.
    pub fn square(&mut self, side: f32) -> Value {
        let positions = [[0.0, 0.0, 0.0], [side, 0.0, 0.0], [side, side, 0.0], [0.0, side, 0.0]];
        let position = self.binary.attribute(&positions, true).unwrap();
        let normal = self.binary.attribute(&[[0.0_f32, 0.0, 1.0]; 4], false).unwrap();
        let indices = self.binary.indices(&[0, 1, 2, 0, 2, 3], 4).unwrap();
        json!({ "attributes": { "POSITION": position, "NORMAL": normal }, "indices": indices })
    }

    pub fn glb(mut self) -> Vec<u8> {
        self.json["accessors"] = std::mem::take(&mut self.binary.accessors).into();
        self.json["bufferViews"] = std::mem::take(&mut self.binary.views).into();
        self.json["buffers"] = json!([{ "byteLength": self.binary.length() }]);
        self.output.finish(self.json, self.binary).unwrap();
        self.file.bytes()
    }
}

/// A pose to write: its name, its time and its positions.
pub type Written<'a> = (&'a str, Option<ClipTime>, Vec<Point3<f64>>);

/// A writer of `mesh` that has been given `poses`, into `file`.
fn writer(glb: &Glb, mesh: &Mesh, poses: &[Written], file: &MemoryFile) -> Box<dyn SequenceWriter> {
    let Some(MeshWriter::Sequence(format)) = glb.writer() else { unreachable!("a GLB is a sequence") };
    let mut writer = format.start(mesh, poses.len(), Box::new(file.clone())).unwrap();
    poses.iter().for_each(|(name, time, positions)| writer.add(name, time.as_ref(), positions).unwrap());
    writer
}

/// The GLB of `mesh` with `poses`, and the warnings.
pub fn write(glb: &Glb, mesh: &Mesh, poses: &[Written]) -> (Vec<u8>, Vec<String>) {
    let file = MemoryFile::default();
    let writer = writer(glb, mesh, poses, &file);
    let warnings = writer.warnings();
    writer.finish().unwrap();
    (file.bytes(), warnings)
}

/// The positions of `mesh`, moved along its diagonal and twisted.
pub fn twisted(mesh: &Mesh) -> Vec<Point3<f64>> {
    let size = mesh.diagonal();
    let twist = |p: &Point3<f64>| nalgebra::Rotation3::from_axis_angle(&nalgebra::Vector3::y_axis(), p.y / size) * p;
    mesh.positions.iter().map(|p| twist(p) + nalgebra::Vector3::new(0.1, 0.2, -0.1) * size).collect()
}
