//! Meshes in their poses, from files and globs on the command line.

use mimesh_core::stage::Selection;
use std::path::{Path, PathBuf};

use mimesh_core::mesh::{Mesh, MeshSequence, Pose};
use mimesh_document::diagnostic::{Diagnostic, Kind, Result};
use mimesh_pipeline::{
    Formats,
    check::in_file,
    globs::{self, GlobMatch, nearby},
};

/// A mesh in one pose.
pub struct PosedMesh {
    /// The name of the pose, or of the file if it has no poses.
    pub name: String,
    /// The mesh in the pose.
    pub mesh: Mesh,
    /// The file that holds it.
    pub file: PathBuf,
}

/// Reads all files of `pattern`: each pose of a file, or its mesh if it has no poses. `file_name` names such a mesh.
///
/// # Errors
///
/// A diagnostic if no file matches, or if one cannot be read.
pub fn read_all(formats: &Formats, pattern: &str, file_name: fn(&GlobMatch) -> String) -> Result<Vec<PosedMesh>> {
    let matches = globs::expand(Path::new(""), pattern, &mut 0)
        .map_err(|refused| Diagnostic::new(Kind::Usage, refused.message).hint(refused.hint))?;
    if matches.is_empty() {
        let message = format!("no file matches `{pattern}`");
        return Err(Diagnostic::new(Kind::MissingInput, message).hint(nearby(Path::new(pattern))).into());
    }
    let mut all = Vec::new();
    for found in matches {
        let MeshSequence { rest, poses, .. } = read(formats, &found.path)?;
        if poses.is_empty() {
            all.push(PosedMesh { name: file_name(&found), mesh: rest, file: found.path });
            continue;
        }
        for Pose { name, positions, .. } in poses {
            let positions = positions.get().map_err(|error| in_file(&found.path, error))?.into_owned();
            all.push(PosedMesh { name, mesh: Mesh { positions, ..rest.clone() }, file: found.path.clone() });
        }
    }
    Ok(all)
}

/// Reads a file of a mesh.
///
/// # Errors
///
/// A diagnostic if no format reads it, or if it is damaged.
pub fn read(formats: &Formats, file: &Path) -> Result<MeshSequence> {
    formats.reader_of(file)?;
    Ok(formats.read(file, &Selection::default()).map_err(|error| in_file(file, error))?)
}
