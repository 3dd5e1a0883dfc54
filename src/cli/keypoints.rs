//! `mimesh keypoints`: the points of the source that are worth a marker.

use crate::cli::roots::Roots;
use std::{
    io::Write,
    path::{Path, PathBuf},
    sync::atomic::{AtomicBool, Ordering},
    time::Instant,
};

use mimesh_core::{
    mesh::MeshPoint,
    stage::{ChoiceStep, ChoiceWatch},
};
use mimesh_document::diagnostic::{Diagnostic, Kind, Location, Result};
use mimesh_markers::{self, MarkerFile};
use serde_json::json;
use {
    mimesh_pipeline as pipeline,
    mimesh_pipeline::{Options, PreparedSource, key_points, staging},
};

use crate::cli::{
    CommandResult,
    cache::CacheOptions,
    out_file::{OutFile, write_all},
    progress::ShareBar,
    status::Status,
    terminal,
};

/// Chooses the few points of the source that describe its poses best, and writes them as markers to complete.
///
/// The command uses the pipeline's source, its poses and `key_points`. The file has the source side of every marker,
/// with a note on its place. Fill in the vertices of the target, then run the pipeline.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  mimesh keypoints horse.yaml
  mimesh keypoints horse.yaml --set key_points.max_count=12 --output horse.markers.yaml
  mimesh keypoints horse.yaml --resume        continue, with the targets filled in so far")]
pub struct KeyPoints {
    /// The pipeline's YAML file
    pipeline: PathBuf,
    /// Write the markers into this file [default: `markers` of the pipeline, else PIPELINE.markers.yaml]
    #[arg(long, short, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Write the curve of the error over the number of points into this SVG file
    #[arg(long, value_name = "FILE")]
    curve: Option<PathBuf>,
    /// Continue from the points that are in the file of markers
    #[arg(long)]
    resume: bool,
    /// Replace an existing file of markers
    #[arg(long, conflicts_with = "resume")]
    force: bool,
    /// Replace a value of the pipeline, e.g. key_points.threshold=0.02
    #[arg(long = "set", value_name = "KEY=VALUE")]
    settings: Vec<String>,
    #[command(flatten)]
    roots: Roots,
    #[command(flatten)]
    cache: CacheOptions,
    /// Print the points and the steps as JSON
    #[arg(long)]
    json: bool,
    /// Print errors only
    #[arg(long, short)]
    quiet: bool,
}

/// The first line of the file of markers.
const HEADER: &str =
    "# Key points of the source. After each `target:` write the vertex of the target at the same place.\n";

impl KeyPoints {
    /// Runs the command.
    pub fn run(&self) -> CommandResult {
        let options = Options { settings: self.settings.clone(), roots: self.roots.folders(), ..Options::default() };
        let prepared = pipeline::prepare_source(&self.pipeline, &options, self.cache.open()?.as_ref())?;
        let output = self.output_file(&prepared);
        let previous = self.previous_markers(&output)?;
        self.check_output(&prepared, &output)?;
        self.check_curve(&prepared, &output)?;

        static INTERRUPTED: AtomicBool = AtomicBool::new(false);
        // The first interrupt ends the choice after its current step, the second ends the program at once.
        let _ = ctrlc::set_handler(|| {
            if INTERRUPTED.swap(true, Ordering::Relaxed) {
                staging::discard_all_and_exit(Status::Interrupted as u8);
            }
        });
        let progress = ChoiceProgress::new(self.quiet, &INTERRUPTED);
        let started = Instant::now();
        let chosen = key_points::choose(&prepared, &previous, &progress);
        progress.finish();
        let chosen = chosen?;
        let interrupted = INTERRUPTED.load(Ordering::Relaxed);

        let file = key_points::to_complete(&prepared, &chosen.points, &previous);
        let text = format!("{HEADER}{}", mimesh_markers::formats::yaml::write(&file));
        let curve = key_points::curve(&chosen.steps);
        let mut files = vec![(&*output, text.as_bytes())];
        files.extend(self.curve.as_deref().map(|path| (path, curve.as_bytes())));
        let written = write_all(&files)?;
        let open = file.pairs.iter().filter(|pair| pair.target.is_none()).count();
        if self.json {
            let steps: Vec<_> = chosen
                .steps
                .iter()
                .map(|s| json!({ "points": s.points.len(), "error": s.error, "exchanged": s.exchanged }))
                .collect();
            terminal::print_json(&json!({
                "markers": terminal::shown(&output), "points": file.pairs.iter().filter_map(|pair| pair.source).map(point_json).collect::<Vec<_>>(),
                "targets_to_find": open, "steps": steps, "figures": chosen.figures, "interrupted": interrupted,
                "seconds": started.elapsed().as_secs_f64(),
            }));
        } else if !self.quiet {
            chosen.figures.warnings.iter().for_each(|warning| terminal::warn(warning));
            let error = chosen.steps.last().map_or(String::new(), |step| {
                format!(
                    ", error {:.4} (mean distance to the poses, with the source scaled to the unit sphere)",
                    step.error
                )
            });
            let (count, seconds) = (chosen.points.len(), started.elapsed().as_secs_f64());
            let mut text = format!("{count} key points{error}, {seconds:.1} s\n");
            for file in &written {
                text.push_str(&format!("written: {}\n", file.display()));
            }
            if open > 0 {
                text.push_str(&format!(
                    "{open} targets are missing: write a vertex of the target after each `target:`\n"
                ));
            }
            terminal::print(&text);
        }
        Ok(if interrupted { Status::Interrupted } else { Status::Done })
    }

    /// The file of markers to write.
    fn output_file(&self, prepared: &PreparedSource) -> PathBuf {
        let of_pipeline = || prepared.markers.clone().filter(|path| is_yaml(path));
        self.output.clone().or_else(of_pipeline).unwrap_or_else(|| self.pipeline.with_extension("markers.yaml"))
    }

    /// Checks that the markers replace none of the pipeline's files but its markers.
    fn check_output(&self, prepared: &PreparedSource, output: &Path) -> Result<()> {
        let is_markers = |file: &&Path| prepared.markers.as_deref() == Some(*file);
        let inputs = prepared.inputs.iter().map(|input| &*input.path).filter(|file| !is_markers(file));
        let output = OutFile { option: "--output", file: output };
        output.check_is_none_of(inputs.chain([&*self.pipeline]), "the pipeline reads this file")
    }

    /// Checks that `--curve` names an SVG file that is neither read nor taken by the markers.
    fn check_curve(&self, prepared: &PreparedSource, output: &Path) -> Result<()> {
        let Some(file) = &self.curve else { return Ok(()) };
        let curve = OutFile { option: "--curve", file };
        curve.check(&["svg"])?;
        curve.check_is_none_of(prepared.inputs.iter().map(|input| &*input.path), "the pipeline reads this file")?;
        curve.check_is_none_of([output], "the markers are written into this file")
    }

    /// The markers to continue from; none without `--resume`.
    fn previous_markers(&self, output: &Path) -> Result<MarkerFile> {
        if !is_yaml(output) {
            let diagnostic = Diagnostic::new(
                Kind::Usage,
                "key points are written as .yaml, because other files of markers have no notes",
            );
            return Err(diagnostic.at(Location::File(output.into())).hint("give `--output FILE.yaml`").into());
        }
        if self.resume {
            return if output.is_file() { mimesh_markers::read_markers(output) } else { Ok(MarkerFile::default()) };
        }
        if output.exists() && !self.force {
            let diagnostic = Diagnostic::new(Kind::CannotWrite, "there are markers already");
            let hint = "`--resume` goes on from them, `--force` replaces them, `--output FILE` writes others";
            return Err(diagnostic.at(Location::File(output.into())).hint(hint).into());
        }
        Ok(MarkerFile::default())
    }
}

fn is_yaml(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension == "yaml" || extension == "yml")
}

fn point_json(point: MeshPoint) -> serde_json::Value {
    match point {
        MeshPoint::Vertex(vertex) => json!(vertex),
        MeshPoint::Triangle(triangle, barycentric) => {
            json!({ "triangle": triangle, "barycentric": barycentric })
        }
    }
}

/// Shows the steps of the choice: a bar on a terminal, lines elsewhere.
struct ChoiceProgress<'a> {
    bar: Option<ShareBar>,
    lines: bool,
    interrupted: &'a AtomicBool,
}

impl<'a> ChoiceProgress<'a> {
    fn new(quiet: bool, interrupted: &'a AtomicBool) -> Self {
        let is_interactive = terminal::is_interactive();
        let bar = (!quiet && is_interactive).then(ShareBar::new);
        if let Some(bar) = &bar {
            bar.begin("key points");
        }
        Self { bar, lines: !quiet && !is_interactive, interrupted }
    }

    fn finish(&self) {
        self.bar.iter().for_each(ShareBar::finish);
    }
}

impl ChoiceWatch for ChoiceProgress<'_> {
    fn step(&self, step: &ChoiceStep) {
        let action = if step.exchanged { "exchanged" } else { "added" };
        let text = format!("{} key points, error {:.4} ({action})", step.points.len(), step.error);
        if self.lines {
            let _ = writeln!(std::io::stderr(), "{text}");
        }
        self.bar.iter().for_each(|bar| bar.set_message(text.clone()));
    }

    fn done(&self, share: f64) {
        self.bar.iter().for_each(|bar| bar.done(share));
    }

    fn is_interrupted(&self) -> bool {
        self.interrupted.load(Ordering::Relaxed)
    }
}
