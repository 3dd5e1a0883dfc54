//! Logarithms of rotations that vary over a surface.
//!
//! The logarithm of a rotation, axis times angle, is known up to whole turns about the axis. Taken between −π and π alone, it
//! jumps across the surface wherever the angle passes π, and parts that move alike look far apart. Here each vertex takes the
//! turn nearest to that of a neighbour, over the edges along which rotations differ least.

use std::{cmp::Reverse, collections::BinaryHeap, f64::consts::TAU};

use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};

/// Axis times angle of each rotation, #V, continuous over the edges given by `neighbours`.
///
/// In each connected part the vertex with the least angle has an angle below π.
pub(crate) fn logarithms(rotations: &[Matrix3<f64>], neighbours: &[Vec<(u32, f64)>]) -> Vec<Vector3<f64>> {
    let mut logarithms: Vec<_> = rotations.iter().map(logarithm).collect();
    let mut by_angle: Vec<usize> = (0..rotations.len()).collect();
    by_angle.sort_by(|&a, &b| logarithms[a].norm_squared().total_cmp(&logarithms[b].norm_squared()).then(a.cmp(&b)));
    let mut seen = vec![false; rotations.len()];
    for start in by_angle {
        if seen[start] {
            continue;
        }
        let mut queue = BinaryHeap::from([Reverse((0, start, start))]);
        while let Some(Reverse((_, vertex, from))) = queue.pop() {
            if std::mem::replace(&mut seen[vertex], true) {
                continue;
            }
            logarithms[vertex] = nearest_turn(logarithms[vertex], &logarithms[from]);
            for &(next, _) in neighbours[vertex].iter().filter(|(next, _)| !seen[*next as usize]) {
                let difference = (rotations[vertex] - rotations[next as usize]).norm_squared();
                // Positive numbers are ordered as their bits are.
                queue.push(Reverse((difference.to_bits(), next as usize, vertex)));
            }
        }
    }
    logarithms
}

/// Axis times angle, which is 0 to π; by way of the quaternion, whose entries keep their digits at every angle.
fn logarithm(rotation: &Matrix3<f64>) -> Vector3<f64> {
    UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(*rotation)).scaled_axis()
}

/// The logarithm nearest to `to` among those of the rotation that has the logarithm `of`.
fn nearest_turn(of: Vector3<f64>, to: &Vector3<f64>) -> Vector3<f64> {
    let angle = of.norm();
    // Of the identity every whole turn about any axis is a logarithm.
    let axis = if angle > 1e-9 { of / angle } else { to.try_normalize(1e-9).unwrap_or_else(Vector3::x) };
    axis * (angle + TAU * ((axis.dot(to) - angle) / TAU).round())
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    fn about(axis: Vector3<f64>, angle: f64) -> Matrix3<f64> {
        *Rotation3::new(axis.normalize() * angle).matrix()
    }

    #[test]
    fn the_logarithm_is_axis_times_angle_up_to_a_half_turn_and_at_it() {
        let axis = Vector3::new(0.3, -0.8, 0.5).normalize();
        for angle in [0.0, 1e-12, 1e-6, 1.0, 3.0, PI - 1e-6, PI - 1e-9] {
            let found = logarithm(&about(axis, angle));
            // The quaternion carries rounding of 1e-16; π − 1e-9 from the matrix alone is known to about 1e-8.
            assert!((found - axis * angle).norm() < 1e-8, "{angle}: {found}");
        }
        for axis in [Vector3::x(), Vector3::y(), Vector3::z(), axis] {
            let found = logarithm(&about(axis, PI));
            assert!((found - axis * PI).norm().min((found + axis * PI).norm()) < 1e-7, "{found}");
        }
    }

    #[test]
    fn a_row_of_vertices_turned_ever_further_has_no_jump() {
        let axis = Vector3::new(1.0, 2.0, -0.5).normalize();
        let count = 60;
        let angle = |i: usize| 0.1 * i as f64;
        let rotations: Vec<_> = (0..count).map(|i| about(axis, angle(i))).collect();
        let neighbours: Vec<_> = (0..count as u32)
            .map(|i| {
                [i.checked_sub(1), Some(i + 1)].into_iter().flatten().filter(|&j| j < 60).map(|j| (j, 1.0)).collect()
            })
            .collect();
        for (i, found) in logarithms(&rotations, &neighbours).iter().enumerate() {
            assert!((found - axis * angle(i)).norm() < 1e-7, "{i}: {found}");
        }
    }

    #[test]
    fn neighbours_on_both_sides_of_a_half_turn_are_near_each_other() {
        let neighbours = vec![vec![(1, 1.0)], vec![(0, 1.0)]];
        let rotations = [about(Vector3::y(), PI - 0.01), about(Vector3::y(), PI + 0.01)];
        let found = logarithms(&rotations, &neighbours);
        assert!((found[0] - found[1]).norm() < 0.021, "{found:?}");
    }
}
