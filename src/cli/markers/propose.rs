//! `mimesh markers propose`: markers found by shape, to be looked at and corrected.

use std::path::{Path, PathBuf};

use mimesh_core::{
    mesh::Surface,
    plugin::instance,
    stage::{Landmarks, Marker, Proposal, Work},
};
use mimesh_document::diagnostic::{Diagnostic, Kind, Location, Result};
use mimesh_markers::{MarkerFile, MarkerFiles, MarkerStatus, MeshRole, PointSource, export};
use mimesh_pipeline::{
    Formats, Options,
    input::Meshes,
    pictures, prepare_meshes,
    propose::{as_file, propose},
    spec::{PictureSettings, Up, ViewFrom},
    text::{count, table},
};
use mimesh_render::{
    Cell,
    colour::{SAND, STEEL},
    sheet,
};
use serde_json::json;

use crate::cli::{
    CommandResult,
    choice::choice,
    markers::{read_mesh, written_lines},
    out_file::{OutFile, write_all},
    roots::Roots,
    status::Status,
    terminal,
};

/// Finds corresponding points of two meshes by shape, and writes them with how sure they are.
///
/// Pairs in the file have `status: proposed`: look at them in the picture, correct the points or remove pairs, and set `status:
/// confirmed` for those that you stand for. Confirmed pairs of --clicks come first and stay.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  mimesh markers propose horse.obj camel.obj -o pairs.yaml
  mimesh markers propose horse.obj camel.obj --clicks pairs.yaml -o pairs.yaml --force
  mimesh markers propose --pipeline horse-to-camel.yaml -o pairs.yaml --picture pairs.png")]
pub struct Propose {
    #[command(flatten)]
    meshes: MeshArguments,
    /// Write the pairs into this file [default: they are printed]
    #[arg(long, short, value_name = "FILE.yaml")]
    output: Option<PathBuf>,
    /// Draw both meshes with the points and their numbers [default: beside --output]
    #[arg(long, value_name = "FILE.png")]
    picture: Option<PathBuf>,
    /// The axis that points up in the picture
    #[arg(long, value_parser = choice::<Up>(), default_value = "y")]
    up: Up,
    /// Replace existing files
    #[arg(long)]
    force: bool,
    /// Print pairs and figures as JSON
    #[arg(long)]
    json: bool,
}

/// Two meshes, and the markers that are known.
#[derive(Debug, clap::Args)]
pub struct MeshArguments {
    /// The source mesh, then the target mesh
    #[arg(value_name = "MESH", num_args = 2, required_unless_present = "pipeline", conflicts_with = "pipeline")]
    meshes: Vec<PathBuf>,
    /// Take meshes, clicks and the stage that finds points from this pipeline
    #[arg(long, value_name = "PIPELINE")]
    pipeline: Option<PathBuf>,
    /// A file of markers whose confirmed pairs are kept [default: those of --pipeline]
    #[arg(long, value_name = "FILE")]
    clicks: Option<PathBuf>,
    /// The type of the stage that finds points; `mimesh list landmarks` names them [default: that of --pipeline, or extremities]
    #[arg(long = "type", value_name = "TYPE")]
    kind: Option<String>,
    /// Let the stage run a program that the pipeline names
    #[arg(long)]
    allow_commands: bool,
    #[command(flatten)]
    roots: Roots,
}

/// The stage that finds points where none is named.
const DEFAULT: &str = "extremities";

/// Pixels of a mesh in the picture.
const PIXELS: u32 = 480;

impl MeshArguments {
    /// Reads the meshes, and finds the files of clicks and the stage.
    pub fn read(&self) -> Result<(Meshes, Box<dyn Landmarks>)> {
        let mut meshes = match (&self.pipeline, &self.meshes[..]) {
            (Some(pipeline), _) => {
                prepare_meshes(pipeline, &Options { roots: self.roots.folders(), ..Options::default() })?
            }
            (None, [source, target]) => {
                let formats = self.roots.formats();
                let (source, target) = (read_mesh(&formats, source)?, read_mesh(&formats, target)?);
                Meshes { source, target, markers: None, landmarks: None, correspondence: None }
            }
            _ => return Err(Diagnostic::new(Kind::Usage, "expected a source mesh and a target mesh").into()),
        };
        if let Some(clicks) = &self.clicks {
            meshes.markers = Some(MarkerFiles::One(clicks.clone()));
        }
        let stage = match (&self.kind, meshes.landmarks.take()) {
            (None, Some(stage)) => stage,
            (kind, _) => {
                let name = kind.as_deref().unwrap_or(DEFAULT);
                instance::<dyn Landmarks>(name).ok_or_else(|| {
                    let message = format!("there is no stage `{name}` that finds landmarks");
                    let at = Location::Argument(format!("--type {name}"));
                    Diagnostic::new(Kind::Usage, message).at(at).hint("`mimesh list landmarks` names them")
                })?
            }
        };
        Ok((meshes, stage))
    }

    /// The formats in which files are read.
    pub fn formats(&self) -> Formats {
        self.roots.formats()
    }

    /// Whether the stage may run a program.
    pub fn allow_commands(&self) -> bool {
        self.allow_commands
    }
}

/// The pairs of the files of `meshes` that a person stands for.
pub fn confirmed(meshes: &Meshes, formats: &Formats) -> Result<Vec<Marker>> {
    let Some(files) = &meshes.markers else { return Ok(vec![]) };
    let on = [meshes.source.for_markers(MeshRole::Source), meshes.target.for_markers(MeshRole::Target)];
    let attached = PointSource::read(files, formats)?.attach(on, false)?;
    attached.warnings.iter().for_each(|warning| terminal::warn(warning));
    let mut markers = attached.markers;
    markers.pairs.retain(|pair| pair.status == MarkerStatus::Confirmed);
    markers.resolve(on)
}

impl Propose {
    /// Runs the command.
    pub fn run(&self) -> CommandResult {
        let picture = self.picture.clone().or_else(|| Some(self.output.as_ref()?.with_extension("png")));
        for (option, file, endings) in
            [("--output", self.output.as_deref(), &["yaml", "yml"][..]), ("--picture", picture.as_deref(), &["png"])]
        {
            file.map_or(Ok(()), |file| self.check(OutFile { option, file }, endings))?;
        }
        let (meshes, stage) = self.meshes.read()?;
        let read: Vec<&Path> = [&meshes.source.path, &meshes.target.path, &self.meshes.pipeline]
            .into_iter()
            .filter_map(|file| file.as_deref())
            .collect();
        for (option, file) in [("--output", self.output.as_deref()), ("--picture", picture.as_deref())] {
            // Only markers are replaced by markers, whatever the flags.
            let message = "the command reads meshes or a pipeline from this file";
            file.map_or(Ok(()), |file| OutFile { option, file }.check_is_none_of(read.iter().copied(), message))?;
        }
        let clicks = confirmed(&meshes, &self.meshes.formats())?;
        let sides = [&meshes.source, &meshes.target];
        let proposal = propose(stage.as_ref(), sides, &clicks, self.meshes.allow_commands(), Work::UNWATCHED)?;
        proposal.figures.warnings.iter().for_each(|warning| terminal::warn(warning));
        let file = as_file(&proposal, &meshes, clicks.len());
        let mut contents: Vec<(&Path, Vec<u8>)> = Vec::new();
        if let Some(output) = &self.output {
            contents.push((output, yaml(&file, output, &meshes)?.into_bytes()));
        }
        if let Some(picture) = &picture {
            contents.push((picture, drawn(&proposal, &meshes, self.up)));
        }
        let contents: Vec<_> = contents.iter().map(|(path, bytes)| (*path, &**bytes)).collect();
        let written = write_all(&contents)?;
        if self.json {
            terminal::print_json(&json!({
                "pairs": proposal.pairs, "figures": proposal.figures, "clicks": clicks.len(), "written": terminal::all_shown(&written),
            }));
        } else if self.output.is_none() {
            terminal::print(&yaml(&file, Path::new("pairs.yaml"), &meshes)?);
        } else {
            terminal::print(&(listed(&file, clicks.len()) + &written_lines(&written)));
        }
        Ok(Status::Done)
    }

    /// Checks that a file can be written; one that is there already is overwritten only on demand.
    fn check(&self, out: OutFile<'_>, endings: &[&str]) -> Result<()> {
        out.check(endings)?;
        if out.file.exists() && !self.force {
            let diagnostic = out.diagnostic(Kind::CannotWrite, "the file is there already");
            return Err(diagnostic.hint("`--force` replaces it").into());
        }
        Ok(())
    }
}

fn yaml(file: &MarkerFile, out: &Path, meshes: &Meshes) -> Result<String> {
    let on = [meshes.source.for_markers(MeshRole::Source), meshes.target.for_markers(MeshRole::Target)];
    Ok(export(file, out, on)?.files.into_iter().map(|(_, text)| text).collect())
}

/// The pairs with their numbers in the picture, and how sure they are.
fn listed(file: &MarkerFile, clicks: usize) -> String {
    let row = |i: usize| {
        let sure = file.pairs[i].confidence.map_or_else(|| "confirmed".into(), |sure| format!("{sure:.2}"));
        vec![format!("{:>3} {}", i + 1, file.name(i)), sure]
    };
    let rows: Vec<_> = (0..file.pairs.len()).map(row).collect();
    let found = count(file.pairs.len() - clicks, "pair is proposed", "pairs are proposed");
    format!("{found}; confidence, 1 at best\n{}", table(&rows))
}

/// Both meshes with the numbered points, from two sides.
fn drawn(proposal: &Proposal, meshes: &Meshes, up: Up) -> Vec<u8> {
    let markers = proposal.markers();
    let row = |view: ViewFrom| {
        let cell = |name: &str, surface: &Surface, colour, point: fn(&Marker) -> mimesh_core::mesh::SurfacePoint| {
            let points: Vec<_> = markers.iter().map(point).collect();
            let camera = PictureSettings { view, up: Some(up), ..PictureSettings::default() }.into();
            Cell { picture: pictures::draw_markers(surface, &points, camera, PIXELS, colour), caption: name.into() }
        };
        vec![
            cell("source", &meshes.source.surface, STEEL, |marker| marker.source),
            cell("target", &meshes.target.surface, SAND, |marker| marker.target),
        ]
    };
    sheet("", &[row(ViewFrom::ThreeQuarter), row(ViewFrom::Side)]).png()
}
