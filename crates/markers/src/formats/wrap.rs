//! Wrap's points: a triangle with the coordinates of its first and second corner, `[42, 0.3, 0.5]`.

use nalgebra::Point3;

use mimesh_core::mesh::MeshPoint;

use crate::{points::PointPosition, text::ParseError};

/// Coordinates may lie outside their triangle by this, as they are rounded in files.
const ROUNDING: f64 = 1e-6;

/// Three numbers that may be a triangle with two coordinates, as Wrap writes it, or a position.
#[derive(Clone, Copy, Debug)]
pub struct Triple {
    /// The numbers.
    pub numbers: [f64; 3],
    /// Whether the first was written as a whole number.
    pub begins_whole: bool,
}

impl Triple {
    /// Whether most of `triples` are triangles: then all are meant so, and the others are wrong.
    pub fn are_triangles(triples: &[Self]) -> bool {
        let triangles = triples.iter().filter(|triple| triple.lies_on_triangle()).count();
        triples.iter().all(|triple| triple.begins_whole) && 2 * triangles > triples.len()
    }

    /// The place on a triangle; its corners have the coordinates u, v and 1 − u − v.
    ///
    /// # Errors
    ///
    /// If the place lies outside the triangle.
    pub fn on_triangle(self) -> Result<PointPosition, ParseError> {
        let [triangle, u, v] = self.numbers;
        if !self.lies_on_triangle() {
            return Err(ParseError::new(
                format!(
                    "expected `[triangle, u, v]` with u and v from 0 to 1 and a sum of 1 at most, found `[{triangle}, {u}, {v}]`"
                ),
                "u and v are the coordinates of the first and the second corner of the triangle",
            ));
        }
        Ok(PointPosition::OnMesh(MeshPoint::Triangle(triangle as u32, [u, v, 1.0 - u - v])))
    }

    /// The position in space.
    pub fn in_space(self) -> PointPosition {
        PointPosition::InSpace(Point3::from(self.numbers))
    }

    fn lies_on_triangle(self) -> bool {
        let [triangle, u, v] = self.numbers;
        let inside = u >= -ROUNDING && v >= -ROUNDING && u + v <= 1.0 + ROUNDING;
        self.begins_whole && (0.0..=f64::from(u32::MAX)).contains(&triangle) && inside
    }
}

/// The text of a file with places on triangles, each with the barycentric coordinates of the corners.
pub fn write(points: impl IntoIterator<Item = (u32, [f64; 3])>) -> String {
    // Wrap's own files have decimals here, which distinguish them from positions.
    let lines: Vec<_> =
        points.into_iter().map(|(triangle, [u, v, _])| format!("  [{triangle}, {u:?}, {v:?}]")).collect();
    format!("[\n{}\n]\n", lines.join(",\n"))
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use proptest::prelude::*;

    use super::*;
    use crate::formats::json;

    proptest! {
        #[test]
        fn points_come_back_as_written(
            points in prop::collection::vec((any::<u32>(), 0.0..0.5f64, 0.0..0.5f64), 1..8),
        ) {
            let points: Vec<_> = points.into_iter().map(|(t, u, v)| (t, [u, v, 1.0 - u - v])).collect();
            let file = json::parse(Path::new("points.txt"), &write(points.iter().copied())).unwrap();
            let back: Vec<_> = file.points.into_iter().map(|point| point.position).collect();
            let expected: Vec<_> =
                points.into_iter().map(|(t, b)| PointPosition::OnMesh(MeshPoint::Triangle(t, b))).collect();
            prop_assert_eq!(back, expected);
        }
    }
}
