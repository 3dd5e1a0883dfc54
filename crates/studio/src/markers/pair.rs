//! A pair of corresponding points, of which one may still be missing.

use std::sync::Arc;

use mimesh_core::mesh::MeshPoint;
use mimesh_markers::{MarkerStatus, MeshRole};
use serde::{Deserialize, Serialize};

/// How many colours pairs have.
pub const COLOURS: u64 = 12;

/// A pair of the document.
#[derive(Clone, Debug, PartialEq)]
pub struct Pair {
    /// Stays the same for the life of the project, and is never used twice.
    pub id: u64,
    /// The number on its labels, from 1; it stays when other pairs are deleted.
    pub number: usize,
    /// What the user sees and changes.
    pub content: Content,
    /// Who made it.
    pub origin: Origin,
    /// The last change of each aspect.
    pub changes: [Change; Aspect::ALL.len()],
}

/// What the user sees and changes of a pair; the file holds exactly this.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Content {
    /// The name.
    pub name: Option<String>,
    /// A remark.
    pub note: Option<String>,
    /// The points of source and target; at least one.
    pub points: [Option<Point>; 2],
    /// Whether a person stands for it.
    pub status: Status,
    /// How sure whoever proposed it was, 0 to 1.
    pub confidence: Option<f64>,
}

/// What is merged separately: edits of different aspects of a pair do not conflict.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Aspect {
    /// The point of the source.
    Source,
    /// The point of the target.
    Target,
    /// The name.
    Name,
    /// The remark.
    Note,
    /// The status.
    Status,
}

/// A change of an aspect.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Change {
    /// The revision that it made.
    pub revision: u64,
    /// The page that asked for it; empty for the server itself.
    pub client: Arc<str>,
}

/// One of the two meshes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Side {
    /// The mesh that gives its motion.
    Source,
    /// The mesh that takes it.
    Target,
}

/// A point of a mesh as its file counts.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(untagged)]
pub enum Point {
    /// A place on a triangle.
    Triangle(TrianglePoint),
    /// A vertex.
    Vertex(VertexPoint),
}

/// A place on a triangle.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct TrianglePoint {
    /// The triangle.
    pub triangle: u32,
    /// Coordinates of its corners, which sum to 1.
    pub barycentric: [f64; 3],
}

/// A vertex of the file.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct VertexPoint {
    /// The vertex.
    pub vertex: u32,
}

/// Whether a person stands for a pair.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Status {
    /// A person placed it or agreed to it.
    #[default]
    Confirmed,
    /// A stage found it.
    Proposed,
    /// A person left it out.
    Skipped,
}

/// Who made a pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Origin {
    /// A person.
    User,
    /// A stage.
    Proposed,
    /// The mirror.
    Mirrored,
    /// It was in the file.
    File,
}

/// How far barycentric coordinates may be off, and are put right.
const TOLERANCE: f64 = 1e-6;

impl Aspect {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::Source, Self::Target, Self::Name, Self::Note, Self::Status];
}

impl Side {
    /// 0 for the source, 1 for the target.
    pub fn index(self) -> usize {
        self as usize
    }

    /// The side as the crate of markers calls it.
    pub fn role(self) -> MeshRole {
        MeshRole::BOTH[self.index()]
    }

    /// The aspect that the point of this side is.
    pub fn aspect(self) -> Aspect {
        Aspect::ALL[self.index()]
    }
}

impl Point {
    /// The same point with coordinates that are not negative and sum to 1.
    ///
    /// # Errors
    ///
    /// A sentence if they are too far from that.
    pub fn normalised(self) -> Result<Self, String> {
        let Self::Triangle(TrianglePoint { triangle, barycentric }) = self else { return Ok(self) };
        let sum: f64 = barycentric.iter().sum();
        // What is not a number is not inside either.
        let is_inside = barycentric.iter().all(|b| *b >= -TOLERANCE) && (sum - 1.0).abs() <= TOLERANCE;
        if !is_inside {
            return Err(format!(
                "the barycentric coordinates {barycentric:?} lie outside the triangle, or do not sum to 1"
            ));
        }
        let clamped = barycentric.map(|b| b.max(0.0));
        let sum: f64 = clamped.iter().sum();
        Ok(Self::Triangle(TrianglePoint { triangle, barycentric: clamped.map(|b| b / sum) }))
    }
}

impl From<Point> for MeshPoint {
    fn from(point: Point) -> Self {
        match point {
            Point::Triangle(TrianglePoint { triangle, barycentric }) => Self::Triangle(triangle, barycentric),
            Point::Vertex(VertexPoint { vertex }) => Self::Vertex(vertex),
        }
    }
}

impl From<MeshPoint> for Point {
    fn from(point: MeshPoint) -> Self {
        match point {
            MeshPoint::Triangle(triangle, barycentric) => Self::Triangle(TrianglePoint { triangle, barycentric }),
            MeshPoint::Vertex(vertex) => Self::Vertex(VertexPoint { vertex }),
        }
    }
}

impl From<MarkerStatus> for Status {
    fn from(status: MarkerStatus) -> Self {
        match status {
            MarkerStatus::Confirmed => Self::Confirmed,
            MarkerStatus::Proposed => Self::Proposed,
            MarkerStatus::Skipped => Self::Skipped,
        }
    }
}

impl From<Status> for MarkerStatus {
    fn from(status: Status) -> Self {
        match status {
            Status::Confirmed => Self::Confirmed,
            Status::Proposed => Self::Proposed,
            Status::Skipped => Self::Skipped,
        }
    }
}

impl Pair {
    /// The revision that last changed it.
    pub fn revision(&self) -> u64 {
        self.changes.iter().map(|change| change.revision).max().unwrap_or_default()
    }

    /// The name for stages: the user's, or its number.
    pub fn label(&self) -> String {
        self.content.name.clone().unwrap_or_else(|| self.number.to_string())
    }

    /// The name for people: the user's, or e.g. `point 12`.
    pub fn title(&self) -> String {
        self.content.name.clone().unwrap_or_else(|| format!("point {}", self.number))
    }
}

impl Content {
    /// The aspects in which `self` and `other` differ; the confidence belongs to the status.
    pub fn differences(&self, other: &Self) -> Vec<Aspect> {
        let differs = |aspect: &Aspect| match aspect {
            Aspect::Source => self.points[0] != other.points[0],
            Aspect::Target => self.points[1] != other.points[1],
            Aspect::Name => self.name != other.name,
            Aspect::Note => self.note != other.note,
            Aspect::Status => self.status != other.status || self.confidence != other.confidence,
        };
        Aspect::ALL.into_iter().filter(differs).collect()
    }
}
