//! USD as text, out: a mesh whose points have a time sample a pose.

use std::io::{self, Write};

use mimesh_core::{
    Error, Result,
    mesh::{ClipTime, CornerAttribute, Mesh, MeshSequence},
    plugin::check_ranges,
    register,
    spatial::{LengthUnit, MeshUnits, UpAxis},
    stage::{FileInput, Format, MeshWriter, Selection, SequenceFile, SequenceFormat, SequenceWriter, WriteError},
};
use nalgebra::Point3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{single, tail::Tail};

register!(Format: Usda);

/// USD as text, for writing: one file with the rest mesh, and a time sample of its points a pose.
///
/// Polygons and texture coordinates are kept; materials, normals and names of poses are not. Positions are f32.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Usda {
    /// Frames a second; a pose without a time is the frame after the last.
    #[schemars(range(min = 0.001, max = 1_000_000.0))]
    pub frames_per_second: f64,
    /// The unit of the target mesh, which the file names.
    pub unit: LengthUnit,
    /// The upward axis of the target mesh, which the file names: Y or Z.
    pub up: UpAxis,
}

impl Default for Usda {
    fn default() -> Self {
        Self { frames_per_second: 24.0, unit: LengthUnit::default(), up: UpAxis::default() }
    }
}

#[typetag::serde(name = "usda")]
impl Format for Usda {
    fn extensions(&self) -> &'static [&'static str] {
        &["usda"]
    }

    fn read(&self, input: &dyn FileInput, _: &Selection) -> Result<MeshSequence> {
        Err(Error::file(input.path(), "USD is written, not read", "import it in Blender and export glTF 2.0 (.glb)"))
    }

    fn reads(&self) -> bool {
        false
    }

    fn writer(&self) -> Option<MeshWriter<'_>> {
        Some(MeshWriter::Sequence(self))
    }

    fn with_units(&self, units: MeshUnits) -> Option<Box<dyn Format>> {
        let (unit, up) = (units.unit.unwrap_or(self.unit), units.up.unwrap_or(self.up));
        Some(Box::new(Self { unit, up, ..self.clone() }))
    }
}

impl SequenceFormat for Usda {
    fn start(
        &self,
        mesh: &Mesh,
        _poses: usize,
        file: Box<dyn SequenceFile>,
    ) -> Result<Box<dyn SequenceWriter>, WriteError> {
        check_ranges(self)?;
        mesh.validate()?;
        single::check(mesh, &mesh.positions, "USD")?;
        if self.up == UpAxis::X {
            let hint = "write .glb, or turn the target to Y or Z up";
            return Err(Error::data("a USD has Y or Z up, and the target has X up", hint).into());
        }
        let mut still = Vec::new();
        write_mesh(&mut still, mesh)?;
        Ok(Box::new(Writer {
            settings: self.clone(),
            vertices: mesh.positions.len(),
            still,
            lost: lost(mesh),
            samples: Tail::new(file),
            last: None,
            first: 0.0,
            unnamed: false,
            restarted: false,
        }))
    }
}

/// A file in the making: the poses go behind room for the head, which has the last time.
struct Writer {
    settings: Usda,
    vertices: usize,
    /// The mesh at rest, as text.
    still: Vec<u8>,
    lost: Vec<&'static str>,
    samples: Tail,
    /// The frame of the last pose.
    last: Option<f64>,
    first: f64,
    unnamed: bool,
    restarted: bool,
}

impl SequenceWriter for Writer {
    fn add(&mut self, _: &str, time: Option<&ClipTime>, positions: &[Point3<f64>]) -> Result<(), WriteError> {
        Error::check_shape("posed target vertices (#V)", self.vertices, positions.len())?;
        single::check_positions(positions, single::MAX, "USD")?;
        let wanted = time.map(|time| time.seconds * self.settings.frames_per_second);
        self.unnamed |= wanted.is_none();
        let frame = match (wanted, self.last) {
            (Some(frame), Some(last)) if frame <= last => {
                self.restarted = true;
                last + 1.0
            }
            (Some(frame), _) => frame,
            (None, last) => last.map_or(0.0, |last| last + 1.0),
        };
        if self.last.is_none() {
            self.first = frame;
        }
        self.last = Some(frame);
        write!(self.samples, "            {}: ", rounded(frame))?;
        write_points(&mut self.samples, positions)?;
        writeln!(self.samples, ",")?;
        if self.samples.is_full() {
            // The last time grows by some digits.
            let room = self.head()?.len() as u64 + 64;
            self.samples.leave_room(room)?;
        }
        Ok(())
    }

    fn warnings(&self) -> Vec<String> {
        let mut warnings = Vec::new();
        if !self.lost.is_empty() {
            warnings.push(format!("not kept in USD: {}", self.lost.join(", ")));
        }
        if self.unnamed {
            warnings.push("the names of the poses are not kept: they are time samples, in their order".into());
        }
        if self.restarted {
            warnings.push("the file is one clip: the clips follow one another in it".into());
        }
        warnings
    }

    fn finish(mut self: Box<Self>) -> Result<(), WriteError> {
        let mut head = self.head()?;
        // Spaces before the first sample fill the room that was left.
        let room = usize::try_from(self.samples.room()).unwrap_or(usize::MAX);
        head.resize(head.len().max(room), b' ');
        let end: &[u8] = if self.last.is_some() { b"        }\n    }\n}\n" } else { b"    }\n}\n" };
        self.samples.write_all(end)?;
        Ok(self.samples.finish(&head)?)
    }
}

impl Writer {
    /// All that comes before the samples.
    fn head(&self) -> io::Result<Vec<u8>> {
        let mut out = Vec::new();
        let Usda { frames_per_second: rate, unit, up } = &self.settings;
        writeln!(out, "#usda 1.0\n(\n    defaultPrim = \"target\"\n    metersPerUnit = {}", unit.metres())?;
        let up = up.name().to_uppercase();
        writeln!(out, "    upAxis = \"{up}\"\n    timeCodesPerSecond = {rate}\n    framesPerSecond = {rate}")?;
        if let Some(last) = self.last {
            writeln!(out, "    startTimeCode = {}\n    endTimeCode = {}", rounded(self.first), rounded(last))?;
        }
        writeln!(out, ")\n\ndef Xform \"target\"\n{{\n    def Mesh \"mesh\"\n    {{")?;
        out.extend_from_slice(&self.still);
        if self.last.is_some() {
            writeln!(out, "        point3f[] points.timeSamples = {{")?;
        }
        Ok(out)
    }
}

/// What the file does not keep of a mesh.
fn lost(mesh: &Mesh) -> Vec<&'static str> {
    let lost = [
        (mesh.parts.iter().any(|part| part.material.is_some()), "materials"),
        (mesh.parts.len() > 1, "parts"),
        (mesh.normals.is_some(), "normals"),
        (mesh.polygons.iter().any(|polygon| polygon.len() < 3), "polygons of fewer than three corners"),
    ];
    lost.into_iter().filter(|(is_lost, _)| *is_lost).map(|(_, what)| what).collect()
}

/// Polygons, texture coordinates and the points at rest.
fn write_mesh(out: &mut Vec<u8>, mesh: &Mesh) -> io::Result<()> {
    let whole: Vec<usize> = (0..mesh.polygons.len()).filter(|&polygon| mesh.polygons.get(polygon).len() > 2).collect();
    writeln!(out, "        uniform token subdivisionScheme = \"none\"")?;
    let counts = whole.iter().map(|&polygon| mesh.polygons.get(polygon).len());
    writeln!(out, "        int[] faceVertexCounts = {}", list(counts))?;
    let corners = || whole.iter().flat_map(|&polygon| mesh.polygons.corner_range(polygon));
    let vertices = corners().map(|corner| mesh.polygons.corners()[corner]);
    writeln!(out, "        int[] faceVertexIndices = {}", list(vertices))?;
    write!(out, "        point3f[] points = ")?;
    write_points(out, &mesh.positions)?;
    writeln!(out)?;
    if let Some(CornerAttribute { values, indices }) = &mesh.texture_coordinates {
        // A corner without a value has the one added at the end.
        let coordinates = values.iter().chain([&[0.0; 2]]).map(|[u, v]| format!("({}, {})", *u as f32, *v as f32));
        let indices = corners().map(|corner| indices[corner].map_or(values.len(), |index| index as usize));
        writeln!(out, "        texCoord2f[] primvars:st = {} (interpolation = \"faceVarying\")", list(coordinates))?;
        writeln!(out, "        int[] primvars:st:indices = {}", list(indices))?;
    }
    Ok(())
}

fn write_points(out: &mut dyn Write, positions: &[Point3<f64>]) -> io::Result<()> {
    for (index, p) in positions.iter().enumerate() {
        let start = if index == 0 { "[" } else { ", " };
        write!(out, "{start}({}, {}, {})", p.x as f32, p.y as f32, p.z as f32)?;
    }
    write!(out, "]")
}

fn list<T: std::fmt::Display>(values: impl Iterator<Item = T>) -> String {
    let values: Vec<String> = values.map(|value| value.to_string()).collect();
    format!("[{}]", values.join(", "))
}

/// A frame without the rounding of seconds times frames a second.
fn rounded(frame: f64) -> f64 {
    (frame * 1e6).round() / 1e6
}
