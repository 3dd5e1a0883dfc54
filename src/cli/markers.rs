//! Markers between programs, meshes and sides: `mimesh markers convert`, `mirror` and `reattach`.

mod convert;
mod mirror;
mod reattach;

use std::path::{Path, PathBuf};

use clap::Subcommand;

use super::{Ended, terminal};
use crate::{
    core,
    diagnostic::{Diagnostic, Kind, Location, Result},
    markers::{self, MarkerFile, MarkerFiles, given, points},
    pipeline::{
        Formats, Options,
        check::{self, in_file},
        staging,
    },
};

/// Brings markers from and to other programs, completes them across a plane, and carries them to edited meshes.
#[derive(Debug, clap::Args)]
pub struct Markers {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Convert(convert::Convert),
    Mirror(mirror::Mirror),
    Reattach(reattach::Reattach),
}

impl Markers {
    /// Runs the command.
    pub fn run(&self) -> Ended {
        match &self.command {
            Command::Convert(command) => command.run(),
            Command::Mirror(command) => command.run(),
            Command::Reattach(command) => command.run(),
        }
    }
}

/// Which files, on which meshes, and what is told: what the commands have in common.
#[derive(Debug, clap::Args)]
struct Common {
    /// The markers, then the file to write: IN OUT, or with a file a side SOURCE-POINTS TARGET-POINTS OUT;
    /// with --pipeline OUT alone takes its markers
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
    /// Replace files that are there already
    #[arg(long)]
    force: bool,
    /// Print the report as JSON
    #[arg(long)]
    json: bool,
}

/// Meshes and files, read.
struct Loaded {
    source: check::Side,
    target: check::Side,
    files: MarkerFiles,
    out: PathBuf,
}

impl Common {
    /// Reads the meshes, and sorts the files.
    fn load(&self) -> Result<Loaded> {
        let (source, target, of_pipeline) = match (&self.pipeline, &self.source, &self.target) {
            (Some(pipeline), ..) => {
                let check::Meshes { source, target, markers } = check::meshes(pipeline, &Options::default())?;
                (source, target, markers)
            }
            (None, Some(source), Some(target)) => (read_mesh(source)?, read_mesh(target)?, None),
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
                let hint = "give first the markers, then the file to write, e.g. `mimesh markers convert pairs.cons pairs.yaml`";
                (of_pipeline.ok_or_else(|| Diagnostic::new(Kind::Usage, message).hint(hint))?, out)
            }
            _ => return Err(Diagnostic::new(Kind::Usage, "expected one to three files").into()),
        };
        Ok(Loaded { source, target, files, out: out.clone() })
    }

    /// Writes `markers` and tells where to, unless JSON is printed; gives what was written.
    fn write(&self, loaded: &Loaded, markers: &MarkerFile) -> Result<Vec<PathBuf>> {
        let [source, target] = loaded.sides();
        let (texts, warnings) = markers::write::write(markers, &loaded.out, source, target)?;
        for (path, _) in &texts {
            if path.exists() && !self.force {
                let diagnostic = Diagnostic::new(Kind::CannotWrite, "the file is there already");
                return Err(diagnostic.at(Location::File(path.clone())).hint("`--force` replaces it").into());
            }
        }
        warnings.iter().for_each(|warning| terminal::warn(warning));
        let staged: core::Result<Vec<_>> =
            texts.iter().map(|(path, text)| staging::stage_bytes(path, text.as_bytes())).collect();
        let written = staging::commit(staged?)?;
        Ok(written.into_iter().map(|file| file.path).collect())
    }
}

impl Loaded {
    fn sides(&self) -> [markers::Side<'_>; 2] {
        [self.source.for_markers("source"), self.target.for_markers("target")]
    }

    /// The files of source and target, where they are not samples.
    fn mesh_files(&self) -> [Option<&PathBuf>; 2] {
        [self.source.path.as_ref(), self.target.path.as_ref()]
    }

    /// The markers on the meshes.
    fn markers(&self, fit: bool) -> Result<given::OnMeshes> {
        let [source, target] = self.sides();
        let found = given::read(&self.files)?.on(source, target, fit)?;
        found.warnings.iter().chain(&found.doubts()).for_each(|warning| terminal::warn(warning));
        Ok(found)
    }
}

fn read_mesh(file: &Path) -> Result<check::Side> {
    if points::is_one_sided(file) {
        let diagnostic =
            Diagnostic::new(Kind::Usage, "a file of points, expected a mesh").at(Location::File(file.into()));
        return Err(diagnostic.hint("files of points come without an option, before the file to write").into());
    }
    let sequence = Formats::new(vec![]).reader_of(file)?.read(file).map_err(|error| in_file(file, error))?;
    Ok(check::Side::new(Some(file.into()), sequence).map_err(|error| in_file(file, error))?)
}

/// `value` in percent.
fn percent(value: f64) -> String {
    format!("{:.3} %", 100.0 * value)
}

/// The paths, a line each.
fn told(written: &[PathBuf]) -> String {
    written.iter().map(|path| format!("written: {}\n", path.display())).collect()
}
