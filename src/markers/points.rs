//! Files with the points of one mesh, of which two make markers.

use std::path::{Path, PathBuf};

use nalgebra::Point3;

use super::{json, pp, table, text};
use crate::{
    diagnostic::Kind,
    diagnostic::{Diagnostic, Location, Result},
};

/// The points of one mesh, as a file has them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PointFile {
    /// The file.
    pub file: PathBuf,
    /// The points, in order.
    pub points: Vec<NamedPoint>,
    /// Sentences about what was left out.
    pub warnings: Vec<String>,
}

/// A point of one mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedPoint {
    /// Its name, if it has one.
    pub name: Option<String>,
    /// Where it is.
    pub spot: Spot,
    /// Where it stands in its file.
    pub location: Location,
}

/// How a file says where a point is. Numbers count the vertices and triangles of the mesh from 0; polygons are cut into
/// triangles as a fan from their first corner.
#[derive(Clone, Debug, PartialEq)]
pub enum Spot {
    /// A vertex.
    Vertex(u32),
    /// Several vertices: the vertex nearest to their mean is meant.
    Vertices(Vec<u32>),
    /// A place on a triangle, with the barycentric coordinates of its corners.
    Triangle(u32, [f64; 3]),
    /// A place in space, in the unit of the mesh: the nearest place on its surface is meant.
    Position(Point3<f64>),
}

/// The endings of files that hold the points of one mesh.
pub const EXTENSIONS: [&str; 6] = ["pp", "json", "txt", "csv", "tsv", "dat"];

/// Whether `file` has the ending of a file with the points of one mesh.
pub fn is_one_sided(file: &Path) -> bool {
    extension(file).is_some_and(|extension| EXTENSIONS.contains(&extension.as_str()))
}

/// Reads a file with the points of one mesh, in the notation that its ending and beginning tell.
///
/// # Errors
///
/// All that is wrong with it, each with its line.
pub fn read(file: &Path) -> Result<PointFile> {
    match extension(file).as_deref() {
        Some(extension) if EXTENSIONS.contains(&extension) => parse(file, &text::read(file)?),
        Some("cons" | "yaml" | "yml") => {
            let name = file.file_name().unwrap_or_default().to_string_lossy();
            Err(Diagnostic::new(Kind::BadPipeline, "this file holds both sides of the markers")
                .at(Location::File(file.into()))
                .hint(format!("name it alone: `markers: {name}`"))
                .into())
        }
        _ => Err(Diagnostic::new(Kind::BadPipeline, "not a file of points: expected .pp, .json, .txt or .csv")
            .at(Location::File(file.into()))
            .hint("MeshLab writes .pp, Wrap .json or .txt; see docs/markers.md for tables and JSON")
            .into()),
    }
}

/// Parses the text of `file`.
///
/// # Errors
///
/// As [`read`].
pub fn parse(file: &Path, text: &str) -> Result<PointFile> {
    let text = text::without_mark(text);
    let points = match (extension(file).as_deref(), text.trim_start().chars().next()) {
        (Some("pp"), _) | (_, Some('<')) => pp::parse(file, text)?,
        (Some("json"), _) | (_, Some('[' | '{')) => json::parse(file, text)?,
        _ => table::parse(file, text)?,
    };
    if points.points.is_empty() {
        let more = points.warnings.first().map_or(String::new(), |warning| format!(" ({warning})"));
        let diagnostic = Diagnostic::new(Kind::BadData, format!("no points{more}")).at(Location::File(file.into()));
        return Err(diagnostic.hint("pick some, and save the file again").into());
    }
    Ok(points)
}

/// Three numbers that may be a triangle with the coordinates of two of its corners, as Wrap writes them, or a place.
#[derive(Clone, Debug)]
pub(super) struct Triple {
    /// The numbers.
    pub numbers: [f64; 3],
    /// Whether the first was written as a whole number.
    pub whole: bool,
}

impl Triple {
    /// Whether it is a triangle with coordinates inside it.
    fn on_triangle(&self) -> bool {
        let [_, u, v] = self.numbers;
        // Written coordinates are rounded.
        let inside = u >= -1e-6 && v >= -1e-6 && u + v <= 1.0 + 1e-6;
        self.whole && (0.0..=f64::from(u32::MAX)).contains(&self.numbers[0]) && inside
    }

    /// The place on a triangle: corners A, B and C have the coordinates u, v and 1 − u − v.
    pub fn triangle(&self) -> std::result::Result<Spot, String> {
        let [triangle, u, v] = self.numbers;
        if !self.on_triangle() {
            return Err(format!(
                "expected `[triangle, u, v]` with u and v from 0 to 1 and a sum of 1 at most, found `[{triangle}, {u}, {v}]`"
            ));
        }
        Ok(Spot::Triangle(triangle as u32, [u, v, 1.0 - u - v]))
    }

    /// The place in space.
    pub fn position(&self) -> Spot {
        Spot::Position(Point3::from(self.numbers))
    }

    /// Whether most of `triples` are triangles: then all are meant so, and the others are wrong.
    pub fn are_triangles<'a>(triples: impl Iterator<Item = &'a Self>) -> bool {
        let (mut triangles, mut others, mut not_whole) = (0, 0, 0);
        for triple in triples {
            not_whole += usize::from(!triple.whole);
            if triple.on_triangle() { triangles += 1 } else { others += 1 }
        }
        not_whole == 0 && triangles > others
    }
}

/// The ending of `file` in lower case.
pub(super) fn extension(file: &Path) -> Option<String> {
    file.extension().map(|extension| extension.to_string_lossy().to_lowercase())
}
