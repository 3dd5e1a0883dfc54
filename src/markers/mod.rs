//! Markers: pairs of corresponding points that the user gives, in files.
//!
//! Files name vertices and triangles of the *meshes*; [`MarkerFile::resolve`] turns them into points of the welded
//! surfaces that stages work on.
//!
//! - One file holds both sides as [`cons`] or as our own [`yaml`]: a [`MarkerFile`].
//! - Of other programs, a file has the points of one mesh ([`points`]): [`pp`], [`table`], [`json`]. Two of them are
//!   [attached](attach) to their meshes and [paired](given) to a [`MarkerFile`]. A pipeline names one file or two:
//!   [`MarkerFiles`].
//! - [`mirror`] completes markers across a plane, [`reattach`] carries them to a mesh that was edited, [`write`](mod@write)
//!   writes any notation.

pub mod attach;
pub mod cons;
mod files;
pub mod given;
mod indices;
pub mod json;
mod json_tree;
pub mod mirror;
mod one_side;
pub mod points;
pub mod pp;
pub mod reattach;
mod resolve;
pub mod table;
mod text;
pub mod usual;
pub mod write;
pub mod yaml;

use std::{collections::HashMap, path::Path};

use nalgebra::Point3;

pub use files::MarkerFiles;
pub use one_side::points_on;

use crate::{
    core::mesh::{Mesh, MeshSequence, Surface, SurfacePoint},
    diagnostic::Kind,
    diagnostic::{Diagnostic, Location, Result},
};

/// What a file of markers says.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MarkerFile {
    /// The source mesh that they were made on.
    pub source: Option<MeshReference>,
    /// The target mesh that they were made on.
    pub target: Option<MeshReference>,
    /// The pairs, in order.
    pub entries: Vec<Entry>,
}

/// A mesh that markers were made on, to notice that it has changed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshReference {
    /// The mesh's file, for information.
    pub mesh: Option<String>,
    /// Its number of vertices.
    pub vertices: Option<usize>,
    /// BLAKE3 hash of the file, in hexadecimal.
    pub blake3: Option<String>,
}

/// A pair of points.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// A name, if it has one.
    pub name: Option<String>,
    /// A vertex of the source mesh, or a place on one of its triangles.
    pub source: SurfacePoint,
    /// A vertex of the target mesh, or a place on one of its triangles; `None` while it is still to be found.
    pub target: Option<SurfacePoint>,
    /// A remark.
    pub note: Option<String>,
    /// Where the two points were when they were made, source and target: what they are found by after a mesh was edited.
    pub at: [Option<Point3<f64>>; 2],
    /// Where the pair stands in its file.
    pub location: Option<Location>,
}

/// One of the two meshes, as far as markers need it.
#[derive(Clone, Copy, Debug)]
pub struct Side<'a> {
    /// `source` or `target`.
    pub name: &'static str,
    /// The mesh that the file's numbers count.
    pub mesh: &'a Mesh,
    /// Its surface.
    pub surface: &'a Surface,
}

/// Reads a file of markers, in the notation that its extension tells.
///
/// # Errors
///
/// All that is wrong with the file, each with its line.
pub fn read(path: &Path) -> Result<MarkerFile> {
    match path.extension().map(|e| e.to_string_lossy().to_lowercase()).as_deref() {
        Some("cons") => cons::parse(path, &text::read(path)?),
        Some("yaml" | "yml") => yaml::parse(path, &text::read(path)?),
        _ if points::is_one_sided(path) => {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            let message =
                format!("a .{} holds the points of one mesh only", points::extension(path).unwrap_or_default());
            Err(Diagnostic::new(Kind::BadPipeline, message)
                .at(Location::File(path.into()))
                .hint(format!("name a file for each side: `markers: {{ source: {name}, target: … }}`"))
                .into())
        }
        _ => Err(Diagnostic::new(Kind::BadPipeline, "not a file of markers: expected .cons or .yaml")
            .at(Location::File(path.into()))
            .hint("a .cons has the count in its first line, then `source, target` a line")
            .into()),
    }
}

/// The landmarks that both meshes have, as markers: pairs of equal names.
pub fn from_landmarks(source: &MeshSequence, target: &MeshSequence) -> MarkerFile {
    let targets: HashMap<&str, SurfacePoint> = target.landmarks.iter().map(|l| (l.name.as_str(), l.point)).collect();
    let pair = |source: &crate::core::mesh::Landmark| {
        let target = *targets.get(source.name.as_str())?;
        Some(Entry {
            name: Some(source.name.clone()),
            source: source.point,
            target: Some(target),
            note: None,
            at: [None; 2],
            location: None,
        })
    };
    MarkerFile { entries: source.landmarks.iter().filter_map(pair).collect(), ..MarkerFile::default() }
}

impl MarkerFile {
    /// The mesh that side `source` or `target` was made on.
    pub fn reference(&self, side: &str) -> Option<&MeshReference> {
        if side == "source" { self.source.as_ref() } else { self.target.as_ref() }
    }

    /// The name of entry `i` in messages: the user's, or its number from 1.
    pub fn name(&self, i: usize) -> String {
        self.entries[i].name.clone().unwrap_or_else(|| (i + 1).to_string())
    }
}

impl MeshReference {
    /// That of `side`, which was read from `file`.
    pub fn new(file: Option<&Path>, side: Side<'_>) -> Self {
        Self {
            mesh: file.and_then(Path::file_name).map(|name| name.to_string_lossy().into_owned()),
            vertices: Some(side.mesh.positions.len()),
            blake3: file.and_then(|file| crate::pipeline::hash_file(file).ok()),
        }
    }
}

impl Entry {
    /// A pair of points and nothing else.
    pub fn new(source: SurfacePoint, target: SurfacePoint) -> Self {
        Self { name: None, source, target: Some(target), note: None, at: [None; 2], location: None }
    }

    /// The point on the side `source` or `target`.
    pub fn of(&self, side: &str) -> Option<SurfacePoint> {
        if side == "source" { Some(self.source) } else { self.target }
    }

    fn diagnostic(&self, message: String) -> Diagnostic {
        let diagnostic = Diagnostic::new(Kind::BadData, message);
        match &self.location {
            Some(location) => diagnostic.at(location.clone()),
            None => diagnostic,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn landmarks_of_equal_names_are_markers() {
        use crate::core::mesh::Landmark;
        let of = |names: [&str; 2]| MeshSequence {
            landmarks: names
                .iter()
                .enumerate()
                .map(|(i, name)| Landmark { name: name.to_string(), point: SurfacePoint::Vertex(i as u32) })
                .collect(),
            ..MeshSequence::default()
        };
        let file = from_landmarks(&of(["nose", "tail"]), &of(["ear", "nose"]));
        assert_eq!(file.entries.len(), 1);
        assert_eq!(
            (file.entries[0].source, file.entries[0].target),
            (SurfacePoint::Vertex(0), Some(SurfacePoint::Vertex(1)))
        );
    }
}
