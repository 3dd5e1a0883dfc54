//! Markers: pairs of corresponding points that the user gives, in files.
//!
//! Files count the vertices and triangles of the *meshes*, as [`MeshPoint`](mimesh_core::mesh::MeshPoint) does;
//! [`MarkerFile::resolve`] turns them into points of the welded surfaces that stages work on.
//!
//! - A file holds both sides of the markers, as `.cons` or as mimesh's own `.yaml`: a [`MarkerFile`] of [`MarkerPair`]s.
//! - Files of other programs hold the points of one mesh: a [`PointFile`]. Two of them are attached to their meshes and
//!   paired by a [`PointSource`]. A pipeline names one file or two: [`MarkerFiles`].
//! - [`mirror()`] completes markers across a plane, [`reattach()`] carries them to a mesh that was edited, and [`export()`] writes
//!   any notation.
//!
//! In reading order: [`mesh`], [`model`], [`points`], [`formats`], [`read`], [`attach`](mod@attach), [`pairing`],
//! [`point_source`], [`resolve`], and then the steps on markers.

pub mod anatomy;
mod anatomy_fit;
pub mod attach;
pub mod attacher;
pub mod diagnose;
pub mod export;
pub mod formats;
pub mod indices;
mod landmarks;
mod marker_files;
pub mod mesh;
pub mod mirror;
pub mod model;
pub mod notation;
pub mod pairing;
pub mod point_source;
pub mod points;
mod points_on;
pub mod read;
pub mod reattach;
pub mod remedies;
pub mod resolve;
pub mod scene;
pub mod side_names;
pub mod stale;
mod text;
pub mod unit_axes;

pub use diagnose::{IntoDiagnostic, MORE_MEMORY, OTHER_OUTPUT_FOLDER, OTHER_ROOT};
pub use export::{Exported, export};
pub use landmarks::from_landmarks;
pub use marker_files::MarkerFiles;
pub use mesh::{MarkerMesh, MeshRole};
pub use mirror::{Mirrored, Outcome, Plane, mirror};
pub use model::{MarkerFile, MarkerPair, MarkerStatus, MeshReference};
pub use notation::is_point_file;
pub use point_source::{AttachedMarkers, Note, PointSource};
pub use points::{NamedPoint, PointFile, PointPosition};
pub use points_on::points_on;
pub use read::{read_markers, read_points};
pub use reattach::{Move, reattach};
pub use scene::ScenePoints;
pub use unit_axes::UnitAxes;
