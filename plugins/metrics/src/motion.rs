//! Whether poses in their order are frames of a motion.

use nalgebra::Point3;

/// The smallest cosine between the velocities of a motion: five frames a circle have 0.31, unrelated shapes −0.5.
const MIN_AGREEMENT: f64 = 0.25;
/// The largest motion of a source that stands still, relative to the diagonal, root mean square over vertices.
const STILL: f64 = 5e-4;

/// Whether three frames of the source, the latest first, follow each other in a motion.
///
/// The velocities between them agree over all vertices: Σ v₁ · v₀ ≥ ¼ √(Σ ‖v₁‖² Σ ‖v₀‖²). Unrelated shapes a, b and c have
/// −½ there, since b is in both velocities with opposite signs. A source that stands still is a motion too. `diagonal` is that
/// of the source.
pub fn are_frames([now, one, two]: [&[Point3<f64>]; 3], diagonal: f64) -> bool {
    let (mut product, mut late, mut early) = (0.0, 0.0, 0.0);
    for ((x, y), z) in now.iter().zip(one).zip(two) {
        let (after, before) = (x - y, y - z);
        product += after.dot(&before);
        late += after.norm_squared();
        early += before.norm_squared();
    }
    let still = now.len() as f64 * (STILL * diagonal).powi(2);
    (late <= still && early <= still) || (product > 0.0 && product >= MIN_AGREEMENT * (late * early).sqrt())
}

#[cfg(test)]
mod tests {
    use mimesh_core::testkit::{meshes, random::Random};
    use nalgebra::Vector3;

    use super::*;
    use crate::testing::moved;

    #[test]
    fn a_circle_of_six_frames_is_a_motion_and_unrelated_shapes_are_none() {
        let sphere = meshes::icosphere(1);
        let circle = |k: u32| {
            let angle = f64::from(k) * std::f64::consts::FRAC_PI_3;
            moved(&sphere.positions, Vector3::new(angle.cos(), angle.sin(), 0.0))
        };
        let (a, b, c) = (circle(2), circle(1), circle(0));
        assert!(are_frames([&a, &b, &c], sphere.diagonal()));
        assert!(are_frames([&a, &a, &a], sphere.diagonal()), "it stands still");
        let mut random = Random::new(1);
        let mut shape = || sphere.positions.iter().map(|p| p + random.vector() * 0.1).collect::<Vec<_>>();
        let (a, b, c) = (shape(), shape(), shape());
        assert!(!are_frames([&a, &b, &c], sphere.diagonal()));
        // One shape after two that are alike.
        assert!(!are_frames([&a, &b, &b], sphere.diagonal()));
    }
}
