//! The origin of stored positions, so that those of a mesh far from 0 keep their digits in f32.

use mimesh_core::mesh::Mesh;
use nalgebra::Vector3;

/// The part of the diagonal that rounding to f32 may cost.
const MAX_ROUNDING: f64 = 1e-7;

/// The origin of the stored positions of `mesh`: 0 where f32 holds these well, else near the centre of its box.
///
/// It is a multiple of a power of two of about a tenth of the diagonal. So it has few digits, is whole for a mesh of tens of
/// units, and f32 holds it unless the mesh is some millions of diagonals away.
pub fn offset(mesh: &Mesh) -> Vector3<f64> {
    let (low, high) = mesh.bounding_box_of(&mesh.positions);
    let diagonal = (high - low).norm();
    let farthest = low.coords.abs().sup(&high.coords.abs()).max();
    // An f32 lies at most half of epsilon, relative to it, from the number it stands for.
    if farthest * f64::from(f32::EPSILON) / 2.0 <= MAX_ROUNDING * diagonal {
        return Vector3::zeros();
    }
    let step = (diagonal / 8.0).log2().floor().exp2();
    let centre = nalgebra::center(&low, &high).coords;
    let offset = centre.map(|x| (x / step).round() * step);
    if offset.iter().all(|x| x.is_finite()) { offset } else { centre }
}

#[cfg(test)]
mod tests {
    use nalgebra::Point3;

    use super::*;

    fn triangle_at(x: f64, size: f64) -> Mesh {
        let positions = vec![Point3::new(x, 0., 0.), Point3::new(x + size, 0., 0.), Point3::new(x, size, 0.)];
        Mesh::from_triangles(positions, &[[0, 1, 2]])
    }

    #[test]
    fn a_mesh_about_the_origin_has_none() {
        assert_eq!(offset(&triangle_at(-0.5, 1.0)), Vector3::zeros());
        assert_eq!(offset(&triangle_at(0.0, 1e-9)), Vector3::zeros());
        assert_eq!(offset(&triangle_at(1.0, 1.0)), Vector3::zeros());
    }

    #[test]
    fn a_mesh_far_away_has_one_of_few_digits_within_it() {
        for (x, size) in [(5e6, 4.0), (1e12, 3.0), (-77.7, 0.01), (1e9, 1e3)] {
            let offset = offset(&triangle_at(x, size));
            assert!((offset.x - x).abs() < size, "{offset}");
            // Whole multiples of a power of two: 24 bits hold those that are less than 2^24 of them.
            assert!(offset.x.abs() > 1e7 * size || f64::from(offset.x as f32) == offset.x);
        }
        assert_eq!(offset(&triangle_at(5e6, 40.0)).x.fract(), 0.0);
    }

    #[test]
    fn a_mesh_of_one_point_is_stored_at_its_point() {
        let mesh = Mesh::from_triangles(vec![Point3::new(3., 4., 5.); 3], &[[0, 1, 2]]);
        assert_eq!(offset(&mesh), Vector3::new(3., 4., 5.));
    }
}
