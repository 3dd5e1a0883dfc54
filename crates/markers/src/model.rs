//! Markers: pairs of corresponding points, and the meshes that they were made on.

use std::path::Path;

use nalgebra::Point3;
use serde::{Deserialize, Serialize};

use mimesh_core::mesh::MeshPoint;
use mimesh_document::{Diagnostic, Kind, Location, files::hash_file};

use crate::mesh::{MarkerMesh, MeshRole};

/// The contents of a file that holds both sides of markers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MarkerFile {
    /// The source mesh that the markers were made on.
    pub source: Option<MeshReference>,
    /// The target mesh that the markers were made on.
    pub target: Option<MeshReference>,
    /// The pairs, in the order of the file.
    pub pairs: Vec<MarkerPair>,
}

/// A mesh that markers were made on, by which a change of the mesh is noticed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshReference {
    /// The name of the mesh's file, for information.
    pub mesh: Option<String>,
    /// The number of its vertices.
    pub vertices: Option<usize>,
    /// The BLAKE3 hash of the file, in hexadecimal.
    pub blake3: Option<String>,
}

/// A pair of points, of which one may still be missing.
#[derive(Clone, Debug, PartialEq)]
pub struct MarkerPair {
    /// The name, if the pair has one.
    pub name: Option<String>,
    /// The point of the source; `None` while it is still to be found.
    pub source: Option<MeshPoint>,
    /// The point of the target; `None` while it is still to be found.
    pub target: Option<MeshPoint>,
    /// A remark.
    pub note: Option<String>,
    /// Whether a person stands for it.
    pub status: MarkerStatus,
    /// How sure whoever proposed it was, from 0 to 1.
    pub confidence: Option<f64>,
    /// The positions of source and target point when the pair was made, by which they are found after a mesh was edited.
    pub at: [Option<Point3<f64>>; 2],
    /// The place of the pair in its file.
    pub location: Option<Location>,
}

/// Whether a person stands for a pair.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum MarkerStatus {
    /// A person placed it or agreed to it: it is kept whatever it costs.
    #[default]
    Confirmed,
    /// A stage found it: it may be found anew elsewhere, or left out.
    Proposed,
    /// A person left it out: it stays in the file, and no stage sees it.
    Skipped,
}

impl MarkerFile {
    /// The mesh that the side `role` was made on.
    pub fn reference(&self, role: MeshRole) -> Option<&MeshReference> {
        match role {
            MeshRole::Source => self.source.as_ref(),
            MeshRole::Target => self.target.as_ref(),
        }
    }

    /// The name of pair `i` in messages: the user's, or its number from 1.
    pub fn name(&self, i: usize) -> String {
        self.pairs[i].name.clone().unwrap_or_else(|| (i + 1).to_string())
    }

    /// Records the positions of all points and the meshes that they are on; `files` are those of the meshes, if they have any.
    pub fn record_positions(&mut self, meshes: [MarkerMesh<'_>; 2], files: [Option<&Path>; 2]) {
        for (mesh, file) in meshes.into_iter().zip(files) {
            for pair in &mut self.pairs {
                pair.at[mesh.role.index()] = pair.point(mesh.role).and_then(|point| mesh.position(point));
            }
            let reference = Some(MeshReference::new(file, mesh));
            match mesh.role {
                MeshRole::Source => self.source = reference,
                MeshRole::Target => self.target = reference,
            }
        }
    }
}

impl MeshReference {
    /// The reference to `mesh`, which was read from `file`.
    pub fn new(file: Option<&Path>, mesh: MarkerMesh<'_>) -> Self {
        Self {
            mesh: file.and_then(Path::file_name).map(|name| name.to_string_lossy().into_owned()),
            vertices: Some(mesh.mesh.positions.len()),
            blake3: file.and_then(|file| hash_file(file).ok()),
        }
    }
}

impl MarkerPair {
    /// A pair of points and nothing else.
    pub fn new(source: MeshPoint, target: MeshPoint) -> Self {
        Self {
            name: None,
            source: Some(source),
            target: Some(target),
            note: None,
            status: MarkerStatus::Confirmed,
            confidence: None,
            at: [None; 2],
            location: None,
        }
    }

    /// The point on the mesh `role`.
    pub fn point(&self, role: MeshRole) -> Option<MeshPoint> {
        match role {
            MeshRole::Source => self.source,
            MeshRole::Target => self.target,
        }
    }

    /// A diagnostic at the place of the pair.
    pub(crate) fn diagnostic(&self, message: String) -> Diagnostic {
        Diagnostic { location: self.location.clone(), ..Diagnostic::new(Kind::BadData, message) }
    }
}
