//! The poses of a run: read, transferred, measured and written in a stream, so that memory does not grow with their
//! number.

use std::path::Path;

use nalgebra::Point3;
use rayon::prelude::*;

use super::{
    Formats,
    cache::Moved,
    check::{Output, PoseFrom, PoseInput, Prepared, Side},
    judge::{Judges, Said},
    pictures::{Gallery, Shot},
    report::PoseReport,
    run::of_pose,
    shelf::Shelf,
    staging::{self, Staged},
    watch::Watch,
};
use crate::{
    core::{
        Error, Figures, Result,
        mesh::check_finite,
        stage::{BoundTransfer, Frame, MeshWriter, MetricInput, Motion, SequenceWriter, Transferred, WriteError},
    },
    diagnostic::Kind,
    diagnostic::{self, Diagnostic},
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
    /// What measures results.
    pub judges: &'a Judges<'a>,
    /// What metrics said of every pose, if that is kept from an earlier run.
    pub said: Option<&'a [Said]>,
    /// What takes pictures, if any are wanted.
    pub gallery: Option<&'a Gallery<'a>>,
    /// Is told of every pose.
    pub watch: &'a dyn Watch,
}

/// What comes of the poses.
#[derive(Debug, Default)]
pub struct Stream {
    /// The poses in order.
    pub poses: Vec<PoseReport>,
    /// Those that failed.
    pub failed: Vec<Diagnostic>,
    /// The results, written aside.
    pub files: Vec<Staged>,
    /// Sentences about single poses.
    pub warnings: Vec<String>,
}

/// A pose that has been transferred.
struct Ready {
    /// The target, for the vertices of its mesh.
    positions: Vec<Point3<f64>>,
    /// What the transfer says.
    figures: Figures,
    /// Whether it was kept from an earlier run.
    reused: bool,
    /// The source, for the vertices of its surface; only where something is measured against it.
    source: Option<Vec<Point3<f64>>>,
}

impl Ready {
    fn frame(&self) -> Frame<'_> {
        Frame { result: &self.positions, source: self.source.as_deref() }
    }
}

/// What comes of one pose.
struct Done {
    report: PoseReport,
    files: Vec<Staged>,
}

type Tried<T> = std::result::Result<T, Diagnostic>;

impl Bench<'_> {
    /// Sends all poses through.
    ///
    /// # Errors
    ///
    /// If a result cannot be written; poses that fail on their own are in the result.
    pub fn stream(&self) -> diagnostic::Result<Stream> {
        let mut stream = Stream::default();
        let mut sequences = self.sequences()?;
        let chunk = rayon::current_num_threads() * POSES_PER_THREAD;
        let poses: Vec<(usize, &PoseInput)> = self.prepared.poses.iter().enumerate().collect();
        let mut motion = self.bound.and_then(|bound| bound.motion());
        // The two poses before the chunk.
        let mut passed: Vec<Tried<Ready>> = vec![];
        for chunk in poses.chunks(chunk) {
            let before = passed.len();
            match &mut motion {
                None => passed.par_extend(chunk.par_iter().map(|(i, pose)| {
                    let ready = self.pose(*i, pose);
                    self.watch.pose_done();
                    ready
                })),
                Some(motion) => passed.extend(self.frames(chunk, motion.as_mut())),
            }
            let finish = |(k, &(i, pose)): (usize, &(usize, &PoseInput))| {
                let frame = |back: usize| (before + k).checked_sub(back).and_then(|k| passed[k].as_ref().ok());
                let ready = passed[before + k].as_ref().ok()?;
                Some(self.finish(i, pose, ready, [1, 2].map(|back| frame(back).map(Ready::frame))))
            };
            let done: Vec<_> = chunk.par_iter().enumerate().map(finish).collect();
            for (k, ((_, pose), done)) in chunk.iter().zip(done).enumerate() {
                let diagnostic = match (&passed[before + k], done) {
                    (Ok(ready), Some(Ok(done))) => {
                        for (path, writer) in &mut sequences {
                            writer.add(&pose.name, &ready.positions).map_err(|error| writing(path, error))?;
                        }
                        let warnings = done.report.figures.warnings.iter();
                        stream.warnings.extend(warnings.map(|warning| format!("pose {}: {warning}", pose.name)));
                        stream.poses.push(done.report);
                        stream.files.extend(done.files);
                        continue;
                    }
                    (Err(diagnostic), _) => diagnostic.clone(),
                    (_, Some(Err(diagnostic))) => diagnostic,
                    (Ok(_), None) => continue,
                };
                // A full disk is no fault of the pose.
                if diagnostic.kind == Kind::CannotWrite {
                    return Err(diagnostic.into());
                }
                let error = Some(diagnostic.to_json());
                stream.poses.push(PoseReport { name: pose.name.clone(), error, ..PoseReport::default() });
                stream.failed.push(diagnostic);
            }
            passed.drain(..passed.len().saturating_sub(2));
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
    fn pose(&self, i: usize, pose: &PoseInput) -> Tried<Ready> {
        if let Some(moved) = self.shelf.and_then(|shelf| shelf.get(i)) {
            // What the source did in it is only to measure against.
            let posed = self.wants_source().then(|| self.posed(pose).ok()).flatten();
            return Ok(self.ready(moved, true, posed.as_deref()));
        }
        let Some(bound) = self.bound else {
            let message = format!("pose {}: its kept result was removed while this run was to use it", pose.name);
            return Err(Diagnostic::new(Kind::Internal, message).hint("run again, or with `--no-cache`"));
        };
        let posed = self.posed(pose)?;
        let moved = self.moved(i, pose, &posed, |posed| bound.transfer(posed))?;
        Ok(self.ready(moved, false, Some(&posed)))
    }

    /// Frames of one motion: read and written side by side, but transferred one after the other.
    fn frames(&self, chunk: &[(usize, &PoseInput)], motion: &mut dyn Motion) -> Vec<Tried<Ready>> {
        let read: Vec<_> = chunk.par_iter().map(|(_, pose)| self.posed(pose)).collect();
        let frame = |(&(i, pose), posed): (&(usize, &PoseInput), Tried<Vec<_>>)| {
            let moved = posed.and_then(|posed| {
                let moved = self.moved(i, pose, &posed, |posed| motion.frame(i, posed))?;
                Ok(self.ready(moved, false, Some(&posed)))
            });
            self.watch.pose_done();
            moved
        };
        chunk.iter().zip(read).map(frame).collect()
    }

    fn wants_source(&self) -> bool {
        self.said.is_none() && (self.judges.want_source() || self.gallery.is_some())
    }

    fn ready(&self, (positions, figures): Moved, reused: bool, posed: Option<&[Point3<f64>]>) -> Ready {
        let posed = posed.filter(|_| self.wants_source());
        let source = posed.and_then(|posed| self.prepared.source.surface.from_mesh(posed).ok());
        Ready { positions, figures, reused, source }
    }

    fn posed(&self, pose: &PoseInput) -> Tried<Vec<Point3<f64>>> {
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
    ) -> Tried<Moved> {
        let doing = || Some(format!("transfer ({})", self.transfer));
        let moved = self.transfer(posed, transfer).map_err(|error| of_pose(&pose.name, None, doing(), error))?;
        // At once, so that a run that is killed after this need not do it again.
        if let Some(shelf) = &self.shelf {
            shelf.put(i, &moved);
        }
        Ok(moved)
    }

    /// Measures and writes pose `i`.
    fn finish(&self, i: usize, pose: &PoseInput, ready: &Ready, before: [Option<Frame<'_>>; 2]) -> Tried<Done> {
        let Ready { positions, figures, reused, .. } = ready;
        let figures = figures.clone();
        let mut report = PoseReport { name: pose.name.clone(), reused: *reused, figures, ..PoseReport::default() };
        self.judge(i, ready, before, &mut report);
        Ok(Done { files: self.write(i, positions)?, report })
    }

    fn transfer(
        &self,
        posed: &[Point3<f64>],
        transfer: impl FnOnce(&[Point3<f64>]) -> Result<Transferred>,
    ) -> Result<Moved> {
        let surface = &self.prepared.source.surface;
        let parted = surface.opened_seams(posed)?;
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

    /// Measures pose `i`, against the truth too if that is known.
    fn judge(&self, i: usize, ready: &Ready, before: [Option<Frame<'_>>; 2], report: &mut PoseReport) {
        let Prepared { truth, formats, target, .. } = self.prepared;
        if let Some(said) = self.said {
            return self.tell(&said[i], report);
        }
        let rest = &target.sequence.rest;
        let mut unreadable = false;
        let truth = truth.positions(i, &report.name, rest, formats).unwrap_or_else(|error| {
            // What needs no truth is measured all the same.
            report.figures.warn(format!("not scored: {error}"));
            unreadable = true;
            None
        });
        let judged =
            MetricInput { result: &ready.positions, truth: truth.as_deref(), source: ready.source.as_deref(), before };
        let judgement = self.judges.measure(judged);
        let mut said = judgement.said();
        if let Some(truth) = &truth {
            said.nothing = self.judges.against_truth(MetricInput::against(&rest.positions, truth)).figures();
        }
        if let Some(shelf) = self.shelf.filter(|_| !unreadable) {
            shelf.put_said(i, &said);
        }
        self.tell(&said, report);
        if unreadable {
            let missing = self.judges.of_truth().map(|metric| (metric.to_owned(), String::new()));
            said.failed.extend(missing);
            report.verdict = self.judges.verdict(&said);
        }
        if let Some(gallery) = self.gallery {
            let shot = Shot {
                name: &report.name,
                source: ready.source.as_deref(),
                result: &ready.positions,
                judgement: &judgement,
                verdict: report.verdict.as_ref(),
                strain: self.judges.strain(&said),
            };
            gallery.take(i, &shot);
        }
    }

    /// What metrics said, in the report.
    fn tell(&self, said: &Said, report: &mut PoseReport) {
        for (metric, error) in &said.failed {
            report.figures.warn(format!("metric {metric}: {error}"));
        }
        report.verdict = self.judges.verdict(said);
        report.metrics = said.figures.clone();
        report.nothing = said.nothing.clone();
    }

    /// The files of one pose, written aside.
    fn write(&self, i: usize, positions: &[Point3<f64>]) -> Tried<Vec<Staged>> {
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

/// Whatever goes wrong while writing ends the run, so it is no diagnostic of the pose.
fn cannot_write(error: Error) -> Diagnostic {
    Diagnostic { kind: Kind::CannotWrite, ..error.into() }
}
