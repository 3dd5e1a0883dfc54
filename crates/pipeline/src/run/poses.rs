//! The poses of a run: read, transferred, measured and written in a stream, so that memory does not grow with their number.

use std::{
    ops::Range,
    path::Path,
    sync::{Mutex, MutexGuard, PoisonError},
};

use mimesh_core::{
    Error, Result,
    mesh::{PosesAre, check_finite},
    stage::{BoundTransfer, Motion, Transferred},
};
use mimesh_document::{Diagnostic, Diagnostics, Kind, Location, diagnostic};
use mimesh_markers::IntoDiagnostic;
use nalgebra::Point3;
use rayon::prelude::*;

use super::{
    files::{SequenceFile, pose_files, warnings_of_pose_files},
    measure::{Measurer, PosedPose},
    schedule::{BEFORE, Schedule, Steps},
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

/// Frames of one motion that are read side by side.
const FRAMES_AT_ONCE: usize = 8;

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
struct PoseOutput {
    report: PoseReport,
    files: Vec<Staged>,
}

type PoseResult<T> = std::result::Result<T, Diagnostic>;

/// The source in a pose.
struct SourcePose {
    /// The vertices of its surface.
    surface: Vec<Point3<f64>>,
    /// Vertices on seams that are closed at rest and open here.
    opened: usize,
}

impl<'a> PoseRunner<'a> {
    /// Sends all poses through.
    ///
    /// # Errors
    ///
    /// If a result cannot be written, or the transfer cannot be bound; poses that fail on their own are in the result.
    pub fn stream(&self) -> diagnostic::Result<Stream> {
        let mut stream = Stream::default();
        let mut sequences = SequenceFile::all(self.prepared).map_err(IntoDiagnostic::into_diagnostic)?;
        let poses = &self.prepared.poses;
        let (at_once, in_order) = self.batches()?;
        let schedule = Schedule { count: poses.len(), batch: at_once, in_order };
        schedule.run(&PoseSteps { runner: self, motion: Mutex::new(None) }, |i, posed, output| {
            let pose = &poses[i];
            self.progress.pose_done();
            match (posed, output) {
                (Ok(posed), Ok(output)) => {
                    for sequence in &mut sequences {
                        sequence.add(pose, &posed.target.positions)?;
                    }
                    stream.add(pose, output);
                }
                (Err(diagnostic), _) => stream.fail(pose, diagnostic.clone())?,
                (_, Err(diagnostic)) => stream.fail(pose, diagnostic)?,
            }
            Ok(())
        })?;
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

    /// How many poses are taken at once, and whether one batch needs those before it.
    fn batches(&self) -> diagnostic::Result<(usize, bool)> {
        // Where all results are cached there may be no bound transfer, and one batch at a time may have to bind it.
        if self.stages.reusable_poses().is_some() && self.stages.is_complete() {
            return Ok((FRAMES_AT_ONCE, true));
        }
        let bound = self.stages.bound()?;
        Ok(if bound.motion().is_some() { (FRAMES_AT_ONCE, true) } else { (bound.at_once(), false) })
    }

    /// A pose from the cache.
    fn reused(&self, pose: &PoseInput, target: PosedTarget) -> PoseResult<PosedPose> {
        // The source is only there to measure against; where it cannot be read, less is measured.
        let posed = if self.measurer.wants_source() { self.read(pose).ok() } else { None };
        self.measurable(pose, target, true, posed.map(|posed| posed.surface))
    }

    /// Poses that stand alone.
    fn transferred(&self, poses: &[usize], bound: &dyn BoundTransfer) -> Vec<PoseResult<PosedPose>> {
        let sources: Vec<_> = poses.par_iter().map(|&i| self.read(&self.prepared.poses[i])).collect();
        let readable: Vec<&[Point3<f64>]> = sources.iter().flatten().map(|source| source.surface.as_slice()).collect();
        let mut transferred = bound.transfer_all(&readable).into_iter();
        let results: Vec<_> = sources
            .into_iter()
            .map(|source| source.map(|source| (source, transferred.next().expect("each pose has a result"))))
            .collect();
        let posed = |(&i, result): (&usize, PoseResult<(SourcePose, Result<Transferred>)>)| {
            let (source, transferred) = result?;
            self.posed(i, source, transferred)
        };
        poses.par_iter().zip(results).map(posed).collect()
    }

    /// Frames of one motion: read side by side, but transferred one after the other.
    fn frames(&self, frames: Range<usize>, motion: &mut dyn Motion) -> Vec<PoseResult<PosedPose>> {
        let poses = &self.prepared.poses;
        let read: Vec<_> = frames.clone().into_par_iter().map(|i| self.read(&poses[i])).collect();
        let transferred: Vec<_> = frames
            .clone()
            .zip(read)
            .map(|(i, source)| {
                let source = source?;
                let transferred = motion.frame(i, &source.surface);
                Ok((source, transferred))
            })
            .collect();
        let posed = |(i, result): (usize, PoseResult<(SourcePose, Result<Transferred>)>)| {
            let (source, transferred) = result?;
            self.posed(i, source, transferred)
        };
        frames.into_par_iter().zip(transferred).map(posed).collect()
    }

    /// Brings a motion to frame `end`; the results before it are there already.
    fn replay(&self, end: usize, motion: &mut dyn Motion) {
        for (i, pose) in self.prepared.poses[..end].iter().enumerate() {
            if let Ok(source) = self.read(pose) {
                // A frame that failed was reported when it came first.
                let _ = motion.frame(i, &source.surface);
            }
        }
    }

    /// The result of pose `i`; it is cached at once, so that a run that is killed afterwards need not transfer it again.
    fn posed(&self, i: usize, source: SourcePose, transferred: Result<Transferred>) -> PoseResult<PosedPose> {
        let pose = &self.prepared.poses[i];
        let target = self.target(i, &source, transferred).map_err(|error| {
            let name = self.stages.transfer.typetag_name();
            pose_error(&pose.name, None, Some(format!("transfer ({name})")), error)
        })?;
        if let Some(cache) = self.stages.pose_cache() {
            cache.put(i, &target);
        }
        self.measurable(pose, target, false, Some(source.surface))
    }

    /// The target's mesh when the source is at `source`.
    fn target(&self, i: usize, source: &SourcePose, transferred: Result<Transferred>) -> Result<PosedTarget> {
        let Transferred { mut positions, mut figures } = transferred?;
        self.shapes.edit(i, &source.surface, &mut positions)?;
        if source.opened > 0 {
            figures.warn(format!(
                "{} vertices of the source lie on a seam that is closed at rest and opens in this pose; it is taken for closed: name them by `opened_seams` in `source` if they are to open",
                source.opened
            ));
        }
        let target = &self.prepared.target;
        let positions = target.surface.to_mesh(&target.mirrored_positions(positions))?;
        check_finite(&positions).map_err(|error| {
            let hint =
                "the method cannot cope with this pose; look at it, and for degenerate triangles of the rest meshes";
            Error::data(format!("result: {error}"), hint)
        })?;
        Ok(PosedTarget { positions, figures })
    }

    /// A posed target with all that metrics ask for.
    fn measurable(
        &self,
        pose: &PoseInput,
        target: PosedTarget,
        reused: bool,
        source: Option<Vec<Point3<f64>>>,
    ) -> PoseResult<PosedPose> {
        let rest = &self.prepared.target;
        let source = source.filter(|_| self.measurer.wants_source());
        let surface = if self.measurer.is_measuring() {
            let surface = rest.surface.from_mesh(&target.positions).map(|surface| rest.mirrored_positions(surface));
            surface.map_err(|error| pose_error(&pose.name, None, None, error))?
        } else {
            vec![]
        };
        Ok(PosedPose { target, surface, reused, source })
    }

    /// The source in a pose.
    fn read(&self, pose: &PoseInput) -> PoseResult<SourcePose> {
        let source = &self.prepared.source;
        let file = if let PoseFrom::File(file) = &pose.from { Some(file.as_path()) } else { None };
        let mesh = read_pose(source, &self.prepared.formats, &pose.from)
            .map_err(|error| pose_error(&pose.name, file, None, error))?;
        let on_surface = || {
            let opened = source.surface.opened_seams(&mesh, 1e-6_f64.max(3.0 * source.welding.tolerance))?;
            Ok((source.surface.from_mesh(&mesh)?, opened))
        };
        let (surface, opened) = on_surface().map_err(|error| pose_error(&pose.name, file, None, error))?;
        Ok(SourcePose { surface, opened })
    }
}

/// The steps of the poses of a run.
struct PoseSteps<'a> {
    runner: &'a PoseRunner<'a>,
    /// The motion under way, where poses are frames of one.
    motion: Mutex<Option<Box<dyn Motion + 'a>>>,
}

impl<'a> PoseSteps<'a> {
    fn motion(&self) -> MutexGuard<'_, Option<Box<dyn Motion + 'a>>> {
        self.motion.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Steps for PoseSteps<'_> {
    type Posed = PoseResult<PosedPose>;
    type Output = PoseResult<PoseOutput>;
    type Error = Diagnostics;

    /// The poses of a batch, transferred or taken from the cache.
    ///
    /// Frames of one motion are taken from the cache only where all are there. If one proves damaged, the motion is replayed up to it.
    fn pose(&self, batch: Range<usize>) -> diagnostic::Result<Vec<PoseResult<PosedPose>>> {
        let runner = self.runner;
        // Taken, not held: this thread may begin another batch while it waits for others, but not within a motion.
        let mut motion = self.motion().take();
        let cache = runner.stages.reusable_poses().filter(|_| motion.is_none());
        let mut cached: Vec<Option<PosedTarget>> =
            batch.clone().into_par_iter().map(|i| cache.and_then(|cache| cache.get(i))).collect();
        if !cached.iter().all(Option::is_some) {
            let bound = runner.stages.bound()?;
            if motion.is_none() {
                motion = bound.motion();
                if let Some(motion) = motion.as_mut() {
                    runner.replay(batch.start, motion.as_mut());
                }
            }
            if let Some(mut motion) = motion {
                let frames = runner.frames(batch, motion.as_mut());
                *self.motion() = Some(motion);
                return Ok(frames);
            }
        }
        let missing: Vec<usize> = batch.clone().zip(&cached).filter(|(_, c)| c.is_none()).map(|(i, _)| i).collect();
        let mut transferred = if missing.is_empty() {
            vec![].into_iter()
        } else {
            runner.transferred(&missing, runner.stages.bound()?).into_iter()
        };
        let pose = |(i, cached): (usize, &mut Option<PosedTarget>)| match cached.take() {
            Some(target) => runner.reused(&runner.prepared.poses[i], target),
            None => transferred.next().expect("each pose that is missing was transferred"),
        };
        Ok(batch.zip(&mut cached).map(pose).collect())
    }

    /// Measures and writes a pose; the diagnostic of one that failed before.
    fn finish(
        &self,
        i: usize,
        posed: &PoseResult<PosedPose>,
        before: [Option<&PoseResult<PosedPose>>; BEFORE],
    ) -> PoseResult<PoseOutput> {
        let prepared = self.runner.prepared;
        let this = posed.as_ref().map_err(Clone::clone)?;
        let before = match prepared.poses_are {
            PosesAre::Frames => before.map(|posed| posed?.as_ref().ok().map(PosedPose::frame)),
            PosesAre::Shapes => [None; BEFORE],
        };
        let name = prepared.poses[i].name.clone();
        let mut report =
            PoseReport { name, reused: this.reused, figures: this.target.figures.clone(), ..PoseReport::default() };
        self.runner.measurer.measure(i, this, before, self.runner.stages.pose_cache(), &mut report);
        let files = pose_files(prepared, i, &this.target.positions)?;
        Ok(PoseOutput { report, files })
    }
}

impl Stream {
    fn add(&mut self, pose: &PoseInput, output: PoseOutput) {
        let warnings = output.report.figures.warnings.iter();
        self.warnings.extend(warnings.map(|warning| format!("pose {}: {warning}", pose.name)));
        self.poses.push(output.report);
        self.files.extend(output.files);
    }

    /// Notes a pose that failed on its own.
    fn fail(&mut self, pose: &PoseInput, diagnostic: Diagnostic) -> diagnostic::Result<()> {
        // A full disk is no fault of the pose.
        if diagnostic.kind == Kind::CannotWrite {
            return Err(diagnostic.into());
        }
        let error = Some(diagnostic.to_json());
        self.poses.push(PoseReport { name: pose.name.clone(), error, ..PoseReport::default() });
        self.failed.push(diagnostic);
        Ok(())
    }
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
