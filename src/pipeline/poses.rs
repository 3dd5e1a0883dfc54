//! The poses of a run: read, transferred, measured and written in a stream, so that memory does not grow with their
//! number.

use std::path::Path;

use nalgebra::Point3;
use rayon::prelude::*;

use super::{
    Formats,
    cache::{Cache, Key, Moved, Recipes},
    check::{Output, PoseFrom, PoseInput, Prepared, Side},
    report::{PoseReport, measure},
    run::of_pose,
    staging::{self, Staged},
    watch::Watch,
};
use crate::{
    core::{
        Error, Result,
        mesh::check_finite,
        stage::{BoundTransfer, MeshWriter, MetricInput, Motion, SequenceWriter, Transferred, WriteError},
    },
    mistake::{self, Mistake},
    status::Status,
};

/// Poses in the making for each thread: enough that none waits for the slowest of a chunk for long.
const POSES_PER_THREAD: usize = 4;

/// What poses go through.
pub struct Bench<'a> {
    /// The pipeline.
    pub prepared: &'a Prepared,
    /// The type of the transfer, for messages.
    pub transfer: &'a str,
    /// The transfer; `None` if all poses are kept.
    pub bound: Option<&'a dyn BoundTransfer>,
    /// Where poses are kept.
    pub shelf: Option<Shelf<'a>>,
    /// Is told of every pose.
    pub watch: &'a dyn Watch,
}

/// Results of poses that are kept from run to run.
#[derive(Clone, Copy, Debug)]
pub struct Shelf<'a> {
    /// The cache.
    pub cache: &'a Cache,
    /// What the results depend on.
    pub recipes: &'a Recipes,
    /// Whether poses are frames of one motion.
    pub motion: bool,
}

impl Shelf<'_> {
    /// The kept result of pose `i`.
    pub fn get(&self, i: usize) -> Option<Moved> {
        self.cache.get(self.kind(), self.key(i)?)
    }

    fn put(&self, i: usize, moved: &Moved) {
        if let Some(key) = self.key(i) {
            self.cache.put(self.kind(), key, moved);
        }
    }

    fn kind(&self) -> &'static str {
        if self.motion { "frame" } else { "pose" }
    }

    fn key(&self, i: usize) -> Option<Key> {
        if self.motion { self.recipes.frame(i) } else { self.recipes.pose(i) }
    }
}

/// What comes of the poses.
#[derive(Debug, Default)]
pub struct Stream {
    /// The poses in order.
    pub poses: Vec<PoseReport>,
    /// Those that failed.
    pub failed: Vec<Mistake>,
    /// The results, written aside.
    pub files: Vec<Staged>,
    /// Sentences about single poses.
    pub warnings: Vec<String>,
}

/// What comes of one pose.
struct Done {
    report: PoseReport,
    positions: Vec<Point3<f64>>,
    files: Vec<Staged>,
}

impl Bench<'_> {
    /// Sends all poses through.
    ///
    /// # Errors
    ///
    /// If a result cannot be written; poses that fail on their own are in the result.
    pub fn stream(&self) -> mistake::Result<Stream> {
        let mut stream = Stream::default();
        let mut sequences = self.sequences()?;
        let chunk = rayon::current_num_threads() * POSES_PER_THREAD;
        let poses: Vec<(usize, &PoseInput)> = self.prepared.poses.iter().enumerate().collect();
        let mut motion = self.bound.and_then(|bound| bound.motion());
        for chunk in poses.chunks(chunk) {
            let done: Vec<_> = match &mut motion {
                None => chunk.par_iter().map(|(i, pose)| self.pose(*i, pose)).collect(),
                Some(motion) => self.frames(chunk, motion.as_mut()),
            };
            for ((_, pose), done) in chunk.iter().zip(done) {
                match done {
                    Ok(done) => {
                        for (path, writer) in &mut sequences {
                            writer.add(&pose.name, &done.positions).map_err(|error| writing(path, error))?;
                        }
                        let warnings = done.report.figures.warnings.iter();
                        stream.warnings.extend(warnings.map(|warning| format!("pose {}: {warning}", pose.name)));
                        stream.poses.push(done.report);
                        stream.files.extend(done.files);
                    }
                    // A full disk is no fault of the pose.
                    Err(mistake) if mistake.status == Status::CannotWrite => return Err(mistake.into()),
                    Err(mistake) => {
                        let error = Some(mistake.to_json());
                        stream.poses.push(PoseReport { name: pose.name.clone(), error, ..PoseReport::default() });
                        stream.failed.push(mistake);
                    }
                }
            }
        }
        if stream.failed.len() < stream.poses.len() {
            for (path, writer) in sequences {
                let finished = staging::stage(&path, |out| writer.finish(out).map_err(|error| writing(&path, error)));
                stream.files.push(finished?);
            }
        }
        Ok(stream)
    }

    /// A writer for each file that takes all poses.
    fn sequences(&self) -> Result<Vec<(std::path::PathBuf, Box<dyn SequenceWriter + '_>)>> {
        let mut writers = Vec::new();
        for output in &self.prepared.outputs.meshes {
            let Output::Sequence(path) = output else { continue };
            if let Ok((format, _)) = self.prepared.formats.writer(path)
                && let Some(MeshWriter::Sequence(sequence)) = format.writer()
            {
                let rest = &self.prepared.target.sequence.rest;
                writers.push((path.clone(), sequence.start(rest).map_err(|error| writing(path, error))?));
            }
        }
        Ok(writers)
    }

    /// A pose that stands alone.
    fn pose(&self, i: usize, pose: &PoseInput) -> std::result::Result<Done, Mistake> {
        if let Some(moved) = self.shelf.and_then(|shelf| shelf.get(i)) {
            return self.done(i, pose, Ok(moved), true);
        }
        let Some(bound) = self.bound else {
            let message = format!("pose {}: its kept result was removed while this run was to use it", pose.name);
            return Err(Mistake::new(Status::Internal, message).hint("run again, or with `--no-cache`"));
        };
        let moved = self.posed(pose).and_then(|posed| self.moved(i, pose, &posed, |posed| bound.transfer(posed)));
        self.done(i, pose, moved, false)
    }

    /// Frames of one motion: read and written side by side, but transferred one after the other.
    fn frames(
        &self,
        chunk: &[(usize, &PoseInput)],
        motion: &mut dyn Motion,
    ) -> Vec<std::result::Result<Done, Mistake>> {
        let read: Vec<_> = chunk.par_iter().map(|(_, pose)| self.posed(pose)).collect();
        let frame = |(&(i, pose), posed): (&(usize, &PoseInput), std::result::Result<Vec<_>, Mistake>)| {
            self.moved(i, pose, &posed?, |posed| motion.frame(i, posed))
        };
        let moved: Vec<_> = chunk.iter().zip(read).map(frame).collect();
        chunk.par_iter().zip(moved).map(|((i, pose), moved)| self.done(*i, pose, moved, false)).collect()
    }

    fn posed(&self, pose: &PoseInput) -> std::result::Result<Vec<Point3<f64>>, Mistake> {
        let file = if let PoseFrom::File(file) = &pose.from { Some(file.as_path()) } else { None };
        read(&self.prepared.source, &self.prepared.formats, &pose.from)
            .map_err(|error| of_pose(&pose.name, file, None, error))
    }

    fn moved(
        &self,
        i: usize,
        pose: &PoseInput,
        posed: &[Point3<f64>],
        transfer: impl FnOnce(&[Point3<f64>]) -> Result<Transferred>,
    ) -> std::result::Result<Moved, Mistake> {
        let doing = || Some(format!("transfer ({})", self.transfer));
        let moved = self.transfer(posed, transfer).map_err(|error| of_pose(&pose.name, None, doing(), error))?;
        // At once, so that a run that is killed after this need not do it again.
        if let Some(shelf) = &self.shelf {
            shelf.put(i, &moved);
        }
        Ok(moved)
    }

    /// Scores and writes pose `i`.
    fn done(
        &self,
        i: usize,
        pose: &PoseInput,
        moved: std::result::Result<Moved, Mistake>,
        reused: bool,
    ) -> std::result::Result<Done, Mistake> {
        let done = moved.and_then(|(positions, figures)| {
            let mut report = PoseReport { name: pose.name.clone(), reused, figures, ..PoseReport::default() };
            if let Err(error) = self.score(i, &positions, &mut report) {
                // The result is good all the same.
                report.figures.warn(format!("not scored: {error}"));
            }
            let files = self.write(i, &positions)?;
            Ok(Done { report, positions, files })
        });
        self.watch.pose_done();
        done
    }

    fn transfer(
        &self,
        posed: &[Point3<f64>],
        transfer: impl FnOnce(&[Point3<f64>]) -> Result<Transferred>,
    ) -> Result<Moved> {
        let surface = &self.prepared.source.surface;
        let parted = surface.parted_copies(posed)?;
        let mut transferred = transfer(&surface.from_mesh(posed)?)?;
        if parted > 0 {
            transferred.figures.warn(format!(
                "{parted} vertices of the source lie on a seam that is closed at rest and opens in this pose; it is taken for \
                 closed: move the two sides apart a little in the rest mesh if they are to open"
            ));
        }
        let positions = self.prepared.target.surface.to_mesh(&transferred.positions)?;
        check_finite(&positions).map_err(|error| {
            let hint =
                "the method cannot cope with this pose; look at it, and at degenerate triangles with `mimesh inspect`";
            Error::data(format!("result: {error}"), hint)
        })?;
        Ok((positions, transferred.figures))
    }

    /// Measures pose `i` against the truth, if that is known.
    fn score(&self, i: usize, result: &[Point3<f64>], report: &mut PoseReport) -> Result<()> {
        let Prepared { truth, metrics, formats, target, .. } = self.prepared;
        let rest = &target.sequence.rest;
        if let Some(truth) = truth.positions(i, &report.name, rest, formats)? {
            report.metrics = measure(metrics, MetricInput { rest, result, truth: &truth })?;
            report.nothing = measure(metrics, MetricInput { rest, result: &rest.positions, truth: &truth })?;
        }
        Ok(())
    }

    /// The files of one pose, written aside.
    fn write(&self, i: usize, positions: &[Point3<f64>]) -> std::result::Result<Vec<Staged>, Mistake> {
        let mut files = Vec::new();
        for output in &self.prepared.outputs.meshes {
            let Output::Poses(paths) = output else { continue };
            let path = &paths[i];
            if let Ok((format, _)) = self.prepared.formats.writer(path)
                && let Some(MeshWriter::Pose(writer)) = format.writer()
            {
                let rest = &self.prepared.target.sequence.rest;
                let write = |out: &mut dyn std::io::Write| {
                    writer.write(rest, positions, out).map_err(|error| writing(path, error))
                };
                files.push(staging::stage(path, write).map_err(cannot_write)?);
            }
        }
        Ok(files)
    }
}

/// At most `count` poses of the source surface, spread over all; those that cannot be read are left out, and told when their
/// turn comes.
///
/// # Errors
///
/// None but of the program itself.
pub fn some(prepared: &Prepared, count: usize) -> Result<Vec<Vec<Point3<f64>>>> {
    let chosen = spread(prepared.poses.len(), count);
    let one = |&i: &usize| read(&prepared.source, &prepared.formats, &prepared.poses[i].from).ok();
    let read: Vec<_> = chosen.par_iter().filter_map(one).collect();
    read.iter().map(|positions| prepared.source.surface.from_mesh(positions)).collect()
}

/// At most `count` numbers spread over 0 to `all` - 1.
pub fn spread(all: usize, count: usize) -> Vec<usize> {
    if count >= all { (0..all).collect() } else { (0..count).map(|k| k * all / count).collect() }
}

/// The vertices of the source in one pose.
///
/// # Errors
///
/// If it cannot be read, is no pose of the source, or is not finite.
pub fn read(source: &Side, formats: &Formats, from: &PoseFrom) -> Result<Vec<Point3<f64>>> {
    let positions = match from {
        PoseFrom::Held(i) => source.sequence.poses[*i].positions.clone(),
        PoseFrom::File(path) => match formats.reader(path) {
            Ok(format) => format.read_pose(path, &source.sequence.rest)?,
            Err(unknown) => return Err(Error::file(path, unknown.message, unknown.hint)),
        },
    };
    check_finite(&positions)?;
    Ok(positions)
}

/// An error of writing, with the path that it was written to.
fn writing(path: &Path, error: WriteError) -> Error {
    match error {
        WriteError::Io(error) => Error::write(path, error),
        WriteError::Mesh(Error::Data { message, hint }) => {
            Error::file(path, format!("cannot be written: {message}"), hint)
        }
        WriteError::Mesh(error) => error,
    }
}

/// Whatever goes wrong while writing ends the run, so it is no mistake of the pose.
fn cannot_write(error: Error) -> Mistake {
    Mistake { status: Status::CannotWrite, ..error.into() }
}
