//! `mimesh score`: the errors of results against known results.

use crate::cli::roots::Roots;
use std::{
    collections::HashSet,
    path::{Path, PathBuf},
};

use mimesh_core::mesh::{Mesh, Surface};
use mimesh_document::diagnostic::{Diagnostic, Kind, Result};
use mimesh_markers::IntoDiagnostic;
use mimesh_pipeline::{
    check::in_file,
    globs::GlobMatch,
    json::to_value,
    metrics::{over_poses, point_error},
    report::{PoseReport, Statistics},
    text::{count, some_of},
};
use nalgebra::Point3;
use serde_json::{Map, Value, json};

use crate::cli::{
    CommandResult,
    posed_meshes::{PosedMesh, read, read_all},
    status::Status,
    summary::scores,
    terminal,
};

/// Measures the errors of results against known results, in percent of the diagonal of the rest mesh.
///
/// Results and known results have the same vertices. Each result is moved so that its centroid lies on that of the
/// known result; `placed` is the mean error without this move. The average `rms` is the root mean square over all files.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  mimesh score out/camel-01.obj truth/camel-01.obj --rest camel-reference.obj
  mimesh score 'out/camel-*.obj' 'truth/camel-??.obj' --rest camel-reference.obj --at-most rms=1.5")]
pub struct Score {
    /// The result: a file, or a glob in quotes
    result: String,
    /// The known result: a file, or a glob in quotes of as many files
    truth: String,
    /// The target at rest; errors are relative to the diagonal of its bounding box [default: the first known result]
    #[arg(long, value_name = "MESH")]
    rest: Option<PathBuf>,
    /// End with exit status 3 if an average is larger than this, e.g. rms=1.5
    #[arg(long, value_name = "STATISTIC=PERCENT")]
    at_most: Vec<String>,
    #[command(flatten)]
    roots: Roots,
    /// Print the scores as JSON
    #[arg(long)]
    json: bool,
}

/// A limit for the average of a statistic.
struct Limit {
    /// The name of the statistic.
    statistic: String,
    /// The largest value that passes, in percent.
    percent: f64,
}

impl Score {
    /// Runs the command.
    pub fn run(&self) -> CommandResult {
        let limits = self.at_most.iter().map(|text| parse_limit(text)).collect::<Result<Vec<_>>>()?;
        let formats = self.roots.formats();
        let name = |found: &GlobMatch| found.name.clone();
        let truths = read_all(&formats, &self.truth, name)?;
        let results = of_names(read_all(&formats, &self.result, name)?, &truths);
        if results.len() != truths.len() {
            let results = count(results.len(), "result", "results");
            let message = format!("{results}, but {}", count(truths.len(), "known result", "known results"));
            let hint = "results and known results pair up in natural order; give globs that match as many files";
            return Err(Diagnostic::new(Kind::Usage, message).hint(hint).into());
        }
        let rest = match &self.rest {
            Some(file) => read(&formats, file)?.rest,
            None => truths[0].mesh.clone(),
        };
        let rest_file = self.rest.as_ref().unwrap_or(&truths[0].file);
        truths.iter().chain(&results).try_for_each(|posed| check_vertices(posed, &rest, rest_file))?;
        let poses = self.measure(&rest, &results, &truths)?;
        let summary = over_poses(&poses).remove("point_error").unwrap_or_default();
        limits.iter().try_for_each(|limit| check_statistic(&limit.statistic, &summary))?;
        if self.json {
            terminal::print_json(&json!({
                "diagonal": rest.diagonal(), "poses": poses_json(&poses, &results, &truths),
                "over_poses": summary,
            }));
        } else {
            terminal::print(&format!("percent of the diagonal\n{}", scores("point_error", &summary, &poses)));
        }
        Ok(check_limits(&limits, &summary))
    }

    /// The metric `point_error` of each result, and of the rest mesh in its place if that is given.
    fn measure(&self, rest: &Mesh, results: &[PosedMesh], truths: &[PosedMesh]) -> Result<Vec<PoseReport>> {
        let surface = Surface::new(rest).map_err(IntoDiagnostic::into_diagnostic)?;
        let mut poses = Vec::new();
        for (result, truth) in results.iter().zip(truths) {
            let measure = |positions: &[Point3<f64>]| -> Result<Statistics> {
                let measured = point_error(rest, &surface, positions, &truth.mesh.positions);
                let statistics = measured.map_err(|error| in_file(&result.file, error))?.statistics;
                let statistics = to_value(&statistics);
                Ok(Map::from_iter([("point_error".to_owned(), statistics)]).into())
            };
            let rest_baseline = if self.rest.is_some() { measure(&rest.positions)? } else { Statistics::default() };
            let metrics = measure(&result.mesh.positions)?;
            poses.push(PoseReport { name: result.name.clone(), metrics, rest_baseline, ..PoseReport::default() });
        }
        Ok(poses)
    }
}

/// Of more results than there are known ones those of the names that are known, in that order; all where a name is missing.
///
/// A file of results may hold shapes that the target had before.
fn of_names(mut results: Vec<PosedMesh>, truths: &[PosedMesh]) -> Vec<PosedMesh> {
    let known: HashSet<&str> = truths.iter().map(|truth| &*truth.name).collect();
    let found: HashSet<&str> = results.iter().map(|result| &*result.name).collect();
    if results.len() <= truths.len() || known.len() < truths.len() || !known.is_subset(&found) {
        return results;
    }
    let names = results.iter().map(|result| &*result.name);
    let others: Vec<&str> = names.filter(|name| !known.contains(name)).collect();
    if results.len() - others.len() > truths.len() {
        return results;
    }
    terminal::warn(&format!("results without a known result are left out: {}", some_of(&others)));
    results.retain(|result| known.contains(&*result.name));
    results.sort_by_key(|result| truths.iter().position(|truth| truth.name == result.name));
    results
}

/// Parses an argument of `--at-most`.
fn parse_limit(text: &str) -> Result<Limit> {
    let parts = text.split_once('=').and_then(|(statistic, percent)| Some((statistic, percent.parse::<f64>().ok()?)));
    match parts {
        Some((statistic, percent)) if percent.is_finite() => Ok(Limit { statistic: statistic.into(), percent }),
        _ => {
            let message = format!("--at-most {text}: expected `STATISTIC=PERCENT`");
            Err(Diagnostic::new(Kind::Usage, message).hint("e.g. `--at-most rms=1.5`").into())
        }
    }
}

/// Checks that `posed` has as many vertices as the rest mesh.
fn check_vertices(posed: &PosedMesh, rest: &Mesh, rest_file: &Path) -> Result<()> {
    let (found, expected) = (posed.mesh.positions.len(), rest.positions.len());
    if found == expected {
        return Ok(());
    }
    let vertices = count(found, "vertex", "vertices");
    let message = format!("{} has {vertices}, {} {expected}", posed.file.display(), rest_file.display());
    let hint = "results, known results and the rest mesh are one mesh in several poses";
    Err(Diagnostic::new(Kind::BadData, message).hint(hint).into())
}

/// Checks that the average of `statistic` is measured.
fn check_statistic(statistic: &str, summary: &Value) -> Result<()> {
    if summary["average"][statistic].is_number() {
        return Ok(());
    }
    let known = summary["average"].as_object().into_iter().flatten().map(|(name, _)| name.as_str());
    let hint = format!("known statistics: {}", known.collect::<Vec<_>>().join(", "));
    let message = format!("--at-most: there is no statistic `{statistic}`");
    Err(Diagnostic::new(Kind::Usage, message).hint(hint).into())
}

/// Warns of each average above its limit; the exit status is that of a broken gate if there is one.
fn check_limits(limits: &[Limit], summary: &Value) -> Status {
    let mut status = Status::Done;
    for Limit { statistic, percent } in limits {
        let found = summary["average"][statistic].as_f64().unwrap_or(f64::NAN);
        if found.is_nan() || found > *percent {
            terminal::warn(&format!("{statistic} is {found:.4} %, more than {percent} %"));
            status = Status::Gate;
        }
    }
    status
}

fn poses_json(poses: &[PoseReport], results: &[PosedMesh], truths: &[PosedMesh]) -> Vec<Value> {
    let pose_json = |(pose, (result, truth)): (&PoseReport, (&PosedMesh, &PosedMesh))| {
        json!({
            "result": terminal::shown(&result.file), "truth": terminal::shown(&truth.file), "pose": pose.name,
            "score": pose.metrics.get("point_error"), "nothing": pose.rest_baseline.get("point_error"),
        })
    };
    poses.iter().zip(results.iter().zip(truths)).map(pose_json).collect()
}
