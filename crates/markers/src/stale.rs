//! Markers whose meshes have changed since.

use std::path::Path;

use crate::{
    mesh::{MarkerMesh, POSITION_TOLERANCE},
    model::MarkerFile,
};

impl MarkerFile {
    /// A sentence if `mesh` is not the one that the markers in `file` were made on, and points may have moved.
    ///
    /// `hash` is the BLAKE3 hash of the mesh's file, if it comes from one.
    pub fn stale_warning(&self, file: &Path, mesh: MarkerMesh<'_>, hash: Option<&str>) -> Option<String> {
        let reference = self.reference(mesh.role)?;
        let (file, role, found) = (file.display(), mesh.role, mesh.mesh.positions.len());
        let name = reference.mesh.as_deref().unwrap_or(role.name());
        let changed = match (reference.vertices, &reference.blake3, hash) {
            (Some(vertices), ..) if vertices != found => {
                format!("{file}: made on a {role} of {vertices} vertices ({name}), which now has {found}")
            }
            (_, Some(expected), Some(hash)) if !expected.eq_ignore_ascii_case(hash) => {
                format!("{file}: the {role} ({name}) has changed since the markers were made")
            }
            _ => return None,
        };
        let consequence = match self.count_moved(mesh) {
            Some(0) => return None,
            Some(count) => format!("{count} of {} points no longer lie where they were put", self.pairs.len()),
            None => "the numbers may not fit any more".into(),
        };
        Some(format!("{changed}; {consequence}: reattach the markers to carry them over"))
    }

    /// How many points of `mesh` do not lie at the positions that the file gives; `None` if it does not give all of them.
    fn count_moved(&self, mesh: MarkerMesh<'_>) -> Option<usize> {
        let tolerance = POSITION_TOLERANCE * mesh.diagonal();
        let mut count = 0;
        for pair in &self.pairs {
            let Some(point) = pair.point(mesh.role) else { continue };
            let at = pair.at[mesh.role.index()]?;
            let stays = mesh.position(point).is_some_and(|position| (position - at).norm() <= tolerance);
            count += usize::from(!stays);
        }
        (!self.pairs.is_empty()).then_some(count)
    }
}
