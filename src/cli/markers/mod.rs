//! `mimesh markers`: markers proposed, converted, mirrored and carried to edited meshes.

mod convert;
mod mirror;
mod propose;
mod reattach;
mod suggest;

use crate::cli::posed_meshes::read;
use crate::cli::roots::Roots;
use mimesh_core::stage::Selection;
use std::path::{Path, PathBuf};

use clap::Subcommand;
use mimesh_core::mesh::Welding;
use mimesh_document::diagnostic::{Diagnostic, Kind, Location, Result};
use mimesh_markers::{
    AttachedMarkers, Exported, MarkerFile, MarkerFiles, MarkerMesh, MeshRole, PointSource, export, is_point_file,
};
use mimesh_pipeline::{
    Formats, Options,
    check::in_file,
    input::{Meshes, RestMesh},
    prepare_meshes,
};

use crate::cli::{
    CommandResult,
    out_file::{OutFile, write_all},
    terminal,
};

/// Proposes markers by shape, converts them, completes them across a plane of symmetry, and carries them to edited meshes.
#[derive(Debug, clap::Args)]
pub struct Markers {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Convert(convert::Convert),
    Mirror(mirror::Mirror),
    Propose(propose::Propose),
    Reattach(reattach::Reattach),
    Suggest(suggest::Suggest),
}

impl Markers {
    /// Runs the command.
    pub fn run(&self) -> CommandResult {
        match &self.command {
            Command::Convert(command) => command.run(),
            Command::Mirror(command) => command.run(),
            Command::Propose(command) => command.run(),
            Command::Reattach(command) => command.run(),
            Command::Suggest(command) => command.run(),
        }
    }
}

/// The options that all commands on markers have.
#[derive(Debug, clap::Args)]
struct Common {
    /// The markers, then the file to write: IN OUT, or SOURCE-POINTS TARGET-POINTS OUT for a file for each side;
    /// OUT alone takes the markers of --pipeline
    #[arg(value_name = "FILE", num_args = 1..=3, required = true)]
    files: Vec<PathBuf>,
    /// The source mesh
    #[arg(long, value_name = "MESH", requires = "target", conflicts_with = "pipeline")]
    source: Option<PathBuf>,
    /// The target mesh
    #[arg(long, value_name = "MESH", requires = "source", conflicts_with = "pipeline")]
    target: Option<PathBuf>,
    /// Take the meshes from this pipeline
    #[arg(long, value_name = "PIPELINE")]
    pipeline: Option<PathBuf>,
    #[command(flatten)]
    roots: Roots,
    /// Replace existing files
    #[arg(long)]
    force: bool,
    /// Print the report as JSON
    #[arg(long)]
    json: bool,
}

/// The meshes, and the files of markers to read and write.
struct Loaded {
    source: RestMesh,
    target: RestMesh,
    files: MarkerFiles,
    out: PathBuf,
    formats: Formats,
}

impl Common {
    /// Reads the meshes, and finds out what each file is.
    fn load(&self) -> Result<Loaded> {
        let (source, target, pipeline_markers) = match (&self.pipeline, &self.source, &self.target) {
            (Some(pipeline), ..) => {
                let Meshes { source, target, markers, .. } =
                    prepare_meshes(pipeline, &Options { roots: self.roots.folders(), ..Options::default() })?;
                (source, target, markers)
            }
            (None, Some(source), Some(target)) => {
                let formats = self.roots.formats();
                (read_mesh(&formats, source)?, read_mesh(&formats, target)?, None)
            }
            _ => {
                let message = "the meshes of the markers are not given";
                let hint = "give `--source MESH --target MESH`, or `--pipeline PIPELINE.yaml`";
                return Err(Diagnostic::new(Kind::Usage, message).hint(hint).into());
            }
        };
        let (files, out) = match &self.files[..] {
            [file, out] => (MarkerFiles::One(file.clone()), out),
            [source, target, out] => (MarkerFiles::Pair { source: source.clone(), target: target.clone() }, out),
            [out] => {
                let message = if self.pipeline.is_some() {
                    "the pipeline has no markers, and no file of markers is given"
                } else {
                    "the file to write is not given"
                };
                let hint =
                    "give the markers, then the file to write, e.g. `mimesh markers convert pairs.cons pairs.yaml`";
                (pipeline_markers.ok_or_else(|| Diagnostic::new(Kind::Usage, message).hint(hint))?, out)
            }
            _ => return Err(Diagnostic::new(Kind::Usage, "expected one to three files").into()),
        };
        Ok(Loaded { source, target, files, out: out.clone(), formats: self.roots.formats() })
    }

    /// Writes `markers`, shows the warnings, and gives the paths of the written files.
    fn write(&self, loaded: &Loaded, markers: &MarkerFile) -> Result<Vec<PathBuf>> {
        let Exported { files, warnings } = export(markers, &loaded.out, loaded.meshes())?;
        let meshes = loaded.mesh_files().into_iter().flatten();
        let read: Vec<&Path> = meshes.chain(self.pipeline.as_deref()).collect();
        for (path, _) in &files {
            // Only markers are replaced by markers, whatever the flags.
            let out = OutFile { option: "OUT", file: path };
            out.check_is_none_of(read.iter().copied(), "the command reads meshes or a pipeline from this file")?;
            if path.exists() && !self.force {
                let diagnostic = Diagnostic::new(Kind::CannotWrite, "the file is there already");
                return Err(diagnostic.at(Location::File(path.clone())).hint("`--force` replaces it").into());
            }
        }
        warnings.iter().for_each(|warning| terminal::warn(warning));
        let contents: Vec<_> = files.iter().map(|(path, text)| (&**path, text.as_bytes())).collect();
        write_all(&contents)
    }
}

impl Loaded {
    fn meshes(&self) -> [MarkerMesh<'_>; 2] {
        [self.source.for_markers(MeshRole::Source), self.target.for_markers(MeshRole::Target)]
    }

    /// The files of source and target, unless a generator makes them.
    fn mesh_files(&self) -> [Option<&Path>; 2] {
        [self.source.path.as_deref(), self.target.path.as_deref()]
    }

    /// Reads the markers and attaches them to the meshes, with their unit and axes fitted to these if `fit` is set.
    fn markers(&self, fit: bool) -> Result<AttachedMarkers> {
        let attached = PointSource::read(&self.files, &self.formats)?.attach(self.meshes(), fit)?;
        attached.warnings.iter().for_each(|warning| terminal::warn(warning));
        Ok(attached)
    }
}

fn read_mesh(formats: &Formats, file: &Path) -> Result<RestMesh> {
    if is_point_file(file) {
        let diagnostic =
            Diagnostic::new(Kind::Usage, "expected a mesh, found a file of points").at(Location::File(file.into()));
        return Err(diagnostic.hint("give files of points without an option, before the file to write").into());
    }
    let sequence = read(formats, file)?;
    Ok(RestMesh::new(Some(file.into()), Selection::default(), sequence, Welding::default())
        .map_err(|error| in_file(file, error))?)
}

/// Formats the fraction `value` in percent.
fn percent(value: f64) -> String {
    format!("{:.3} %", 100.0 * value)
}

/// Formats the paths of written files, a line each.
fn written_lines(written: &[PathBuf]) -> String {
    written.iter().map(|path| format!("written: {}\n", path.display())).collect()
}
