//! The attributes of primitives, and the triangles of those modes that have any.

use gltf::json::{
    Accessor, Index,
    mesh::{Mode, Primitive, Semantic},
    validation::Checked,
};

/// The accessor of an attribute.
pub fn attribute(primitive: &Primitive, semantic: Semantic) -> Option<Index<Accessor>> {
    primitive.attributes.get(&Checked::Valid(semantic)).copied()
}

/// Whether a primitive is points or lines, which no deformation can take.
pub fn is_thin(primitive: &Primitive) -> bool {
    matches!(primitive.mode, Checked::Valid(Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip))
}

/// The triangles of a primitive with these corners, all turning alike; none for points and lines.
///
/// Triangles with a repeated corner, which only join strips, are left out of strips and fans.
///
/// # Errors
///
/// If the corners do not make whole triangles, or the mode is not known.
pub fn triangles(mode: &Checked<Mode>, corners: &[u32]) -> Result<Vec<[u32; 3]>, String> {
    let has_area = |[a, b, c]: &[u32; 3]| a != b && b != c && c != a;
    match mode {
        Checked::Valid(Mode::Triangles) if corners.len().is_multiple_of(3) => Ok(corners.as_chunks().0.to_vec()),
        Checked::Valid(Mode::Triangles) => Err(format!("{} corners do not make whole triangles", corners.len())),
        Checked::Valid(Mode::TriangleStrip) => {
            let strip = corners.array_windows().enumerate();
            Ok(strip.map(|(i, &[a, b, c])| if i % 2 == 0 { [a, b, c] } else { [a, c, b] }).filter(has_area).collect())
        }
        Checked::Valid(Mode::TriangleFan) => {
            let Some((&hub, rim)) = corners.split_first() else { return Ok(Vec::new()) };
            Ok(rim.array_windows().map(|&[a, b]| [hub, a, b]).filter(has_area).collect())
        }
        Checked::Valid(_) => Ok(Vec::new()),
        Checked::Invalid => Err("unknown mode".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strips_and_fans_turn_alike() {
        assert_eq!(triangles(&Checked::Valid(Mode::Triangles), &[0, 1, 2, 2, 1, 3]).unwrap(), [[0, 1, 2], [2, 1, 3]]);
        assert_eq!(
            triangles(&Checked::Valid(Mode::TriangleStrip), &[0, 1, 2, 3, 3, 4]).unwrap(),
            [[0, 1, 2], [1, 3, 2]]
        );
        assert_eq!(triangles(&Checked::Valid(Mode::TriangleFan), &[9, 1, 2, 3]).unwrap(), [[9, 1, 2], [9, 2, 3]]);
        assert_eq!(
            triangles(&Checked::Valid(Mode::Triangles), &[0, 1]).unwrap_err(),
            "2 corners do not make whole triangles"
        );
        assert_eq!(triangles(&Checked::Valid(Mode::TriangleStrip), &[0]).unwrap(), [[0; 3]; 0]);
    }
}
