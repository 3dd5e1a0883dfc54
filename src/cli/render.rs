//! `mimesh render`: meshes as a picture.

use crate::cli::roots::Roots;
use std::path::{Path, PathBuf};

use mimesh_core::{
    Error,
    mesh::{Mesh, Surface, SurfacePoint},
};
use mimesh_document::{
    diagnostic::{Diagnostic, Kind, Result},
    paths,
};
use mimesh_markers::{MarkerMesh, MeshRole, points_on};
use mimesh_pipeline::{
    Formats,
    check::in_file,
    metrics::point_error,
    pictures::{self, Camera},
    spec::{PictureSettings, Up, ViewFrom},
    text::{bytes, count},
};
use mimesh_render::{Cell, colour::STEEL, sheet};
use nalgebra::Point3;
use rayon::prelude::*;

use crate::cli::{
    CommandResult,
    choice::choice,
    out_file::{OutFile, write_all},
    posed_meshes::{PosedMesh, read_all},
    status::Status,
    terminal,
};

/// Draws meshes into a PNG, beside each other, with errors in colour or with numbered markers.
///
/// The picture shows every mesh, and every pose of a file with poses. Triangles seen from behind are dark red. The
/// command needs no display.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  mimesh render camel.glb --out camel.png
  mimesh render 'out/camel-*.obj' --truth 'truth/camel-*.obj' --out errors.png
  mimesh render horse.obj --markers horse_camel.cons --out markers.png
  mimesh render camel.obj --markers horse_camel.cons --side target --view side --out markers.png")]
pub struct Render {
    /// The meshes: files, or globs in quotes
    #[arg(required = true)]
    meshes: Vec<String>,
    /// Write the picture into this file
    #[arg(long, value_name = "FILE.png")]
    out: PathBuf,
    #[command(flatten)]
    roots: Roots,
    /// One known result for each mesh, as files or globs; colours show distances to it after aligning centroids
    #[arg(long, value_name = "MESH")]
    truth: Vec<String>,
    /// Draw the points of this file of markers with numbers; of pairs, those of `--side`
    #[arg(long, value_name = "FILE", conflicts_with = "truth")]
    markers: Option<PathBuf>,
    /// The side of the pairs that the meshes are
    #[arg(long, value_enum, default_value = "source", requires = "markers")]
    side: Side,
    /// The direction of view
    #[arg(long, value_parser = choice::<ViewFrom>(), default_value = "three_quarter")]
    view: ViewFrom,
    /// The axis that points up
    #[arg(long, value_parser = choice::<Up>(), default_value = "y")]
    up: Up,
    /// Width and height of one mesh in pixels
    #[arg(long, value_name = "PIXELS", default_value = "320", value_parser = clap::value_parser!(u32).range(64..=2048))]
    size: u32,
    /// Meshes in a row [default: as many as make the picture about square]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=64))]
    columns: Option<u32>,
}

/// A side of the pairs of markers.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum Side {
    Source,
    Target,
}

/// The largest number of pixels of a picture; programs do not open larger ones.
const MAX_PIXELS: u64 = 1 << 28;

impl Render {
    /// Runs the command.
    pub fn run(&self) -> CommandResult {
        let out = OutFile { option: "--out", file: &self.out };
        out.check(&["png"])?;
        let formats = self.roots.formats();
        let meshes = read_patterns(&formats, &self.meshes)?;
        let truths = if self.truth.is_empty() { vec![] } else { read_patterns(&formats, &self.truth)? };
        let read = meshes.iter().chain(&truths).map(|posed| &*posed.file).chain(self.markers.as_deref());
        out.check_is_none_of(read, "the command reads this file")?;
        if !truths.is_empty() && truths.len() != meshes.len() {
            let message = format!(
                "{}, but {}",
                count(meshes.len(), "mesh", "meshes"),
                count(truths.len(), "known result", "known results")
            );
            return Err(Diagnostic::new(Kind::Usage, message).hint("give one known result for each mesh").into());
        }
        self.check_size(meshes.len())?;
        let draw = |(i, posed): (usize, &PosedMesh)| self.cell(posed, truths.get(i), &formats);
        let cells: Vec<Cell> = meshes.par_iter().enumerate().map(draw).collect::<Result<_>>()?;
        let columns = self.columns.unwrap_or_else(|| (meshes.len() as f64).sqrt().ceil() as u32).max(1);
        let rows: Vec<Vec<Cell>> = cells.chunks(columns as usize).map(<[Cell]>::to_vec).collect();
        let png = sheet("", &rows).png();
        write_all(&[(&self.out, &png)])?;
        let meshes = count(meshes.len(), "mesh", "meshes");
        terminal::print(&format!("{} of {meshes}, {}\n", self.out.display(), bytes(png.len() as u64)));
        Ok(Status::Done)
    }

    /// Checks that the picture is not too large.
    fn check_size(&self, meshes: usize) -> Result<()> {
        if meshes as u64 * u64::from(self.size).pow(2) <= MAX_PIXELS {
            return Ok(());
        }
        let meshes = count(meshes, "mesh", "meshes");
        let message = format!("{meshes} of {} × {} pixels are too many for one picture", self.size, self.size);
        Err(Diagnostic::new(Kind::Usage, message).hint("draw fewer, or smaller ones with `--size`").into())
    }

    /// Draws one mesh: with markers if they are given, else with errors if `truth` is given.
    fn cell(&self, posed: &PosedMesh, truth: Option<&PosedMesh>, formats: &Formats) -> Result<Cell> {
        let camera: Camera =
            PictureSettings { view: self.view, up: Some(self.up), ..PictureSettings::default() }.into();
        let surface = Surface::new(&posed.mesh).map_err(|error| in_file(&posed.file, error))?;
        let picture = if let Some(file) = &self.markers {
            pictures::draw_markers(&surface, &self.points(file, posed, &surface, formats)?, camera, self.size, STEEL)
        } else if let Some(truth) = truth {
            let errors = errors(&posed.mesh, &surface, &truth.mesh.positions);
            let errors = errors.map_err(|error| in_file(&truth.file, error))?;
            pictures::draw_mesh(&surface, Some(&errors), camera, self.size)
        } else {
            pictures::draw_mesh(&surface, None, camera, self.size)
        };
        Ok(Cell { picture, caption: posed.name.clone() })
    }

    /// The points of the markers in `file` on a mesh.
    fn points(
        &self,
        file: &Path,
        posed: &PosedMesh,
        surface: &Surface,
        formats: &Formats,
    ) -> Result<Vec<SurfacePoint>> {
        let role = if matches!(self.side, Side::Target) { MeshRole::Target } else { MeshRole::Source };
        points_on(file, MarkerMesh { role, mesh: &posed.mesh, surface }, formats)
    }
}

/// Reads all files of `patterns`; a mesh without poses has the name of its file.
fn read_patterns(formats: &Formats, patterns: &[String]) -> Result<Vec<PosedMesh>> {
    let mut all = Vec::new();
    for pattern in patterns {
        all.extend(read_all(formats, pattern, |found| paths::stem(&found.path))?);
    }
    Ok(all)
}

/// The error of each vertex against `truth`, relative to the size of the truth, as in `mimesh score` without `--rest`.
fn errors(mesh: &Mesh, surface: &Surface, truth: &[Point3<f64>]) -> mimesh_core::Result<Vec<f64>> {
    Error::check_shape("vertices of the known result", mesh.positions.len(), truth.len())?;
    let rest = Mesh { positions: truth.to_vec(), ..mesh.clone() };
    point_error(&rest, surface, &mesh.positions, truth).map(|measured| measured.field)
}
