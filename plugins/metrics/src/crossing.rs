//! Whether two triangles run through each other.

use nalgebra::{Point3, Vector3};

/// Whether one triangle crosses the other: an edge of one has its ends on both sides of the other, farther than `slack` from its
/// plane, and passes through it, rim included. Triangles that touch, or lie in one plane, do not cross; nor do those without area.
pub fn cross(a: &[Point3<f64>; 3], b: &[Point3<f64>; 3], slack: f64) -> bool {
    let Some(normal_a) = unit_normal(a) else { return false };
    let above_a = b.map(|p| (p - a[0]).dot(&normal_a));
    if one_side(&above_a, slack) {
        return false;
    }
    let Some(normal_b) = unit_normal(b) else { return false };
    let above_b = a.map(|p| (p - b[0]).dot(&normal_b));
    if one_side(&above_b, slack) {
        return false;
    }
    pierces(b, &above_a, a, slack) || pierces(a, &above_b, b, slack)
}

fn unit_normal([a, b, c]: &[Point3<f64>; 3]) -> Option<Vector3<f64>> {
    (b - a).cross(&(c - a)).try_normalize(0.0)
}

fn one_side(above: &[f64; 3], slack: f64) -> bool {
    above.iter().all(|x| *x <= slack) || above.iter().all(|x| *x >= -slack)
}

/// Whether an edge of `triangle`, whose corners are `above` the plane of `other`, passes through `other`.
fn pierces(triangle: &[Point3<f64>; 3], above: &[f64; 3], other: &[Point3<f64>; 3], slack: f64) -> bool {
    [(0, 1), (1, 2), (2, 0)].into_iter().any(|(i, j)| {
        let parted = (above[i] > slack && above[j] < -slack) || (above[i] < -slack && above[j] > slack);
        parted && passes(&triangle[i], &triangle[j], other)
    })
}

/// Whether the line through p and q passes through a triangle: it sees all three edges run the same way round.
fn passes(p: &Point3<f64>, q: &Point3<f64>, corners: &[Point3<f64>; 3]) -> bool {
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
        let crosses = |other: &[Point3<f64>; 3]| [cross(&floor, other, 1e-6), cross(other, &floor, 1e-6)];
        assert_eq!(crosses(&through), [true; 2]);
        for other in [beside, above, standing, inside, floor] {
            assert_eq!(crosses(&other), [false; 2], "{other:?}");
        }
    }

    #[test]
    fn an_edge_through_the_rim_of_two_triangles_crosses_at_least_one() {
        let halves = [FLOOR, [[2., 0., 0.], [2., 2., 0.], [0., 2., 0.]]].map(triangle);
        let through = triangle([[1.0, 1.0, -1.], [1.0, 1.0, 1.], [9., 9., 1.]]);
        assert!(halves.iter().any(|half| cross(half, &through, 1e-6)));
    }
}
