//! The points of one mesh, as files of points have them; two such files make markers.

use std::{
    collections::{BTreeSet, HashMap},
    path::{Path, PathBuf},
};

use nalgebra::Point3;

use mimesh_core::mesh::MeshPoint;
use mimesh_document::{Diagnostic, Kind, Location};

use crate::{anatomy::Anatomy, text::in_line};

/// The contents of a file with the points of one mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PointFile {
    /// The file.
    pub file: PathBuf,
    /// The points, in the order of the file.
    pub points: Vec<NamedPoint>,
    /// Sentences about points that were left out.
    pub warnings: Vec<String>,
    /// The system of the positions, if the file says that it is one of medical images.
    pub anatomy: Option<Anatomy>,
    /// What is known of the points if they are the nodes of a scene.
    pub scene: Option<Scene>,
}

/// What is known of points that are the nodes of a scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scene {
    /// The names of nodes that may be there for others, such as groups and ends of chains of joints.
    pub doubtful: BTreeSet<String>,
}

/// A point of one mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedPoint {
    /// The name, if the point has one.
    pub name: Option<String>,
    /// The position, as the file gives it.
    pub position: PointPosition,
    /// The place of the point in its file.
    pub location: Location,
}

/// The ways in which a file gives the position of a point.
#[derive(Clone, Debug, PartialEq)]
pub enum PointPosition {
    /// A vertex, or a place on a triangle.
    OnMesh(MeshPoint),
    /// The vertex nearest to the mean of several vertices.
    MeanOfVertices(Vec<u32>),
    /// A position in space, in the unit of the mesh: the nearest place on the surface is meant.
    InSpace(Point3<f64>),
}

/// A point of one mesh, as it is written to a file.
#[derive(Clone, Debug, PartialEq)]
pub struct ExportPoint {
    /// The name, or the number from 1.
    pub name: String,
    /// The position, in the unit of the mesh.
    pub position: Point3<f64>,
    /// The vertex, or the place on a triangle.
    pub point: MeshPoint,
}

impl PointFile {
    /// A file without points so far.
    pub(crate) fn new(file: &Path) -> Self {
        Self { file: file.into(), ..Self::default() }
    }

    /// The name of point `i` in messages: the user's, or its number from 1.
    pub fn name(&self, i: usize) -> String {
        self.points[i].name.clone().unwrap_or_else(|| (i + 1).to_string())
    }

    /// Adds a point at `line`.
    pub(crate) fn push_in_space(&mut self, name: Option<String>, position: Point3<f64>, line: usize) {
        let location = Location::Line { file: self.file.clone(), line };
        self.points.push(NamedPoint { name, position: PointPosition::InSpace(position), location });
    }

    /// Tells that points are left out, by name or number, because of `reason`; nothing if there are none.
    pub(crate) fn warn_of_left_out(&mut self, reason: &str, names: &[String]) {
        if !names.is_empty() {
            let (count, names) = (names.len(), names.join(", "));
            self.warnings.push(format!("{}: {count} {reason} and left out: {names}", self.file.display()));
        }
    }

    /// The positions of the points that are given in space.
    pub fn positions_in_space(&self) -> Vec<Point3<f64>> {
        self.points.iter().filter_map(NamedPoint::in_space).collect()
    }

    /// A diagnostic at each point whose name an earlier point has.
    pub(crate) fn duplicate_names(&self) -> Vec<Diagnostic> {
        let mut seen = HashMap::new();
        let mut diagnostics = Vec::new();
        for point in &self.points {
            let Some(name) = point.name.as_deref() else { continue };
            let Some(first) = seen.insert(name, &point.location) else { continue };
            let message = format!("another point is called {name}{}", in_line(Some(first)));
            let diagnostic = Diagnostic::new(Kind::BadData, message).at(point.location.clone());
            diagnostics.push(diagnostic.hint("give each its own name"));
        }
        diagnostics
    }
}

impl NamedPoint {
    /// The position, if it is given in space.
    pub fn in_space(&self) -> Option<Point3<f64>> {
        if let PointPosition::InSpace(position) = self.position { Some(position) } else { None }
    }
}
