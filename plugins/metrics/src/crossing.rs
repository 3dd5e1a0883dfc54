//! Whether two triangles cross.

use nalgebra::{Point3, Vector3};

/// Whether an edge of one triangle passes through the other, rim included.
///
/// The ends of that edge must lie on both sides of the other triangle, farther than `tolerance` from its plane. So triangles that
/// touch or lie in one plane do not cross. Triangles without area cross nothing.
pub fn triangles_cross(a: &[Point3<f64>; 3], b: &[Point3<f64>; 3], tolerance: f64) -> bool {
    let Some(normal_a) = unit_normal(a) else { return false };
    let heights_b = b.map(|p| (p - a[0]).dot(&normal_a));
    if are_on_one_side(&heights_b, tolerance) {
        return false;
    }
    let Some(normal_b) = unit_normal(b) else { return false };
    let heights_a = a.map(|p| (p - b[0]).dot(&normal_b));
    if are_on_one_side(&heights_a, tolerance) {
        return false;
    }
    pierces(b, &heights_b, a, tolerance) || pierces(a, &heights_a, b, tolerance)
}

fn unit_normal([a, b, c]: &[Point3<f64>; 3]) -> Option<Vector3<f64>> {
    (b - a).cross(&(c - a)).try_normalize(0.0)
}

fn are_on_one_side(heights: &[f64; 3], tolerance: f64) -> bool {
    heights.iter().all(|x| *x <= tolerance) || heights.iter().all(|x| *x >= -tolerance)
}

/// Whether an edge of `triangle` passes through `other`, above whose plane its corners have `heights`.
fn pierces(triangle: &[Point3<f64>; 3], heights: &[f64; 3], other: &[Point3<f64>; 3], tolerance: f64) -> bool {
    [(0, 1), (1, 2), (2, 0)].into_iter().any(|(i, j)| {
        let apart =
            (heights[i] > tolerance && heights[j] < -tolerance) || (heights[i] < -tolerance && heights[j] > tolerance);
        apart && line_meets(&triangle[i], &triangle[j], other)
    })
}

/// Whether the line through p and q passes through a triangle, all of whose edges then turn the same way about it.
fn line_meets(p: &Point3<f64>, q: &Point3<f64>, corners: &[Point3<f64>; 3]) -> bool {
    let along = q - p;
    let [a, b, c] = corners.map(|corner| corner - p);
    let sides = [along.dot(&a.cross(&b)), along.dot(&b.cross(&c)), along.dot(&c.cross(&a))];
    sides.iter().all(|x| *x >= 0.0) || sides.iter().all(|x| *x <= 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangle(corners: [[f64; 3]; 3]) -> [Point3<f64>; 3] {
        corners.map(Point3::from)
    }

    const FLOOR: [[f64; 3]; 3] = [[0., 0., 0.], [2., 0., 0.], [0., 2., 0.]];

    #[test]
    fn triangles_cross_touch_and_miss() {
        let floor = triangle(FLOOR);
        let through = triangle([[0.5, 0.5, -1.], [0.5, 0.5, 1.], [3., 3., 1.]]);
        let beside = through.map(|p| p + Vector3::new(2.0, 2.0, 0.0));
        let above = through.map(|p| p + Vector3::new(0.0, 0.0, 1.5));
        let standing = through.map(|p| p + Vector3::new(0.0, 0.0, 1.0));
        let inside = triangle([[0.2, 0.2, 0.], [0.5, 0.2, 0.], [0.2, 0.5, 0.]]);
        let crosses =
            |other: &[Point3<f64>; 3]| [triangles_cross(&floor, other, 1e-6), triangles_cross(other, &floor, 1e-6)];
        assert_eq!(crosses(&through), [true; 2]);
        for other in [beside, above, standing, inside, floor] {
            assert_eq!(crosses(&other), [false; 2], "{other:?}");
        }
    }

    #[test]
    fn an_edge_through_the_rim_of_two_triangles_crosses_at_least_one() {
        let halves = [FLOOR, [[2., 0., 0.], [2., 2., 0.], [0., 2., 0.]]].map(triangle);
        let through = triangle([[1.0, 1.0, -1.], [1.0, 1.0, 1.], [9., 9., 1.]]);
        assert!(halves.iter().any(|half| triangles_cross(half, &through, 1e-6)));
    }
}
