//! Markers as a pipeline names them: one file with both sides, or a file of points for each mesh.

use std::path::Path;

use nalgebra::Point3;

use mimesh_document::{Diagnostic, Diagnostics, Kind, Location, Result};

use crate::{
    anatomy_fit::{self, Fit},
    attach::attach,
    attacher::{Attached, Attacher},
    marker_files::MarkerFiles,
    mesh::{MarkerMesh, MeshRole},
    model::{MarkerFile, MarkerPair},
    notation::{Notation, ending},
    pairing::{self, Paired},
    points::PointFile,
    read::{read_markers, read_points, read_two_sets, unusable},
    scene::{self, ScenePoints},
    unit_axes::{self, UnitAxes},
};

/// Points given in space that lie farther off the surface than this, relative to the diagonal, are worth a warning.
const MAX_CERTAIN_DISTANCE: f64 = 0.01;

/// The contents of marker files, before they are brought to the meshes.
#[derive(Clone, Debug)]
pub enum PointSource {
    /// The pairs in one file.
    Pairs(MarkerFile),
    /// The points of the source and those of the target, from a file each.
    Sides([PointFile; 2]),
}

/// Markers on their meshes, and how they got there.
#[derive(Clone, Debug, Default)]
pub struct AttachedMarkers {
    /// The markers.
    pub markers: MarkerFile,
    /// For source and target the names of the points given in space, with their distances from the surface relative to the
    /// diagonal.
    pub distances: [Vec<(String, f64)>; 2],
    /// The changes of unit and axes that were applied to the positions of source and target.
    pub unit_axes: [Option<UnitAxes>; 2],
    /// Sentences about points that were left out or lie off the surface.
    pub warnings: Vec<String>,
    /// What was found out about the files.
    pub notes: Vec<Note>,
}

/// Something that was found out about the files, and is told.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Note {
    /// What it is about: `source`, `target` or `pairs`.
    pub about: &'static str,
    /// What was chosen, in a few words.
    pub chosen: String,
    /// The reason, as a clause.
    pub why: String,
}

impl PointSource {
    /// Reads the files; `scenes` reads those that are scenes.
    ///
    /// # Errors
    ///
    /// All that is wrong with them.
    pub fn read(files: &MarkerFiles, scenes: &dyn ScenePoints) -> Result<Self> {
        let side = |file: &Path| match Notation::of(file) {
            None => scene::read(file, scenes).unwrap_or_else(|| read_points(file)),
            Some(_) => read_points(file),
        };
        match files {
            MarkerFiles::One(file) => match Notation::of(file) {
                Some(Notation::Amira) => read_two_sets(file).map(Self::Sides),
                None if scenes.scene_points(file).is_some() => {
                    let message = format!("a .{} holds the points of one mesh only", ending(file));
                    Err(unusable(file, message, "give a file of points for each mesh").into())
                }
                _ => read_markers(file).map(Self::Pairs),
            },
            MarkerFiles::Pair { source, target } => match (side(source), side(target)) {
                (Ok(source), Ok(target)) => Ok(Self::Sides([source, target])),
                (source, target) => Err(all_errors([source.err(), target.err()])),
            },
        }
    }

    /// The markers on the meshes; with `fit`, positions in another unit or with other axes are brought to the mesh first.
    ///
    /// # Errors
    ///
    /// Points that are not on their mesh, and files that cannot be paired. Points in one file are not checked.
    pub fn attach(self, meshes: [MarkerMesh<'_>; 2], fit: bool) -> Result<AttachedMarkers> {
        let mut files = match self {
            Self::Pairs(markers) => return Ok(AttachedMarkers { markers, ..AttachedMarkers::default() }),
            Self::Sides(files) => files,
        };
        let attachers = [Attacher::new(meshes[0])?, Attacher::new(meshes[1])?];
        scene::keep_shared(&mut files)?;
        if !fit {
            scene::drop_groups(&mut files, &attachers);
        }
        let mut notes = Vec::new();
        let mut warnings: Vec<String> = files.iter().flat_map(|file| file.warnings.clone()).collect();
        let unit_axes = [0, 1].map(|k| match fit {
            true => {
                let (file, positions) = (&files[k], files[k].positions_in_space());
                unit_axes::detect(&attachers[k], &positions, file.anatomy.is_some()).unwrap_or(UnitAxes::IDENTITY)
            }
            false => of_anatomy(&files[k], &attachers[k], &mut notes, &mut warnings),
        });
        let [source, target] = [0, 1].map(|k| attach(&files[k], &attachers[k], unit_axes[k]));
        let points = match (source, target) {
            (Ok(source), Ok(target)) => [source, target],
            (source, target) => {
                let exchanged = exchanged(&files, &attachers).map(Diagnostics::from);
                return Err(exchanged.unwrap_or_else(|| all_errors([source.err(), target.err()])));
            }
        };
        let Paired { pairs, by_order } = pairing::pair(&files, &mut warnings)?;
        if by_order && files[0].file != files[1].file {
            let [source, target] = [0, 1].map(|k| files[k].file.display());
            let why = format!("{source} and {target} have no names of points on both sides");
            notes.push(Note { about: "pairs", chosen: "by order".into(), why });
        }
        let distances = [0, 1].map(|k| distances(&files[k], &points[k]));
        warnings.extend(MeshRole::BOTH.into_iter().zip(&distances).filter_map(|(role, d)| off_surface(role, d)));
        let pair = |[s, t]: [usize; 2]| {
            let points = [points[0][s].point, points[1][t].point];
            let at: [Option<Point3<f64>>; 2] = [0, 1].map(|k| meshes[k].position(points[k]));
            let name = files[0].points[s].name.clone().or_else(|| files[1].points[t].name.clone());
            let location = Some(files[0].points[s].location.clone());
            MarkerPair { name, at, location, ..MarkerPair::new(points[0], points[1]) }
        };
        let markers = MarkerFile { pairs: pairs.into_iter().map(pair).collect(), ..MarkerFile::default() };
        let unit_axes = unit_axes.map(|unit_axes| Some(unit_axes).filter(|u| *u != UnitAxes::IDENTITY));
        Ok(AttachedMarkers { markers, distances, unit_axes, warnings, notes })
    }
}

/// What brings positions of a file in one of the systems of medical images to that of the mesh, told in `notes`, or in `warnings`
/// where the points do not show it.
fn of_anatomy(
    file: &PointFile,
    attacher: &Attacher<'_>,
    notes: &mut Vec<Note>,
    warnings: &mut Vec<String>,
) -> UnitAxes {
    let Some(anatomy) = file.anatomy else { return UnitAxes::IDENTITY };
    let (role, name, other) = (attacher.mesh.role, file.file.display(), anatomy.other());
    let mut note = |chosen: String, why: String| notes.push(Note { about: role.name(), chosen, why });
    match anatomy_fit::fit(file, attacher) {
        Fit::AsWritten => {
            note(format!("{anatomy}"), format!("the points of {name} lie on the {role} as the file has them"));
            UnitAxes::IDENTITY
        }
        Fit::Turned => {
            let why = format!("the points of {name}, which are in {anatomy}, lie on the {role} so");
            note(format!("{anatomy} turned to {other}, (x, y, z) to (-x, -y, z)"), why);
            UnitAxes::HALF_TURN
        }
        Fit::Either => {
            warnings.push(format!(
                "{name}: its points lie on the {role} alike in {anatomy}, as the file has them, and turned to {other}; they are taken \
                 in {anatomy}; if the {role} is in {other}, save the points in {other}, as a .csv of name, x, y and z"
            ));
            UnitAxes::IDENTITY
        }
        // That they lie off it is an error with its causes.
        Fit::Neither => UnitAxes::IDENTITY,
    }
}

/// The names of the points given in space, with their distances from the surface.
fn distances(file: &PointFile, points: &[Attached]) -> Vec<(String, f64)> {
    let in_space = (0..file.points.len()).filter(|&i| file.points[i].in_space().is_some());
    in_space.map(|i| (file.name(i), points[i].distance)).collect()
}

/// A sentence about the points given in space that lie off the surface by more than 1 % of the diagonal.
fn off_surface(role: MeshRole, distances: &[(String, f64)]) -> Option<String> {
    let off = distances.iter().filter(|(_, distance)| *distance > MAX_CERTAIN_DISTANCE).count();
    let (name, farthest) = distances.iter().max_by(|a, b| a.1.total_cmp(&b.1)).filter(|_| off > 0)?;
    Some(format!(
        "{off} of {} points given by position lie more than 1 % of the diagonal off the {role}, {name} by {:.1} %",
        distances.len(),
        100.0 * farthest
    ))
}

/// The diagnostic of two files that fit with source and target exchanged; `None` if they do not.
fn exchanged(files: &[PointFile; 2], attachers: &[Attacher<'_>; 2]) -> Option<Diagnostic> {
    let fits = |file: usize, mesh: usize| attach(&files[file], &attachers[mesh], UnitAxes::IDENTITY).is_ok();
    if !(fits(0, 1) && fits(1, 0)) {
        return None;
    }
    let [source, target] = [0, 1].map(|k| files[k].file.display());
    let message = format!("the points of {source} lie on the target, and those of {target} on the source");
    let diagnostic = Diagnostic::new(Kind::BadData, message).at(Location::File(files[0].file.clone()));
    Some(diagnostic.hint("exchange the two files, or `source` and `target`"))
}

fn all_errors(errors: [Option<Diagnostics>; 2]) -> Diagnostics {
    Diagnostics { list: errors.into_iter().flatten().flatten().collect() }
}
