//! Ways out that the host program has to name, as actions of a [`Remedy`](mimesh_document::Remedy).

/// Remedy: convert markers whose numbers count from 1; the argument is `source` or `target`.
pub const FROM_ONE: &str = "markers_from_one";
/// Remedy: convert points with their unit and axes fitted to the mesh.
pub const FIT_UNIT_AXES: &str = "markers_fit_unit_axes";
/// Remedy: give the mesh that markers were made on; the argument is `source` or `target`.
pub const OLD_MESH: &str = "markers_old_mesh";
/// Remedy: carry markers to an edited mesh although points come to lie far away.
pub const FORCE_REATTACH: &str = "markers_force_reattach";
