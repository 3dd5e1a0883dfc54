//! PC2, the point cache of 3ds Max and of modifiers in Blender.

use std::path::Path;

use mimesh_core::{
    Error, Result,
    mesh::{ClipTime, Mesh, MeshSequence},
    plugin::check_ranges,
    register,
    stage::{
        FileInput, Format, MeshWriter, ReadAt, Selection, SequenceFile, SequenceFormat, SequenceWriter, WriteError,
    },
};
use nalgebra::Point3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{
    samples::{DAMAGED, Samples, first_bytes, sequence},
    spool::Spool,
};

register!(Format: Pc2);

/// PC2, a point cache: the vertices of a mesh at evenly spaced frames, without the mesh.
///
/// In, its frames are poses of the rest mesh, which has as many vertices. Out, poses are appended one by one; the rest is not among
/// them. Positions are f32, in the unit and axes of the mesh.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Pc2 {
    /// Frames a second, which the file does not say: they turn its frames into seconds and back.
    #[schemars(range(min = 0.001, max = 1_000_000.0))]
    pub frames_per_second: f64,
}

impl Default for Pc2 {
    fn default() -> Self {
        Self { frames_per_second: 24.0 }
    }
}

#[typetag::serde(name = "pc2")]
impl Format for Pc2 {
    fn extensions(&self) -> &'static [&'static str] {
        &["pc2"]
    }

    fn read(&self, input: &dyn FileInput, selection: &Selection) -> Result<MeshSequence> {
        check_ranges(self)?;
        let file = input.open()?;
        let header = first_bytes(&*file, HEADER)?;
        let mut warnings = Vec::new();
        let samples = self.samples(input.path(), &header, file, &mut warnings);
        let samples = samples.map_err(|message| Error::file(input.path(), message, DAMAGED))?;
        sequence(input.path(), samples, selection, warnings)
    }

    fn holds_poses(&self) -> bool {
        true
    }

    fn holds_faces(&self) -> bool {
        false
    }

    fn writer(&self) -> Option<MeshWriter<'_>> {
        Some(MeshWriter::Sequence(self))
    }
}

impl SequenceFormat for Pc2 {
    fn start(
        &self,
        mesh: &Mesh,
        _poses: usize,
        file: Box<dyn SequenceFile>,
    ) -> Result<Box<dyn SequenceWriter>, WriteError> {
        check_ranges(self)?;
        let spool = Spool::new(file, HEADER, mesh.positions.len(), 1.0 / self.frames_per_second, f32::to_le_bytes)?;
        Ok(Box::new(Writer { spool, frames_per_second: self.frames_per_second }))
    }
}

/// The first bytes of a file.
const MAGIC: &[u8; 12] = b"POINTCACHE2\0";

/// Bytes before the positions.
const HEADER: usize = 32;

/// Frames by which a sample may miss its time: f32 holds no better frames of a long clip.
const UNEVEN: f64 = 1e-2;

impl Pc2 {
    /// The header: magic, version, points a sample, first frame, frames a sample, samples; numbers are little-endian.
    fn samples(
        &self,
        path: &Path,
        bytes: &[u8],
        file: Box<dyn ReadAt>,
        warnings: &mut Vec<String>,
    ) -> Result<Samples, String> {
        if bytes.get(..MAGIC.len()) != Some(MAGIC) {
            return Err("not a PC2: it does not start with `POINTCACHE2`".into());
        }
        let Some(header) = bytes.get(MAGIC.len()..HEADER) else {
            return Err(format!("the header takes {HEADER} bytes, the file has {}", bytes.len()));
        };
        let word = |index: usize| -> [u8; 4] { header[4 * index..][..4].try_into().expect("the slice has four bytes") };
        let (version, [points, samples]) = (i32::from_le_bytes(word(0)), [1, 4].map(|i| i32::from_le_bytes(word(i))));
        if version != 1 {
            return Err(format!("PC2 of version {version}: expected 1"));
        }
        let (Ok(points), Ok(count)) = (usize::try_from(points), usize::try_from(samples)) else {
            return Err(format!("{samples} samples of {points} points: expected numbers above 0"));
        };
        let [start, rate] = [2, 3].map(|index| f64::from(f32::from_le_bytes(word(index))));
        if !(start.is_finite() && rate > 0.0 && rate.is_finite()) {
            return Err(format!(
                "first frame {start} and {rate} frames a sample: expected finite numbers, the second above 0"
            ));
        }
        // Times that the file has no room for are not made.
        Samples::check_length(&*file, HEADER as u64, [count, points], warnings)?;
        let times = (0..count).map(|sample| (start + sample as f64 * rate) / self.frames_per_second).collect();
        Ok(Samples { file, path: path.into(), start: HEADER as u64, points, times, decode: f32::from_le_bytes })
    }
}

/// A file in the making.
struct Writer {
    spool: Spool,
    frames_per_second: f64,
}

impl Writer {
    /// The first frame, and the frames from sample to sample.
    fn first_and_rate(&self) -> [f64; 2] {
        let times = &self.spool.times;
        let (Some(first), Some(last)) = (times.first(), times.last()) else { return [0.0, 1.0] };
        let steps = times.len() - 1;
        let rate = if steps > 0 { (last - first) * self.frames_per_second / steps as f64 } else { 1.0 };
        [first * self.frames_per_second, rate]
    }
}

impl SequenceWriter for Writer {
    fn add(&mut self, name: &str, time: Option<&ClipTime>, positions: &[Point3<f64>]) -> Result<(), WriteError> {
        self.spool.add(name, time, positions)
    }

    fn warnings(&self) -> Vec<String> {
        let mut warnings = self.spool.warnings();
        let [first, rate] = self.first_and_rate();
        let frames = self.spool.times.iter().map(|time| time * self.frames_per_second);
        if frames.enumerate().any(|(sample, frame)| (frame - first - sample as f64 * rate).abs() > UNEVEN) {
            warnings.push("PC2 has evenly spaced frames: the times of the poses are not kept; mdd keeps them".into());
        }
        warnings
    }

    fn finish(self: Box<Self>) -> Result<(), WriteError> {
        let (count, points) = (Spool::count(self.spool.times.len())?, Spool::count(self.spool.points)?);
        let [first, rate] = self.first_and_rate();
        let mut header = MAGIC.to_vec();
        header.extend_from_slice(&1_i32.to_le_bytes());
        header.extend_from_slice(&points.to_le_bytes());
        header.extend_from_slice(&(first as f32).to_le_bytes());
        header.extend_from_slice(&(rate as f32).to_le_bytes());
        header.extend_from_slice(&count.to_le_bytes());
        self.spool.finish(&header)
    }
}
