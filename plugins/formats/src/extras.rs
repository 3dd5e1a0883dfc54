//! Data of files that a mesh has no place for.

use mimesh_core::mesh::Mesh;

/// Data of a PLY or OFF that a mesh has no place for.
#[derive(Debug, Default)]
pub struct Extras {
    /// Whether coordinates are `double`.
    pub double: bool,
    /// Whether colours are whole numbers of 8 bits.
    pub colors_are_bytes: bool,
    /// Red, green, blue and opacity of the faces, each 0 to 1.
    pub face_colors: Option<Vec<[f64; 4]>>,
    /// The names of what was not read.
    pub left_out: Vec<String>,
}

impl Extras {
    /// Those of `mesh`, if it came with any and still has its faces.
    pub fn of(mesh: &Mesh) -> Option<&Self> {
        let count = mesh.polygons.len();
        let fits = |extras: &&Self| extras.face_colors.as_ref().is_none_or(|colors| colors.len() == count);
        mesh.document.get::<Self>().filter(fits)
    }

    /// The colours of the faces of `mesh`.
    pub fn face_colors(mesh: &Mesh) -> Option<&Vec<[f64; 4]>> {
        Self::of(mesh)?.face_colors.as_ref()
    }
}

/// A colour of 0 to 1 in 8 bits.
pub fn byte(x: f64) -> u8 {
    (x * 255.0).round().clamp(0.0, 255.0) as u8
}
