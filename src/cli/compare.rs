use std::{
    collections::HashMap,
    path::{Path, PathBuf},
};

use mimesh_render::Picture;
use nalgebra::Point3;
use rayon::prelude::*;
use serde_json::{Value, json};

use super::{Ended, terminal};
use crate::{
    core::{
        Error,
        mesh::{Mesh, Surface},
        stage::Generator,
    },
    diagnostic::{Diagnostic, Kind, Location, Result},
    page::{self, Shown},
    pipeline::{
        Formats, OneOrMany, Report,
        check::in_file,
        judge::point_error,
        pictures::{self, Look},
        resolve, spread, staging,
    },
    status::Status,
    text::{number, seconds, table},
};

/// Shows runs beside each other: figures, curves and pictures.
///
/// The best of each line is marked with `*` if all have the same target. Results that lie beside their report as they were
/// written are drawn, with errors in colour where the truth is known.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  mimesh compare out/gradient/run.json out/biharmonic/run.json
  mimesh compare 'out/herd/*/run.json' --out herd.html
  mimesh compare try-1 try-2 --json")]
pub struct Compare {
    /// Reports of runs (run.json), folders that have one, or globs of them in quotes; two at least
    #[arg(required = true)]
    runs: Vec<String>,
    /// Write a page with curves and pictures into this file
    #[arg(long, value_name = "FILE.html")]
    out: Option<PathBuf>,
    /// Print the table as JSON
    #[arg(long)]
    json: bool,
}

/// Poses of a run that are drawn at most; of more some spread over all.
const MOST: usize = 24;
/// Width and height of a picture.
const PIXELS: u32 = 280;

impl Compare {
    /// Runs the command.
    pub fn run(&self) -> Ended {
        if let Some(out) = &self.out {
            check_out(out, &["html", "htm"])?;
        }
        let mut files = Vec::new();
        for pattern in &self.runs {
            for file in found(pattern)? {
                if !files.contains(&file) {
                    files.push(file);
                }
            }
        }
        if files.len() < 2 {
            let message = format!("{} is the only report, expected two at least", files[0].display());
            let hint = "a run with a matrix or several targets has a report for each combination";
            return Err(Diagnostic::new(Kind::Usage, message).hint(hint).into());
        }
        let reports: Vec<Report> = files.iter().map(|file| read(file)).collect::<Result<_>>()?;
        let names = names(&files, &reports);
        let mut runs: Vec<Shown> =
            names.into_iter().zip(reports).map(|(name, report)| Shown { name, report, pictures: vec![] }).collect();
        if let Some(out) = &self.out {
            let identity = resolve::identity(out);
            let of_runs = reports_and_results(&runs, &files);
            if of_runs.iter().any(|path| resolve::identity(path) == identity) {
                let location = Location::Option(format!("--out {}", out.display()));
                let diagnostic = Diagnostic::new(Kind::CannotWrite, "this is what one of the runs wrote").at(location);
                return Err(diagnostic.hint("choose another name").into());
            }
            for (run, file) in runs.iter_mut().zip(&files) {
                let (pictures, problems) = draw(&run.report, file);
                problems.iter().for_each(|problem| terminal::warn(&format!("{}: {problem}", run.name)));
                run.pictures = pictures;
            }
            let page = page::compare("Comparison of runs", &runs);
            staging::write(out, page.as_bytes())?;
        }
        if self.json {
            terminal::print_json(&as_json(&files, &runs));
        } else {
            terminal::print(&as_text(&runs));
            if let Some(out) = &self.out {
                terminal::print(&format!("\nwritten\n  {}\n", out.display()));
            }
        }
        Ok(Status::Done)
    }
}

/// The files that are read, or may be.
fn reports_and_results(runs: &[Shown], files: &[PathBuf]) -> Vec<PathBuf> {
    let written = runs.iter().zip(files).flat_map(|(run, file)| Written::new(&run.report, file).files);
    files.iter().cloned().chain(written.map(|(path, _)| path)).collect()
}

/// That `out` has one of `extensions`, and is no folder.
pub fn check_out(out: &Path, extensions: &[&str]) -> Result<()> {
    let location = Location::Option(format!("--out {}", out.display()));
    let extension = out.extension().map(|extension| extension.to_string_lossy().to_lowercase());
    if !extension.is_some_and(|extension| extensions.contains(&extension.as_str())) {
        let message = format!("expected a .{} file", extensions[0]);
        return Err(Diagnostic::new(Kind::Usage, message).at(location).into());
    }
    if out.is_dir() {
        let diagnostic = Diagnostic::new(Kind::CannotWrite, "there is a folder of that name").at(location);
        return Err(diagnostic.hint("choose another name").into());
    }
    Ok(())
}

/// The reports that `pattern` stands for, at least one.
fn found(pattern: &str) -> Result<Vec<PathBuf>> {
    let expand = |pattern: &str| resolve::expand(Path::new(""), pattern);
    let mut all = expand(pattern)
        .map_err(|problem| Diagnostic::new(Kind::Usage, format!("`{pattern}` is no glob: {problem}")))?;
    if resolve::is_glob(pattern) {
        // Folders match a glob too.
        for report in ["run.json", "run-*.json"] {
            all.extend(expand(&format!("{}/{report}", pattern.trim_end_matches('/'))).unwrap_or_default());
        }
    }
    let mut files: Vec<PathBuf> = Vec::new();
    for one in all {
        if one.path.is_dir() {
            files.extend(in_folder(&one.path));
        } else {
            files.push(one.path);
        }
    }
    match files.iter().find(|file| !file.is_file()) {
        Some(missing) => {
            let message = format!("no such file: {}", missing.display());
            let hint = "a run writes its report beside its first result, as `run.json`";
            Err(Diagnostic::new(Kind::MissingInput, message).hint(hint).into())
        }
        None if files.is_empty() => {
            let message = format!("no file matches `{pattern}`");
            let hint = "a run writes its report beside its first result, as `run.json`";
            Err(Diagnostic::new(Kind::MissingInput, message).hint(hint).into())
        }
        None => Ok(files),
    }
}

/// The report in a folder; of several runs that wrote there, all.
fn in_folder(folder: &Path) -> Vec<PathBuf> {
    let one = folder.join("run.json");
    let several = resolve::expand(folder, "run-*.json").unwrap_or_default();
    if one.is_file() || several.is_empty() {
        return vec![one];
    }
    several.into_iter().map(|found| found.path).collect()
}

fn read(file: &Path) -> Result<Report> {
    let text = std::fs::read_to_string(file).map_err(|error| Diagnostic::from(Error::read(file, error)))?;
    let report = serde_json::from_str(&text).map_err(|error| {
        Diagnostic::new(Kind::BadData, format!("not the report of a run: {error}"))
            .at(Location::File(file.into()))
            .hint("give the `run.json` that `mimesh run` writes; one of an older version is made anew by running again")
    })?;
    Ok(report)
}

/// What tells runs apart: the name of the run, else of the folder, else the path.
fn names(files: &[PathBuf], reports: &[Report]) -> Vec<String> {
    let of_run = |(_, report): (&PathBuf, &Report)| report.run.as_ref().map(|run| run.name.clone());
    let folder = |(file, _): (&PathBuf, &Report)| Some(file.parent()?.file_name()?.to_string_lossy().into_owned());
    let path = |(file, _): (&PathBuf, &Report)| Some(file.display().to_string());
    let apart = |names: &Option<Vec<String>>| {
        names.as_ref().is_some_and(|names| names.iter().collect::<std::collections::HashSet<_>>().len() == names.len())
    };
    let all = || files.iter().zip(reports);
    let choices = [all().map(of_run).collect(), all().map(folder).collect(), all().map(path).collect()];
    let names = choices.into_iter().find(apart).flatten();
    without_common_beginning(names.unwrap_or_else(|| files.iter().map(|f| f.display().to_string()).collect()))
}

/// Names without the words that all of them begin with, where something is left of each.
fn without_common_beginning(names: Vec<String>) -> Vec<String> {
    let Some(first) = names.first() else { return names };
    let ends = |(i, c): (usize, char)| "-/,_ ".contains(c).then_some(i + c.len_utf8());
    let common = |end: &usize| names.iter().all(|name| name.len() > *end && name.starts_with(&first[..*end]));
    let cut = first.char_indices().filter_map(ends).rfind(common).unwrap_or(0);
    names.iter().map(|name| name[cut..].to_owned()).collect()
}

fn as_text(runs: &[Shown]) -> String {
    let mut rows = vec![std::iter::once(String::new()).chain(runs.iter().map(|run| run.name.clone())).collect()];
    let verdict = |run: &Shown| run.report.verdict.map_or("-", |level| level.word()).to_owned();
    rows.push(std::iter::once("verdict".to_owned()).chain(runs.iter().map(verdict)).collect());
    for column in page::columns(runs) {
        let values: Vec<_> = runs.iter().map(|run| page::average(&run.report, &column)).collect();
        let best = page::best(runs, &values);
        let cell = |(i, value): (usize, &Option<f64>)| match value {
            Some(value) => format!("{}{}", if best == Some(i) { "*" } else { "" }, number(*value)),
            None => "-".into(),
        };
        let name = format!("{} {}", column.metric, column.figure);
        rows.push(std::iter::once(name).chain(values.iter().enumerate().map(cell)).collect::<Vec<_>>());
    }
    rows.push(std::iter::once("seconds".to_owned()).chain(runs.iter().map(|r| seconds(r.report.seconds))).collect());
    table(&rows) + "  averages over poses\n"
}

fn as_json(files: &[PathBuf], runs: &[Shown]) -> Value {
    let one = |(file, run): (&PathBuf, &Shown)| {
        json!({
            "name": run.name, "place": file, "run": run.report.run, "status": run.report.status,
            "verdict": run.report.verdict, "markers": run.report.markers, "seconds": run.report.seconds,
            "metrics": run.report.metrics,
        })
    };
    json!({ "runs": files.iter().zip(runs).map(one).collect::<Vec<_>>() })
}

/// Pictures of the poses of the run whose report is `file`, and why there are none of some or all.
fn draw(report: &Report, file: &Path) -> (Vec<page::Image>, Vec<String>) {
    let formats = Formats::new(vec![]);
    let written = Written::new(report, file);
    match results(report, &written, &formats) {
        Ok(results) => {
            let look: Look = serde_json::from_value(report.settings["pictures"].clone())
                .map(Look::of_target)
                .unwrap_or_else(|_| crate::pipeline::PictureSettings::default().into());
            let truth = truth(report, &formats);
            let image = |(name, mesh): &(String, Mesh)| {
                let surface = Surface::new(mesh).ok()?;
                let error = truth.as_ref().and_then(|truth| errors(&truth.rest, truth.poses.get(name)?, mesh));
                let picture: Picture = pictures::plain(&surface, error.as_deref(), look, PIXELS);
                Some(pictures::image(name, format!("result of pose {name}"), &picture))
            };
            (results.par_iter().filter_map(image).collect(), written.changed())
        }
        Err(problem) => (vec![], vec![format!("no pictures: {problem}")]),
    }
}

/// The files that a run wrote, where they are now: as they lay beside the report.
struct Written {
    files: Vec<(PathBuf, u64)>,
}

impl Written {
    fn new(report: &Report, file: &Path) -> Self {
        // The report lies beside the first result, wherever the folder has been moved.
        let then = report.outputs.first().and_then(|first| first.path.parent()).unwrap_or(Path::new(""));
        let now = file.parent().unwrap_or(Path::new(""));
        let location = |path: &PathBuf| path.strip_prefix(then).map_or_else(|_| path.clone(), |inner| now.join(inner));
        Self { files: report.outputs.iter().map(|output| (location(&output.path), output.bytes)).collect() }
    }

    /// The file called as `name`, if it is what the run wrote.
    fn find(&self, name: &Path) -> Option<&PathBuf> {
        let found = self.files.iter().find(|(path, _)| path.file_name() == name.file_name());
        found.filter(|file| is_as_written(file)).map(|(path, _)| path)
    }

    /// A sentence on files that are gone, or have another size than they had.
    fn changed(&self) -> Vec<String> {
        let changed: Vec<_> = self.files.iter().filter(|file| !is_as_written(file)).collect();
        let Some((first, _)) = changed.first() else { return vec![] };
        let more = if changed.len() > 1 { format!(" and {} more", changed.len() - 1) } else { String::new() };
        vec![format!("{}{more} is gone or not as it was written, and is not drawn", first.display())]
    }
}

fn is_as_written((path, bytes): &(PathBuf, u64)) -> bool {
    std::fs::metadata(path).is_ok_and(|found| found.len() == *bytes)
}

/// The results of a run, pose by pose, from the files it wrote.
fn results(report: &Report, written: &Written, formats: &Formats) -> std::result::Result<Vec<(String, Mesh)>, String> {
    let patterns: OneOrMany = serde_json::from_value(report.settings["output"].clone()).unwrap_or_default();
    for pattern in &patterns.items {
        let file = |name: &str| {
            let wanted = PathBuf::from(resolve::with_pose(pattern, name));
            written.find(&wanted)
        };
        if pattern.contains("{pose}") {
            let read = |name: &String| {
                let path = file(name)?;
                Some((name.clone(), formats.reader(path).ok()?.read(path).ok()?.rest))
            };
            let all: Vec<_> =
                spread(report.poses.len(), MOST).into_iter().filter_map(|i| read(&report.poses[i].name)).collect();
            if !all.is_empty() {
                return Ok(all);
            }
        } else if let Some(path) = file("").filter(|path| formats.reader(path).is_ok()) {
            let Ok(format) = formats.reader(path) else { continue };
            let sequence = format.read(path).map_err(|error| in_file(path, error).to_string())?;
            let posed = |pose: crate::core::mesh::Pose| {
                (pose.name, Mesh { positions: pose.positions, ..sequence.rest.clone() })
            };
            let mut poses: Vec<_> = sequence.poses.into_iter().map(Some).collect();
            return Ok(spread(poses.len(), MOST).into_iter().filter_map(|i| poses[i].take()).map(posed).collect());
        }
    }
    Err("its results are not where they were written".into())
}

/// The known results of a run, by name of pose.
struct Truth {
    rest: Mesh,
    poses: HashMap<String, Vec<Point3<f64>>>,
}

fn truth(report: &Report, formats: &Formats) -> Option<Truth> {
    let of_role = |role: &'static str| report.inputs.iter().filter(move |input| input.role == role);
    if let Some(generator) = report.settings["target"].get("generator") {
        let generator: Box<dyn Generator> = serde_json::from_value(generator.clone()).ok()?;
        let sequence = generator.make().ok()?;
        let poses = sequence.poses.into_iter().map(|pose| (pose.name, pose.positions)).collect();
        return Some(Truth { rest: sequence.rest, poses });
    }
    let rest = &of_role("target rest").next()?.path;
    let rest = formats.reader(rest).ok()?.read(rest).ok()?.rest;
    let files: Vec<&PathBuf> = of_role("truth").map(|input| &input.path).collect();
    if files.len() != report.poses.len() {
        return None;
    }
    let read = |(pose, file): (&crate::pipeline::report::PoseReport, &&PathBuf)| {
        Some((pose.name.clone(), formats.reader(file).ok()?.read_pose(file, &rest).ok()?))
    };
    let poses = report.poses.iter().zip(&files).filter_map(read).collect();
    Some(Truth { rest, poses })
}

/// The error of each vertex of `result`, where it has the vertices of the truth.
fn errors(rest: &Mesh, truth: &[Point3<f64>], result: &Mesh) -> Option<Vec<f64>> {
    let surface = Surface::new(rest).ok()?;
    point_error(rest, &surface, &result.positions, truth).ok().map(|measured| measured.field)
}
