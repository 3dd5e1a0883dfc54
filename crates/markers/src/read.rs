//! Reading marker files in any notation.

use std::path::Path;

use mimesh_document::{Diagnostic, Kind, Location, Result};

use crate::{
    formats::{amira, cons, fcsv, json, pp, pts, table, yaml},
    model::MarkerFile,
    notation::{Notation, ending},
    points::PointFile,
    text,
};

/// Reads a file that holds both sides of markers, in the notation of its ending.
///
/// # Errors
///
/// All that is wrong with the file, each with its line.
pub fn read_markers(file: &Path) -> Result<MarkerFile> {
    match Notation::of(file) {
        Some(Notation::Cons) => cons::parse(file, &text::read(file)?),
        Some(Notation::Yaml) => yaml::parse(file, &text::read(file)?),
        Some(_) => {
            let hint = "give a file of points for each mesh";
            Err(unusable(file, format!("a .{} holds the points of one mesh only", ending(file)), hint).into())
        }
        None => {
            let hint = "a .cons has the count in its first line, then `source, target` a line";
            Err(unusable(file, "not a file of markers: expected .cons or .yaml", hint).into())
        }
    }
}

/// Reads a file with the points of one mesh, in the notation of its ending and its beginning.
///
/// # Errors
///
/// All that is wrong with the file, each with its line.
pub fn read_points(file: &Path) -> Result<PointFile> {
    match Notation::of(file) {
        Some(notation) if !notation.holds_both_sides() => parse_points(file, &text::read(file)?),
        Some(_) => {
            let hint = "give it alone, or files of points";
            Err(unusable(file, "this file holds both sides of the markers", hint).into())
        }
        None => {
            let hint =
                "MeshLab writes .pp, Wrap .json or .txt, 3D Slicer .mrk.json or .fcsv; see docs/markers.md for all";
            Err(unusable(file, "not a file of points: expected .pp, .json, .txt, .csv, .fcsv, .pts or .glb", hint)
                .into())
        }
    }
}

/// Parses the text of `file`, which holds the points of one mesh.
///
/// # Errors
///
/// As [`read_points`].
pub fn parse_points(file: &Path, text: &str) -> Result<PointFile> {
    let text = text::strip_bom(text);
    let points = match (Notation::of(file), text.trim_start().chars().next()) {
        (Some(Notation::Fiducials), _) => fcsv::parse(file, text)?,
        (Some(Notation::Amira), _) => one_set(file, text)?,
        _ if amira::is_amira(text) => one_set(file, text)?,
        (Some(Notation::Points), _) => pts::parse(file, text)?,
        (Some(Notation::PickedPoints), _) | (_, Some('<')) => pp::parse(file, text)?,
        (Some(Notation::Json), _) | (_, Some('[' | '{')) => json::parse(file, text)?,
        _ => table::parse(file, text)?,
    };
    check_not_empty(&points, text.len())?;
    Ok(points)
}

/// The only set of landmarks in a file of Avizo or Amira.
fn one_set(file: &Path, text: &str) -> Result<PointFile> {
    let mut sets = amira::parse(file, text)?;
    match (sets.pop(), sets.is_empty()) {
        (Some(set), true) => Ok(set),
        _ => {
            let hint = "give it alone: the first of its sets is the source's, the second the target's";
            Err(unusable(file, "this file holds both sides of the markers", hint).into())
        }
    }
}

/// The points of both meshes in one file of Avizo or Amira.
///
/// # Errors
///
/// All that is wrong with the file, and if it holds the points of one mesh.
pub fn read_two_sets(file: &Path) -> Result<[PointFile; 2]> {
    let text = text::read(file)?;
    let sets: [PointFile; 2] = amira::parse(file, &text)?.try_into().map_err(|_| {
        let hint = "give a file of points for each mesh, or save a landmark set with two sets";
        unusable(file, "this file has one set of landmarks: it holds the points of one mesh only", hint)
    })?;
    sets.iter().try_for_each(|set| check_not_empty(set, text.len()))?;
    Ok(sets)
}

/// Checks that a file of `bytes` bytes has points.
fn check_not_empty(points: &PointFile, bytes: usize) -> Result<()> {
    if points.points.is_empty() {
        let more = points.warnings.first().map_or(String::new(), |warning| format!(" ({warning})"));
        let found = if bytes == 0 { "an empty file".into() } else { format!("none in {bytes} bytes") };
        let message = format!("no points: expected at least one, found {found}{more}");
        let diagnostic = Diagnostic::new(Kind::BadData, message).at(Location::File(points.file.clone()));
        return Err(diagnostic.hint("pick some, and save the file again").into());
    }
    Ok(())
}

/// The diagnostic of a file in a notation that does not fit its use.
pub(crate) fn unusable(file: &Path, message: impl Into<String>, hint: &str) -> Diagnostic {
    Diagnostic::new(Kind::Usage, message).at(Location::File(file.into())).hint(hint)
}
