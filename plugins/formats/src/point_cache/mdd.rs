//! MDD, the point cache of LightWave.

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

register!(Format: Mdd);

/// MDD, a point cache: the vertices of a mesh at given times, without the mesh.
///
/// In, its frames are poses of the rest mesh, which has as many vertices. Out, poses are appended one by one; the rest is not among
/// them. Positions are f32, in the unit and axes of the mesh.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Mdd {
    /// Frames a second of poses that have no time.
    #[schemars(range(min = 0.001, max = 1_000_000.0))]
    pub frames_per_second: f64,
}

impl Default for Mdd {
    fn default() -> Self {
        Self { frames_per_second: 24.0 }
    }
}

#[typetag::serde(name = "mdd")]
impl Format for Mdd {
    fn extensions(&self) -> &'static [&'static str] {
        &["mdd"]
    }

    fn read(&self, input: &dyn FileInput, selection: &Selection) -> Result<MeshSequence> {
        check_ranges(self)?;
        let file = input.open()?;
        let header = first_bytes(&*file, HEADER)?;
        let stored = frames_of(&header).map_or(0, |frames| frames.saturating_mul(4));
        let times = first_bytes(&*file, HEADER.saturating_add(stored))?;
        let mut warnings = Vec::new();
        let samples = self.samples(input.path(), &times, file, &mut warnings);
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

impl SequenceFormat for Mdd {
    fn start(
        &self,
        mesh: &Mesh,
        poses: usize,
        file: Box<dyn SequenceFile>,
    ) -> Result<Box<dyn SequenceWriter>, WriteError> {
        check_ranges(self)?;
        let spool =
            Spool::new(file, HEADER + 4 * poses, mesh.positions.len(), 1.0 / self.frames_per_second, f32::to_be_bytes)?;
        Ok(Box::new(Writer { spool }))
    }
}

/// Bytes before the times.
const HEADER: usize = 8;

impl Mdd {
    /// The header: frames, points, and the seconds of each frame; numbers are big-endian.
    fn samples(
        &self,
        path: &Path,
        bytes: &[u8],
        file: Box<dyn ReadAt>,
        warnings: &mut Vec<String>,
    ) -> Result<Samples, String> {
        let word = |at: usize| Some(<[u8; 4]>::try_from(bytes.get(at..at + 4)?).expect("the slice has four bytes"));
        let (Some(frames), Some(points)) = (word(0).map(i32::from_be_bytes), word(4).map(i32::from_be_bytes)) else {
            return Err(format!("the header takes {HEADER} bytes, the file has {}", bytes.len()));
        };
        let (Ok(frames), Ok(points)) = (usize::try_from(frames), usize::try_from(points)) else {
            return Err(format!("not an MDD: {frames} frames of {points} points"));
        };
        let stored = bytes.get(HEADER..).unwrap_or_default().chunks_exact(4).take(frames);
        let mut times: Vec<f64> = stored.map(|b| f64::from(f32::from_be_bytes([b[0], b[1], b[2], b[3]]))).collect();
        if times.len() < frames {
            return Err(format!("{frames} frames have {} times: expected one each", times.len()));
        }
        Samples::check_length(&*file, (HEADER + 4 * frames) as u64, [frames, points], warnings)?;
        // Some programs write no times.
        let is_ascending = times.windows(2).all(|pair| pair[0] < pair[1]) && times.iter().all(|time| time.is_finite());
        if !is_ascending {
            if times.iter().any(|time| *time != 0.0) {
                let rate = self.frames_per_second;
                warnings
                    .push(format!("the times of the frames do not ascend: they are read as {rate} frames a second"));
            }
            times = (0..frames).map(|frame| frame as f64 / self.frames_per_second).collect();
        }
        Ok(Samples {
            file,
            path: path.into(),
            start: (HEADER + 4 * frames) as u64,
            points,
            times,
            decode: f32::from_be_bytes,
        })
    }
}

/// The frames that a header tells, if it is one.
fn frames_of(header: &[u8]) -> Option<usize> {
    usize::try_from(i32::from_be_bytes(header.get(..4)?.try_into().ok()?)).ok()
}

/// A file in the making.
struct Writer {
    spool: Spool,
}

impl SequenceWriter for Writer {
    fn add(&mut self, name: &str, time: Option<&ClipTime>, positions: &[Point3<f64>]) -> Result<(), WriteError> {
        self.spool.add(name, time, positions)
    }

    fn warnings(&self) -> Vec<String> {
        self.spool.warnings()
    }

    fn finish(self: Box<Self>) -> Result<(), WriteError> {
        let times = &self.spool.times;
        let mut header = [Spool::count(times.len())?, Spool::count(self.spool.points)?].map(i32::to_be_bytes).concat();
        times.iter().for_each(|time| header.extend_from_slice(&(*time as f32).to_be_bytes()));
        self.spool.finish(&header)
    }
}
