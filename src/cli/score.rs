use std::path::{Path, PathBuf};

use nalgebra::Point3;
use serde_json::{Map, Value, json};

use super::{Ended, summary::scores, terminal};
use crate::text::count;
use crate::{
    core::mesh::{Mesh, MeshSequence, Surface, diagonal},
    diagnostic::{Diagnostic, Kind, Result},
    pipeline::{
        Formats,
        check::{in_file, nearby},
        judge::point_error,
        report::{PoseReport, over_poses},
        resolve::{self, Found},
    },
    status::Status,
};

/// Scores results against known results of the same vertices, in percent of the diagonal of the rest mesh.
///
/// The result is moved so that its centroid lies on that of the truth; `placed` is the mean error without that move.
/// The average's rms is the root mean square over all files.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  mimesh score out/camel-01.obj truth/camel-01.obj --rest camel-reference.obj
  mimesh score 'out/camel-*.obj' 'truth/camel-??.obj' --rest camel-reference.obj --at-most rms=1.5")]
pub struct Score {
    /// The result: a file, or a glob in quotes
    result: String,
    /// The known result: a file, or a glob in quotes of as many files
    truth: String,
    /// The target at rest, whose bounding box gives the length that errors are relative to [default: the first truth]
    #[arg(long, value_name = "MESH")]
    rest: Option<PathBuf>,
    /// End with exit status 3 if an average is larger than this, e.g. rms=1.5
    #[arg(long, value_name = "FIGURE=PERCENT")]
    at_most: Vec<String>,
    /// Print the scores as JSON
    #[arg(long)]
    json: bool,
}

/// Positions with a name.
struct Posed {
    name: String,
    mesh: Mesh,
    positions: Vec<Point3<f64>>,
    file: PathBuf,
}

impl Score {
    /// Runs the command.
    pub fn run(&self) -> Ended {
        let limits = self.limits()?;
        let formats = Formats::new(vec![]);
        let results = read_all(&formats, &self.result)?;
        let truths = read_all(&formats, &self.truth)?;
        if results.len() != truths.len() {
            let results = count(results.len(), "result", "results");
            let message = format!("{results}, but {}", count(truths.len(), "known result", "known results"));
            let hint = "both are taken in natural order, one against the other; give globs that match as many files";
            return Err(Diagnostic::new(Kind::Usage, message).hint(hint).into());
        }
        let rest = match &self.rest {
            Some(file) => read(&formats, file)?.rest,
            None => Mesh { positions: truths[0].positions.clone(), ..truths[0].mesh.clone() },
        };
        let vertices = |mesh: &Mesh, file: &Path| (mesh.positions.len(), file.display().to_string());
        let (expected, of) = vertices(&rest, self.rest.as_ref().unwrap_or(&truths[0].file));
        for posed in truths.iter().chain(&results) {
            let (found, file) = vertices(&posed.mesh, &posed.file);
            if found != expected {
                let message = format!("{file} has {}, {of} {expected}", count(found, "vertex", "vertices"));
                let hint = "results, known results and the rest mesh are one mesh in several poses";
                return Err(Diagnostic::new(Kind::BadData, message).hint(hint).into());
            }
        }
        let surface = Surface::new(&rest)?;
        let mut poses = Vec::new();
        for (result, truth) in results.iter().zip(&truths) {
            let measured = |positions: &[Point3<f64>]| -> Result<Map<String, Value>> {
                let measured = point_error(&rest, &surface, positions, &truth.positions);
                let figures = measured.map_err(|error| in_file(&result.file, error))?.figures;
                let figures = serde_json::to_value(&figures).unwrap_or_default();
                Ok(std::iter::once(("point_error".to_owned(), figures)).collect())
            };
            let nothing = if self.rest.is_some() { measured(&rest.positions)? } else { Default::default() };
            let metrics = measured(&result.positions)?;
            poses.push(PoseReport { name: result.name.clone(), metrics, nothing, ..PoseReport::default() });
        }
        let summary = over_poses(&poses).remove("point_error").unwrap_or_default();
        for (figure, _) in &limits {
            if !summary["average"][figure].is_number() {
                let known = summary["average"].as_object().into_iter().flatten().map(|(figure, _)| figure.as_str());
                let hint = format!("known figures: {}", known.collect::<Vec<_>>().join(", "));
                let message = format!("--at-most: there is no figure `{figure}`");
                return Err(Diagnostic::new(Kind::Usage, message).hint(hint).into());
            }
        }
        if self.json {
            let pair = |(i, pose): (usize, &PoseReport)| {
                json!({
                    "result": results[i].file, "truth": truths[i].file, "pose": pose.name,
                    "score": pose.metrics.get("point_error"), "nothing": pose.nothing.get("point_error"),
                })
            };
            let pairs: Vec<_> = poses.iter().enumerate().map(pair).collect();
            terminal::print_json(
                &json!({ "diagonal": diagonal(&rest.positions), "poses": pairs, "over_poses": summary }),
            );
        } else {
            terminal::print(&format!("percent of the diagonal\n{}", scores("point_error", &summary, &poses)));
        }
        let mut status = Status::Done;
        for (figure, limit) in limits {
            let found = summary["average"][&figure].as_f64().unwrap_or(f64::NAN);
            if found.is_nan() || found > limit {
                terminal::warn(&format!("{figure} is {found:.4} %, more than {limit} %"));
                status = Status::Gate;
            }
        }
        Ok(status)
    }

    fn limits(&self) -> Result<Vec<(String, f64)>> {
        let limit = |text: &String| {
            let (figure, value) = text.split_once('=')?;
            Some((figure.to_owned(), value.parse().ok()?))
        };
        let wrong = |text: &String| {
            let message = format!("--at-most {text}: expected `figure=percent`");
            Diagnostic::new(Kind::Usage, message).hint("e.g. `--at-most rms=1.5`").into()
        };
        self.at_most.iter().map(|text| limit(text).ok_or_else(|| wrong(text))).collect()
    }
}

/// The positions in all files of `pattern`: of the poses that a file holds, else of its mesh.
fn read_all(formats: &Formats, pattern: &str) -> Result<Vec<Posed>> {
    let found = resolve::expand(Path::new(""), pattern)
        .map_err(|problem| Diagnostic::new(Kind::Usage, format!("`{pattern}` is no glob: {problem}")))?;
    if found.is_empty() {
        let message = format!("no file matches `{pattern}`");
        return Err(Diagnostic::new(Kind::MissingInput, message).hint(nearby(Path::new(pattern))).into());
    }
    let mut all = Vec::new();
    for Found { path, name } in found {
        let MeshSequence { rest, poses, .. } = read(formats, &path)?;
        if poses.is_empty() {
            let positions = rest.positions.clone();
            all.push(Posed { name, mesh: rest, positions, file: path });
        } else {
            let posed = |pose: crate::core::mesh::Pose| Posed {
                name: pose.name,
                mesh: rest.clone(),
                positions: pose.positions,
                file: path.clone(),
            };
            all.extend(poses.into_iter().map(posed));
        }
    }
    Ok(all)
}

fn read(formats: &Formats, file: &Path) -> Result<MeshSequence> {
    Ok(formats.reader_of(file)?.read(file).map_err(|error| in_file(file, error))?)
}
