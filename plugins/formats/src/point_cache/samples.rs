//! The samples of a point cache as poses, each read when it is asked for.

use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

use mimesh_core::{
    Error, Result,
    mesh::{Animation, ClipTime, ComputePoses, Mesh, MeshSequence, Pose, Positions, check_finite},
    stage::{ClipChoice, ClipTimes, PoseChoice, ReadAt, RestShape, Selection},
};
use nalgebra::Point3;

use crate::{
    clip_frames::{ClipKeys, check_rest_time, frames},
    names::find,
};

/// Bytes of a position: three f32.
const POSITION: u64 = 12;

/// So many bytes are looked at before their poses are asked for, which takes a fraction of a second.
const MAX_CHECKED: u64 = 1 << 28;

/// The way out of a file that cannot be read.
pub const DAMAGED: &str = "the file is damaged or cut short: export it again";

/// The contents of a point cache.
pub struct Samples {
    /// The file, and its name for messages.
    pub file: Box<dyn ReadAt>,
    pub path: PathBuf,
    /// Where the first position starts.
    pub start: u64,
    /// Positions a sample.
    pub points: usize,
    /// The seconds of each sample.
    pub times: Vec<f64>,
    /// How a number is stored.
    pub decode: fn([u8; 4]) -> f32,
}

/// The poses that are asked for.
struct Poses {
    samples: Samples,
    /// The time of each.
    seconds: Vec<f64>,
}

impl Samples {
    /// Checks that the file is long enough for samples of points from byte `start` on; bytes after them are told in `warnings`.
    ///
    /// # Errors
    ///
    /// The message with both lengths, or that there is no sample or no point.
    pub fn check_length(
        file: &dyn ReadAt,
        start: u64,
        [samples, points]: [usize; 2],
        warnings: &mut Vec<String>,
    ) -> Result<(), String> {
        if samples == 0 || points == 0 {
            return Err(format!("empty point cache: {samples} samples of {points} points"));
        }
        let wanted = (samples as u64).checked_mul(points as u64).and_then(|count| count.checked_mul(POSITION));
        let wanted = wanted.and_then(|bytes| bytes.checked_add(start));
        let found = file.length();
        if let Some(left) = wanted.and_then(|wanted| found.checked_sub(wanted)).filter(|left| *left > 0) {
            warnings.push(format!(
                "{left} bytes after the last sample are not read: if the header's counts are too low, samples are missing"
            ));
        }
        if wanted.is_none_or(|wanted| wanted > found) {
            let wanted = wanted.map_or("more than there can be".to_owned(), |wanted| wanted.to_string());
            return Err(format!("{samples} samples of {points} points take {wanted} bytes, the file has {found}"));
        }
        Ok(())
    }

    /// Reads all samples of a file that is not too long for that, and tells those with numbers that are not finite in `warnings`.
    ///
    /// # Errors
    ///
    /// Those of the file.
    fn check(&self, warnings: &mut Vec<String>) -> Result<()> {
        let length = self.points as u64 * POSITION;
        let most = usize::try_from(MAX_CHECKED / length).unwrap_or(usize::MAX);
        let mut bytes = vec![0; if most > 0 { length as usize } else { 0 }];
        let (mut wrong, mut first) = (0, 0);
        for sample in 0..self.times.len().min(most) {
            self.file.read_at(self.start + sample as u64 * length, &mut bytes)?;
            let is_finite = |word: &[u8; 4]| (self.decode)(*word).is_finite();
            if !bytes.as_chunks().0.iter().all(is_finite) {
                first = if wrong == 0 { sample } else { first };
                wrong += 1;
            }
        }
        if wrong > 0 {
            warnings.push(format!(
                "samples with coordinates that are not finite, which cannot be read: {wrong}, the first {first} (from 0)"
            ));
        }
        Ok(())
    }

    /// The positions at a time: those of a sample, or evenly between two; the first and the last hold beyond the ends.
    fn at(&self, seconds: f64) -> Result<Vec<Point3<f64>>> {
        let after = self.times.partition_point(|time| *time <= seconds);
        let before = after.saturating_sub(1);
        let last = self.times.len() - 1;
        let mut positions = self.sample(before)?;
        let [from, to] = [before, after.min(last)].map(|sample| self.times[sample]);
        let share = if to > from { ((seconds - from) / (to - from)).clamp(0.0, 1.0) } else { 0.0 };
        if share > 0.0 {
            let next = self.sample(after.min(last))?;
            positions.iter_mut().zip(next).for_each(|(position, next)| *position += (next - *position) * share);
        }
        Ok(positions)
    }

    fn sample(&self, sample: usize) -> Result<Vec<Point3<f64>>> {
        let mut bytes = vec![0; self.points * POSITION as usize];
        self.file.read_at(self.start + sample as u64 * bytes.len() as u64, &mut bytes)?;
        let number = |bytes: &[u8]| f64::from((self.decode)([bytes[0], bytes[1], bytes[2], bytes[3]]));
        let position = |bytes: &[u8]| Point3::new(number(&bytes[..4]), number(&bytes[4..8]), number(&bytes[8..]));
        let positions: Vec<Point3<f64>> = bytes.chunks_exact(POSITION as usize).map(position).collect();
        match check_finite(&positions) {
            Err(Error::Data { message, hint }) => {
                Err(Error::file(&self.path, format!("sample {sample} (from 0): {message}"), hint))
            }
            other => other.map(|()| positions),
        }
    }
}

impl ComputePoses for Poses {
    fn positions(&self, index: usize) -> Result<Vec<Point3<f64>>> {
        self.samples.at(self.seconds[index])
    }
}

/// The first `count` bytes of `file`, or all of a shorter one.
///
/// # Errors
///
/// Those of the file.
pub fn first_bytes(file: &dyn ReadAt, count: usize) -> Result<Vec<u8>> {
    let mut bytes = vec![0; usize::try_from(file.length()).unwrap_or(usize::MAX).min(count)];
    file.read_at(0, &mut bytes)?;
    Ok(bytes)
}

/// The poses that a selection asks for. The file is one clip, called as it is; its rest is the first sample.
///
/// # Errors
///
/// [`Error::File`] if the file has no such clip, pose or times, or a rest that is not finite.
pub fn sequence(
    path: &Path,
    samples: Samples,
    selection: &Selection,
    mut warnings: Vec<String>,
) -> Result<MeshSequence> {
    let unknown = |message: String| Error::file(path, message, "the clip of a point cache is called as its file");
    let name = path.file_stem().map_or_else(|| "cache".into(), |stem| stem.to_string_lossy().into_owned());
    let (first, last) = (samples.times[0], samples.times[samples.times.len() - 1]);
    let clips = [ClipKeys { name: name.clone(), span: [first, last], key_times: samples.times.clone() }];
    let all = ClipChoice { times: ClipTimes::Keys, ..ClipChoice::default() };
    let every = frames(&all, &clips, &mut warnings).map_err(unknown)?;
    let rest = match &selection.rest {
        RestShape::Stored => first,
        RestShape::Pose(pose) => {
            let pose = find("pose", every.iter().map(|frame| frame.name.as_str()), pose).map_err(unknown)?;
            every[pose].seconds
        }
        RestShape::Clip { name, seconds } => {
            let clip = find("clip", [clips[0].name.as_str()], name).map_err(unknown)?;
            check_rest_time(name, clips[clip].span, *seconds, &mut warnings).map_err(unknown)?;
            *seconds
        }
    };
    let chosen = match &selection.poses {
        PoseChoice::Nothing => Vec::new(),
        PoseChoice::Shapes => every,
        PoseChoice::Clips(choice) => frames(choice, &clips, &mut warnings).map_err(unknown)?,
    };
    if selection.poses != PoseChoice::Nothing {
        samples.check(&mut warnings)?;
    }
    let rest = Mesh { positions: samples.at(rest)?, ..Mesh::default() };
    let seconds = chosen.iter().map(|frame| frame.seconds).collect();
    let poses = Arc::new(Poses { samples, seconds });
    let pose = |(index, frame): (usize, crate::clip_frames::Frame)| Pose {
        name: frame.name,
        time: Some(ClipTime { clip: name.clone(), seconds: frame.seconds }),
        positions: Positions::Computed(poses.clone(), index),
    };
    let animation = Animation { name: name.clone(), seconds: last, channels: vec!["vertices".into()] };
    let poses = chosen.into_iter().enumerate().map(pose).collect();
    Ok(MeshSequence { rest, poses, animations: vec![animation], warnings, ..MeshSequence::default() })
}
