//! The poses of a run: read, transferred, measured and written in a stream, so that memory does not grow with their number.

use std::path::Path;

use mimesh_core::{
    Error, Result,
    mesh::{PosesAre, check_finite},
    stage::{BoundTransfer, Motion, Transferred},
};
use mimesh_document::{Diagnostic, Kind, Location, diagnostic};
use mimesh_markers::IntoDiagnostic;
use nalgebra::Point3;
use rayon::prelude::*;

use super::{
    files::{SequenceFile, pose_files, warnings_of_pose_files},
    measure::{Measurer, PosedPose},
    shapes::Shapes,
    stages::Stages,
};
use crate::{
    cache::PosedTarget,
    input::{PoseFrom, PoseInput, Prepared, read_pose},
    progress::Progress,
    report::PoseReport,
    staging::Staged,
};

/// Poses under way for each thread: enough that none waits for the slowest of a chunk for long.
const POSES_PER_THREAD: usize = 4;

/// Sends the poses of a run through its stages.
pub(super) struct PoseRunner<'a> {
    /// The pipeline.
    pub prepared: &'a Prepared,
    /// The stages that run once.
    pub stages: &'a Stages<'a>,
    /// The measurements and the pictures.
    pub measurer: &'a Measurer<'a>,
    /// Changes shapes as the pipeline says.
    pub shapes: &'a Shapes<'a>,
    /// Receives the progress.
    pub progress: &'a dyn Progress,
}

/// The results of all poses.
#[derive(Debug, Default)]
pub(super) struct Stream {
    /// The poses in order.
    pub poses: Vec<PoseReport>,
    /// Diagnostics of the poses that failed.
    pub failed: Vec<Diagnostic>,
    /// The results, in temporary files.
    pub files: Vec<Staged>,
    /// Sentences about single poses.
    pub warnings: Vec<String>,
}

/// The output of one pose.
struct PoseOutput<'p> {
    posed: &'p PosedPose,
    report: PoseReport,
    files: Vec<Staged>,
}

type PoseResult<T> = std::result::Result<T, Diagnostic>;

/// A pose with its number.
type Numbered<'a> = (usize, &'a PoseInput);

impl<'a> PoseRunner<'a> {
    /// Sends all poses through.
    ///
    /// # Errors
    ///
    /// If a result cannot be written, or the transfer cannot be bound; poses that fail on their own are in the result.
    pub fn stream(&self) -> diagnostic::Result<Stream> {
        let mut stream = Stream::default();
        let mut sequences = SequenceFile::all(self.prepared).map_err(IntoDiagnostic::into_diagnostic)?;
        let chunk = rayon::current_num_threads() * POSES_PER_THREAD;
        let poses: Vec<Numbered<'_>> = self.prepared.poses.iter().enumerate().collect();
        let mut motion = None;
        // The poses of the chunk, behind the two before it.
        let mut posed: Vec<PoseResult<PosedPose>> = vec![];
        for chunk in poses.chunks(chunk) {
            let before = posed.len();
            posed.extend(self.posed(chunk, &mut motion)?);
            let outputs: Vec<_> =
                (0..chunk.len()).into_par_iter().map(|k| self.output(chunk[k], &posed, before + k)).collect();
            for ((_, pose), output) in chunk.iter().zip(outputs) {
                let diagnostic = match output {
                    Ok(output) => {
                        for sequence in &mut sequences {
                            sequence.add(pose, &output.posed.target.positions)?;
                        }
                        stream.add(pose, output);
                        continue;
                    }
                    Err(diagnostic) => diagnostic,
                };
                // A full disk is no fault of the pose.
                if diagnostic.kind == Kind::CannotWrite {
                    return Err(diagnostic.into());
                }
                let error = Some(diagnostic.to_json());
                stream.poses.push(PoseReport { name: pose.name.clone(), error, ..PoseReport::default() });
                stream.failed.push(diagnostic);
            }
            posed.drain(..posed.len().saturating_sub(2));
        }
        stream.warnings.extend(warnings_of_pose_files(self.prepared));
        if stream.failed.len() < stream.poses.len() {
            for sequence in sequences {
                let (file, warnings) = sequence.finish()?;
                stream.files.push(file);
                stream.warnings.extend(warnings);
            }
        }
        Ok(stream)
    }

    /// The poses of a chunk, transferred or taken from the cache.
    ///
    /// Frames of one motion are taken from the cache only where all are there. If one proves damaged, the motion is replayed up to it.
    fn posed(
        &self,
        chunk: &[Numbered<'_>],
        motion: &mut Option<Box<dyn Motion + 'a>>,
    ) -> diagnostic::Result<Vec<PoseResult<PosedPose>>> {
        let cache = self.stages.reusable_poses().filter(|_| motion.is_none());
        let cached: Vec<Option<PosedTarget>> =
            chunk.par_iter().map(|(i, _)| cache.and_then(|cache| cache.get(*i))).collect();
        if cached.iter().all(Option::is_some) {
            let reused =
                chunk.par_iter().zip(cached).filter_map(|((_, pose), target)| Some(self.reused(pose, target?)));
            return Ok(reused.collect());
        }
        let stages: &'a Stages<'a> = self.stages;
        let bound = stages.bound()?;
        if motion.is_none() {
            *motion = bound.motion();
            if let (Some(motion), Some((first, _))) = (motion.as_mut(), chunk.first()) {
                self.replay(*first, motion.as_mut());
            }
        }
        if let Some(motion) = motion {
            return Ok(self.frames(chunk, motion.as_mut()));
        }
        let pose = |((i, pose), target): (&Numbered<'_>, Option<PosedTarget>)| match target {
            Some(target) => self.reused(pose, target),
            None => self.transferred(*i, pose, bound),
        };
        Ok(chunk.par_iter().zip(cached).map(pose).collect())
    }

    /// A pose from the cache.
    fn reused(&self, pose: &PoseInput, target: PosedTarget) -> PoseResult<PosedPose> {
        // The source is only there to measure against; where it cannot be read, less is measured.
        let posed = if self.measurer.wants_source() { self.read(pose).ok() } else { None };
        self.progress.pose_done();
        self.measurable(pose, target, true, posed.as_deref())
    }

    /// A pose that stands alone.
    fn transferred(&self, i: usize, pose: &PoseInput, bound: &dyn BoundTransfer) -> PoseResult<PosedPose> {
        let posed = self.read(pose).and_then(|posed| {
            let target = self.transfer(i, pose, &posed, |posed| bound.transfer(posed))?;
            self.measurable(pose, target, false, Some(&posed))
        });
        self.progress.pose_done();
        posed
    }

    /// Frames of one motion: read and written side by side, but transferred one after the other.
    fn frames(&self, chunk: &[Numbered<'_>], motion: &mut dyn Motion) -> Vec<PoseResult<PosedPose>> {
        let read: Vec<_> = chunk.par_iter().map(|(_, pose)| self.read(pose)).collect();
        let mut frames = Vec::new();
        for (&(i, pose), posed) in chunk.iter().zip(read) {
            frames.push(posed.and_then(|posed| {
                let target = self.transfer(i, pose, &posed, |posed| motion.frame(i, posed))?;
                self.measurable(pose, target, false, Some(&posed))
            }));
            self.progress.pose_done();
        }
        frames
    }

    /// Brings a motion to frame `end`; the results before it are there already.
    fn replay(&self, end: usize, motion: &mut dyn Motion) {
        for (i, pose) in self.prepared.poses[..end].iter().enumerate() {
            let surface = &self.prepared.source.surface;
            if let Ok(posed) = self.read(pose)
                && let Ok(posed) = surface.from_mesh(&posed)
            {
                // A frame that failed was reported when it came first.
                let _ = motion.frame(i, &posed);
            }
        }
    }

    /// A posed target with all that metrics ask for.
    fn measurable(
        &self,
        pose: &PoseInput,
        target: PosedTarget,
        reused: bool,
        posed: Option<&[Point3<f64>]>,
    ) -> PoseResult<PosedPose> {
        let Prepared { source: from, target: rest, .. } = self.prepared;
        let posed = posed.filter(|_| self.measurer.wants_source());
        let source = posed.and_then(|posed| from.surface.from_mesh(posed).ok());
        let surface = if self.measurer.is_measuring() {
            let surface = rest.surface.from_mesh(&target.positions).map(|surface| rest.mirrored_positions(surface));
            surface.map_err(|error| pose_error(&pose.name, None, None, error))?
        } else {
            vec![]
        };
        Ok(PosedPose { target, surface, reused, source })
    }

    /// The vertices of the source's mesh in a pose.
    fn read(&self, pose: &PoseInput) -> PoseResult<Vec<Point3<f64>>> {
        let file = if let PoseFrom::File(file) = &pose.from { Some(file.as_path()) } else { None };
        read_pose(&self.prepared.source, &self.prepared.formats, &pose.from)
            .map_err(|error| pose_error(&pose.name, file, None, error))
    }

    /// The target for a posed source; it is cached at once, so that a run that is killed afterwards need not transfer it again.
    fn transfer(
        &self,
        i: usize,
        pose: &PoseInput,
        posed: &[Point3<f64>],
        transfer: impl FnOnce(&[Point3<f64>]) -> Result<Transferred>,
    ) -> PoseResult<PosedTarget> {
        let transfer = |posed: &[Point3<f64>]| {
            let mut transferred = transfer(posed)?;
            self.shapes.edit(i, posed, &mut transferred.positions)?;
            Ok(transferred)
        };
        let target = posed_target(self.prepared, posed, transfer).map_err(|error| {
            let name = self.stages.transfer.typetag_name();
            pose_error(&pose.name, None, Some(format!("transfer ({name})")), error)
        })?;
        if let Some(cache) = self.stages.pose_cache() {
            cache.put(i, &target);
        }
        Ok(target)
    }

    /// Measures and writes pose `k` of `posed`; the diagnostic of a pose that failed before.
    fn output<'p>(
        &self,
        (i, pose): Numbered<'_>,
        posed: &'p [PoseResult<PosedPose>],
        k: usize,
    ) -> PoseResult<PoseOutput<'p>> {
        let this = posed[k].as_ref().map_err(Clone::clone)?;
        let frame = |back: usize| k.checked_sub(back).and_then(|k| posed[k].as_ref().ok()).map(PosedPose::frame);
        let before = match self.prepared.poses_are {
            PosesAre::Frames => [1, 2].map(frame),
            PosesAre::Shapes => [None; 2],
        };
        let figures = this.target.figures.clone();
        let mut report = PoseReport { name: pose.name.clone(), reused: this.reused, figures, ..PoseReport::default() };
        self.measurer.measure(i, this, before, self.stages.pose_cache(), &mut report);
        pose_files(self.prepared, i, &this.target.positions).map(|files| PoseOutput { posed: this, report, files })
    }
}

impl Stream {
    fn add(&mut self, pose: &PoseInput, output: PoseOutput<'_>) {
        let warnings = output.report.figures.warnings.iter();
        self.warnings.extend(warnings.map(|warning| format!("pose {}: {warning}", pose.name)));
        self.poses.push(output.report);
        self.files.extend(output.files);
    }
}

/// The target's mesh when the source's mesh is at `posed`.
fn posed_target(
    prepared: &Prepared,
    posed: &[Point3<f64>],
    transfer: impl FnOnce(&[Point3<f64>]) -> Result<Transferred>,
) -> Result<PosedTarget> {
    let surface = &prepared.source.surface;
    let opened = surface.opened_seams(posed, 1e-6_f64.max(3.0 * prepared.source.welding.tolerance))?;
    let mut transferred = transfer(&surface.from_mesh(posed)?)?;
    if opened > 0 {
        transferred.figures.warn(format!(
            "{opened} vertices of the source lie on a seam that is closed at rest and opens in this pose; it is taken for closed: name them by `opened_seams` in `source` if they are to open"
        ));
    }
    let target = &prepared.target;
    let positions = target.surface.to_mesh(&target.mirrored_positions(transferred.positions))?;
    check_finite(&positions).map_err(|error| {
        let hint = "the method cannot cope with this pose; look at it, and for degenerate triangles of the rest meshes";
        Error::data(format!("result: {error}"), hint)
    })?;
    Ok(PosedTarget { positions, figures: transferred.figures })
}

/// The diagnostic of an error about the pose `name`, at its file if it has one; `doing` is the action that failed.
pub fn pose_error(name: &str, file: Option<&Path>, doing: Option<String>, error: Error) -> Diagnostic {
    let diagnostic = error.into_diagnostic();
    let diagnostic = match doing {
        Some(doing) => diagnostic.doing(format!("{doing}: pose {name}")),
        None => diagnostic,
    };
    match (diagnostic.location.is_none(), file) {
        (true, Some(file)) => diagnostic.at(Location::File(file.into())),
        _ => diagnostic,
    }
}
