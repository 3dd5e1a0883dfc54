use std::path::{Path, PathBuf};

use mimesh_render::{Cell, Picture, sheet};
use nalgebra::Point3;
use rayon::prelude::*;

use super::{Ended, compare::check_out, terminal};
use crate::{
    core::{
        Error,
        mesh::{Mesh, Surface, SurfacePoint},
    },
    diagnostic::{Diagnostic, Kind, Location, Result},
    markers,
    pipeline::{
        Formats, PictureSettings, Up, ViewFrom,
        check::{in_file, nearby},
        judge::point_error,
        pictures::{self, Look},
        resolve, staging,
    },
    status::Status,
    text::{bytes, count},
};

/// Draws meshes into a PNG, without a display: one beside the other, with errors in colour or with numbered markers.
///
/// Every mesh is drawn, and every pose that a file holds. Triangles seen from behind are dark red.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  mimesh render camel.glb --out camel.png
  mimesh render 'out/camel-*.obj' --truth 'truth/camel-*.obj' --out errors.png
  mimesh render horse.obj --markers horse_camel.cons --out markers.png
  mimesh render camel.obj --markers horse_camel.cons --side target --view side --out markers.png")]
pub struct Render {
    /// Meshes: files, or globs in quotes
    #[arg(required = true)]
    meshes: Vec<String>,
    /// The picture to write
    #[arg(long, value_name = "FILE.png")]
    out: PathBuf,
    /// Known results, one a mesh, as files or globs: colours are distances to them after aligning centroids
    #[arg(long, value_name = "MESH")]
    truth: Vec<String>,
    /// A file of markers to draw and number; of pairs those of `--side`
    #[arg(long, value_name = "FILE", conflicts_with = "truth")]
    markers: Option<PathBuf>,
    /// Which side of the pairs the meshes are
    #[arg(long, value_enum, default_value = "source", requires = "markers")]
    side: Side,
    /// The side that is seen
    #[arg(long, value_enum, default_value = "three_quarter")]
    view: ViewFrom,
    /// The axis that points up
    #[arg(long, value_enum, default_value = "y")]
    up: Up,
    /// Pixels of one mesh
    #[arg(long, value_name = "PIXELS", default_value = "320", value_parser = clap::value_parser!(u32).range(64..=2048))]
    size: u32,
    /// Meshes in a row [default: as many as make the sheet about square]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=64))]
    columns: Option<u32>,
}

/// A side of pairs of markers.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum Side {
    Source,
    Target,
}

/// A mesh to draw.
struct Posed {
    name: String,
    mesh: Mesh,
    file: PathBuf,
}

/// More pixels than this make no sheet that a program opens.
const MOST_PIXELS: u64 = 1 << 28;

impl Render {
    /// Runs the command.
    pub fn run(&self) -> Ended {
        check_out(&self.out, &["png"])?;
        let formats = Formats::new(vec![]);
        let meshes = read_all(&formats, &self.meshes)?;
        let taken = meshes.iter().any(|one| resolve::identity(&one.file) == resolve::identity(&self.out));
        if taken {
            let place = Location::Option(format!("--out {}", self.out.display()));
            let diagnostic = Diagnostic::new(Kind::CannotWrite, "this file is read").at(place);
            return Err(diagnostic.hint("choose another name").into());
        }
        let truths = if self.truth.is_empty() { vec![] } else { read_all(&formats, &self.truth)? };
        if !truths.is_empty() && truths.len() != meshes.len() {
            let message = format!(
                "{}, but {}",
                count(meshes.len(), "mesh", "meshes"),
                count(truths.len(), "known result", "known results")
            );
            return Err(Diagnostic::new(Kind::Usage, message).hint("give one known result for each mesh").into());
        }
        let columns = self.columns.unwrap_or_else(|| (meshes.len() as f64).sqrt().ceil() as u32).max(1);
        let pixels = meshes.len() as u64 * u64::from(self.size).pow(2);
        if pixels > MOST_PIXELS {
            let message = format!(
                "{} of {} pixels are too much for one picture",
                count(meshes.len(), "mesh", "meshes"),
                self.size
            );
            return Err(Diagnostic::new(Kind::Usage, message).hint("draw fewer, or smaller with `--size`").into());
        }
        let look: Look = PictureSettings { view: self.view, up: self.up, target_up: None }.into();
        let draw = |(i, one): (usize, &Posed)| -> Result<Cell> {
            let surface = Surface::new(&one.mesh).map_err(|error| in_file(&one.file, error))?;
            let picture: Picture = match (&self.markers, truths.get(i)) {
                (Some(file), _) => pictures::marked(&surface, &self.points(file, one, &surface)?, look, self.size),
                (None, Some(truth)) => {
                    let errors = errors(&one.mesh, &surface, &truth.mesh.positions)
                        .map_err(|error| in_file(&one.file, error))?;
                    pictures::plain(&surface, Some(&errors), look, self.size)
                }
                (None, None) => pictures::plain(&surface, None, look, self.size),
            };
            Ok(Cell { picture, caption: one.name.clone() })
        };
        let cells: Vec<Cell> = meshes.par_iter().enumerate().map(draw).collect::<Result<_>>()?;
        let rows: Vec<Vec<Cell>> = cells.chunks(columns as usize).map(<[Cell]>::to_vec).collect();
        let png = sheet("", &rows).png();
        staging::write(&self.out, &png)?;
        let what = count(meshes.len(), "mesh", "meshes");
        terminal::print(&format!("{} of {what}, {}\n", self.out.display(), bytes(png.len() as u64)));
        Ok(Status::Done)
    }

    /// The points of the markers on `one`.
    fn points(&self, file: &Path, one: &Posed, surface: &Surface) -> Result<Vec<SurfacePoint>> {
        let name = if matches!(self.side, Side::Target) { "target" } else { "source" };
        markers::points_on(file, markers::Side { name, mesh: &one.mesh, surface })
    }
}

/// The meshes and poses in all files of `patterns`.
fn read_all(formats: &Formats, patterns: &[String]) -> Result<Vec<Posed>> {
    let mut all = Vec::new();
    for pattern in patterns {
        let found = resolve::expand(Path::new(""), pattern)
            .map_err(|problem| Diagnostic::new(Kind::Usage, format!("`{pattern}` is no glob: {problem}")))?;
        if found.is_empty() {
            let message = format!("no file matches `{pattern}`");
            return Err(Diagnostic::new(Kind::MissingInput, message).hint(nearby(Path::new(pattern))).into());
        }
        for file in found {
            let path = file.path;
            let sequence = formats.reader_of(&path)?.read(&path).map_err(|error| in_file(&path, error))?;
            let name = resolve::stem(&path);
            if sequence.poses.is_empty() {
                all.push(Posed { name, mesh: sequence.rest, file: path });
                continue;
            }
            let posed = |pose: crate::core::mesh::Pose| Posed {
                name: pose.name,
                mesh: Mesh { positions: pose.positions, ..sequence.rest.clone() },
                file: path.clone(),
            };
            all.extend(sequence.poses.into_iter().map(posed));
        }
    }
    Ok(all)
}

/// The error of each vertex against `truth`, relative to the truth's size, as `score` does without a rest mesh.
fn errors(mesh: &Mesh, surface: &Surface, truth: &[Point3<f64>]) -> crate::core::Result<Vec<f64>> {
    Error::check_shape("vertices of the known result", mesh.positions.len(), truth.len())?;
    let rest = Mesh { positions: truth.to_vec(), ..mesh.clone() };
    point_error(&rest, surface, &mesh.positions, truth).map(|measured| measured.field)
}
