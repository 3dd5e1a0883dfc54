//! Running a prepared pipeline: stages once, poses in a stream, results written aside and moved into place at the end.

use std::path::Path;

use rayon::prelude::*;
use serde_json::{Value, json};

use super::{
    cache::{Cache, Keep, OfTransfer, Recipe, Record},
    check::Prepared,
    gates::Gate,
    hash::hash_file,
    judge::{Judges, Level, Said},
    pictures::Gallery,
    poses::{self, Bench, Stream},
    process,
    report::{Clock, InputFile, MeshFigures, PoseReport, Report, RunOf, StageReport, over_poses},
    shelf::Shelf,
    staging,
    watch::Watch,
};
use crate::{
    core::{
        Error, Figures,
        stage::{MetricContext, ProximityGraph, TransferPair, TriangleMap},
    },
    diagnostic::Kind,
    diagnostic::{Diagnostic, Diagnostics, Location, Result},
    page,
};

/// How a run went.
#[derive(Debug)]
pub struct Outcome {
    /// What it did.
    pub report: Report,
    /// The poses that failed, each told; the others are written.
    pub failed: Vec<Diagnostic>,
}

/// Runs `prepared` on `threads` threads (0: as many as the machine has); `set` is what the command line set, and `cache` keeps
/// results from run to run.
///
/// The results are the same for any number of threads, and with or without a cache.
///
/// # Errors
///
/// What a stage or a file failed with; then nothing is written. A pose that fails on its own is told in the outcome
/// instead, unless all of them fail.
pub fn run(
    prepared: &Prepared,
    set: &[String],
    threads: usize,
    cache: Option<&Cache>,
    watch: &dyn Watch,
) -> Result<Outcome> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let pool = pool.map_err(|error| Diagnostic::new(Kind::Internal, format!("cannot start threads: {error}")))?;
    pool.install(|| Run { prepared, watch, stages: vec![prepared.reading.clone()], cache }.run(set))
}

struct Run<'a> {
    prepared: &'a Prepared,
    watch: &'a dyn Watch,
    stages: Vec<StageReport>,
    cache: Option<&'a Cache>,
}

/// What a stage gives and says.
type Told<T> = crate::core::Result<(T, Figures)>;

impl Run<'_> {
    fn run(mut self, set: &[String]) -> Result<Outcome> {
        let prepared = self.prepared;
        let Some(transfer) = &prepared.pipeline.transfer else {
            return Err(Diagnostic::new(Kind::Internal, "a pipeline without stages was taken for checked").into());
        };
        staging::remove_abandoned(&prepared.outputs.places());
        let (source, target) = (&prepared.source, &prepared.target);
        let recipes = self.cache.map(|cache| cache.recipes(prepared));
        let recipes = recipes.as_ref();
        let kept = self.cache.zip(recipes).and_then(|(cache, recipes)| {
            let kept: OfTransfer = cache.get("transfer", recipes.transfer.key)?;
            let shelf = Shelf { cache, recipes, motion: kept.motion };
            (0..prepared.poses.len()).into_par_iter().all(|i| shelf.get(i).is_some()).then_some((kept, shelf))
        });
        // Where every pose is kept, stages are only asked for what they said, and for what metrics want to know.
        let seen = !prepared.outputs.pages.is_empty() || !prepared.outputs.sheets.is_empty();
        // Pictures show more than figures, so that for them everything is measured again.
        let said: Option<Vec<Said>> = kept
            .as_ref()
            .filter(|_| !seen)
            .and_then(|(_, shelf)| (0..prepared.poses.len()).into_par_iter().map(|i| shelf.said(i)).collect());
        let judged = said.is_none() && prepared.metrics.iter().any(|metric| !metric.needs_truth());
        let needed = kept.is_none() || judged || prepared.outputs.correspondence.is_some();

        let of_proximity = recipes.and_then(|recipes| recipes.proximity.as_ref());
        let graph = match &prepared.pipeline.proximity {
            None => None,
            Some(proximity) => self.kept_or("proximity", proximity.typetag_name(), of_proximity, needed, || {
                let graph = proximity.proximity(&target.surface)?;
                graph.check(&target.surface)?;
                let figures = graph.figures.clone();
                Ok((graph, figures))
            })?,
        };
        let pair = TransferPair {
            source: &source.surface,
            target: &target.surface,
            markers: &prepared.markers,
            proximity: graph.as_ref(),
        };

        let of_map = recipes.and_then(|recipes| recipes.correspondence.as_ref());
        let map = match &prepared.pipeline.correspondence {
            None => None,
            Some(correspondence) => {
                self.kept_or("correspondence", correspondence.typetag_name(), of_map, needed, || {
                    let mut map = correspondence.correspond(pair)?;
                    map.check(pair)?;
                    map.figures.set("orphans", map.orphan_count());
                    let figures = map.figures.clone();
                    Ok((map, figures))
                })?
            }
        };
        let map = map.unwrap_or_else(|| TriangleMap::unknown(pair));
        let mut bound = None;
        let shelf = if let Some((kept, shelf)) = kept {
            let clock = Clock::start();
            self.stages.push(clock.stop("transfer", transfer.typetag_name(), kept.figures).reused());
            Some(shelf)
        } else {
            let learned = poses::some(prepared, transfer.poses_wanted())?;
            let bound = bound.insert(self.stage("transfer", transfer.typetag_name(), || {
                let bound = transfer.bind_to_poses(pair, &map, &learned)?;
                let figures = bound.figures();
                Ok((bound, figures))
            })?);
            self.cache.zip(recipes).map(|(cache, recipes)| {
                let motion = bound.motion().is_some();
                cache.put("transfer", recipes.transfer.key, &OfTransfer { figures: bound.figures(), motion });
                Shelf { cache, recipes, motion }
            })
        };
        if let (Some(cache), Some(recipes)) = (self.cache, recipes) {
            Record::of(recipes).keep(&cache.store, prepared);
        }

        let mut staged = Vec::new();
        if let Some(path) = &prepared.outputs.correspondence {
            staged.push(keep(path, &map)?);
        }
        self.watch.poses(prepared.poses.len());
        let bound = bound.as_deref();
        let known = prepared.pipeline.correspondence.as_ref().map(|_| &map);
        let subject = MetricContext {
            rest: &target.sequence.rest,
            surface: &target.surface,
            pair: Some(pair),
            map: known.filter(|map| map.orphan_count() < map.partners.len()),
        };
        let judges = match said {
            Some(_) => Judges::of_limits(&prepared.metrics),
            None => Judges::bind(&prepared.metrics, subject)?,
        };
        let judges = judges.with_gates(&prepared.gates);
        let gallery = seen.then(|| Gallery::new(prepared));
        let bench = Bench {
            prepared,
            transfer: transfer.typetag_name(),
            bound,
            shelf,
            judges: &judges,
            said: said.as_deref(),
            gallery: gallery.as_ref(),
            watch: self.watch,
        };
        let clock = Clock::start();
        let Stream { poses, failed, files, warnings } = bench.stream()?;
        staged.extend(files);
        self.stages.push(clock.stop("poses", "", Figures::default()));
        if failed.len() == poses.len() {
            return Err(Diagnostics { diagnostics: failed });
        }

        self.watch.stage("writing");
        let clock = Clock::start();
        let inputs = inputs(prepared)?;
        let outputs = staged.iter().map(staging::Staged::written).collect();
        self.stages.push(clock.stop("writing", "", Figures::default()));
        if let Some(cache) = self.cache {
            cache.store.clean_up();
        }
        let silent: Vec<String> = prepared.gates.iter().filter(|gate| !gate.is_measured(&poses)).map(silent).collect();
        let of_cache = self.cache.map(Cache::warnings).unwrap_or_default();
        let mut report = Report {
            mimesh: env!("CARGO_PKG_VERSION").into(),
            status: if failed.is_empty() { "done" } else { "partly" }.into(),
            pipeline: prepared.file.clone(),
            settings: settings(prepared),
            set: set.to_vec(),
            threads: rayon::current_num_threads(),
            inputs,
            source: MeshFigures::new(source),
            target: MeshFigures::new(target),
            markers: prepared.markers.len(),
            run: RunOf::new(&prepared.variant),
            verdict: worst(&poses).max(silent.first().map(|_| Level::Failed)),
            gates: prepared.gates.iter().map(|gate| (gate.key.clone(), gate.limit.into())).collect(),
            warnings: prepared.warnings.iter().cloned().chain(warnings).chain(silent).chain(of_cache).collect(),
            metrics: over_poses(&poses),
            seconds: self.stages.iter().map(|stage| stage.seconds).sum(),
            stages: self.stages,
            poses,
            outputs,
            process: process::usage(),
        };
        deduplicate(&mut report.warnings);
        if let Some(gallery) = gallery {
            let looks = looks(prepared, &report, gallery)?;
            report.outputs.extend(looks.iter().map(staging::Staged::written));
            staged.extend(looks);
        }
        staged.push(stage_report(&prepared.outputs.report, &report)?);
        staging::commit(staged)?;
        Ok(Outcome { report, failed })
    }

    /// The result of a stage: the kept one, or that of `work`, which is then kept; `None` if it is neither kept nor `needed`.
    fn kept_or<T: Keep + HasFigures>(
        &mut self,
        stage: &'static str,
        name: &str,
        recipe: Option<&Recipe>,
        needed: bool,
        work: impl FnOnce() -> Told<T>,
    ) -> Result<Option<T>> {
        let clock = Clock::start();
        if let Some(kept) = self.cache.zip(recipe).and_then(|(cache, recipe)| cache.get::<T>(stage, recipe.key)) {
            self.stages.push(clock.stop(stage, name, kept.figures().clone()).reused());
            return Ok(Some(kept));
        }
        if !needed {
            return Ok(None);
        }
        let result = self.stage(stage, name, work)?;
        if let Some((cache, recipe)) = self.cache.zip(recipe) {
            cache.put(stage, recipe.key, &result);
        }
        Ok(Some(result))
    }

    /// Runs a stage, notes its time and figures, and names it in its error.
    fn stage<T>(&mut self, stage: &'static str, name: &str, work: impl FnOnce() -> Told<T>) -> Result<T> {
        self.watch.stage(&format!("{stage} ({name})"));
        let clock = Clock::start();
        match work() {
            Ok((result, figures)) => {
                self.stages.push(clock.stop(stage, name, figures));
                Ok(result)
            }
            Err(error) => {
                let diagnostic = Diagnostic::from(error);
                // Some say themselves which stage they are about.
                let message = diagnostic.message.trim_start_matches(&format!("{stage}: ")).to_owned();
                Err(Diagnostic { message, ..diagnostic }.doing(format!("{stage} ({name})")).into())
            }
        }
    }
}

/// A result that says something of itself.
trait HasFigures {
    fn figures(&self) -> &Figures;
}

impl HasFigures for ProximityGraph {
    fn figures(&self) -> &Figures {
        &self.figures
    }
}

impl HasFigures for TriangleMap {
    fn figures(&self) -> &Figures {
        &self.figures
    }
}

/// The correspondence as a file that `from_file` reads.
fn keep(path: &Path, map: &TriangleMap) -> crate::core::Result<staging::Staged> {
    staging::stage(path, |out| {
        let mut contents = json!({ "format": "mimesh-correspondence", "version": 1 });
        if let (Value::Object(contents), Ok(Value::Object(map))) = (&mut contents, serde_json::to_value(map)) {
            contents.extend(map);
        }
        writeln!(out, "{contents}").map_err(|error| Error::write(path, error))
    })
}

/// The pages and sheets of a run, written aside.
fn looks(prepared: &Prepared, report: &Report, gallery: Gallery<'_>) -> crate::core::Result<Vec<staging::Staged>> {
    let mut staged = Vec::new();
    for path in &prepared.outputs.sheets {
        staged.push(staging::stage_bytes(path, &gallery.sheet())?);
    }
    if !prepared.outputs.pages.is_empty() {
        let page = page::page(report, &gallery.pictures());
        for path in &prepared.outputs.pages {
            staged.push(staging::stage_bytes(path, page.as_bytes())?);
        }
    }
    Ok(staged)
}

fn stage_report(path: &Path, report: &Report) -> crate::core::Result<staging::Staged> {
    let text = serde_json::to_string_pretty(report).unwrap_or_default();
    staging::stage(path, |out| writeln!(out, "{text}").map_err(|error| Error::write(path, error)))
}

/// The settings in full.
fn settings(prepared: &Prepared) -> Value {
    let mut settings = serde_json::to_value(&prepared.pipeline).unwrap_or_default();
    settings["metrics"] = serde_json::to_value(&prepared.metrics).unwrap_or_default();
    settings["formats"] = serde_json::to_value(prepared.formats.all()).unwrap_or_default();
    settings
}

/// Size and hash of every file that was read.
fn inputs(prepared: &Prepared) -> Result<Vec<InputFile>> {
    let hashed = |input: &super::check::Input| {
        let bytes = std::fs::metadata(&input.path)?.len();
        let blake3 = hash_file(&input.path)?;
        Ok(InputFile { role: input.role.into(), path: input.path.clone(), bytes, blake3 })
    };
    let told = |input: &super::check::Input| match hashed(input) {
        Ok(file) => Some(Ok(file)),
        // A pose that cannot be read has been told; it is left out here.
        Err(_) if input.is_pose() => None,
        Err(error) => Some(Err(Diagnostics::from(Error::read(&input.path, error)))),
    };
    prepared.inputs.par_iter().filter_map(told).collect()
}

/// That a gate has had nothing to hold.
fn silent(gate: &Gate) -> String {
    format!(
        "the gate `{}` is broken: {} gave `{}` for no pose; remove the gate, or see `mimesh show metric {}` for what it needs",
        gate.key, gate.metric, gate.figure, gate.metric
    )
}

/// The worst that is to be said of any pose.
fn worst(poses: &[PoseReport]) -> Option<Level> {
    poses.iter().filter_map(|pose| Some(pose.verdict.as_ref()?.level)).max()
}

fn deduplicate(warnings: &mut Vec<String>) {
    let mut seen = std::collections::HashSet::new();
    warnings.retain(|warning| seen.insert(warning.clone()));
}

/// An error about the pose `name`, at its file if it has one.
pub(super) fn of_pose(name: &str, file: Option<&Path>, doing: Option<String>, error: Error) -> Diagnostic {
    let diagnostic = Diagnostic::from(error);
    let diagnostic = match doing {
        Some(doing) => diagnostic.doing(format!("{doing}: pose {name}")),
        None => diagnostic,
    };
    match (diagnostic.location.is_none(), file) {
        (true, Some(file)) => diagnostic.at(Location::File(file.into())),
        _ => diagnostic,
    }
}
