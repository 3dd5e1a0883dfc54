//! Whether one of two shapes is a mirror image of the other.

use nalgebra::{Matrix3, Point3, Vector3};

/// The gain above which a reflection is taken to fit better than a rotation; see [`mirror_gain`].
pub const MIRRORED: f64 = 1.2;

/// The smallest spread across points, relative to that along them; flatter ones lie in a plane.
const MIN_THICKNESS: f64 = 0.02;

/// Points that neither a rotation nor a reflection brings nearer than this belong to shapes in other poses, as arms stretched out and
/// arms held forward: they say nothing of handedness. The first number is of points with one scale, the second of points freed of
/// proportions. Eight true points of two kinds of animals have 0.1 to 0.3 and 0.15 to 0.29, of two people below 0.1 and 0.03 to 0.16;
/// of people who rest in other poses above 0.22 and 0.36. Only the first is small on thin shapes, whose depth freed of proportions is
/// noise.
const MAX_MISFIT: [f64; 2] = [0.2, 0.3];

/// How much better a reflection takes the points `source` to the points `target` than a rotation does.
///
/// Both sides are freed of place, size and proportions: s̃ = Cₛ^(−1/2) (s − s̄) with the covariance C. The mean of t̃ s̃ᵀ has singular
/// values σ₁ ≥ σ₂ ≥ |σ₃|, where σ₃ has the sign of its determinant. The best rotation leaves r₊ = 6 − 2 (σ₁ + σ₂ + σ₃), and the best
/// reflection leaves r₋ = 6 − 2 (σ₁ + σ₂ − σ₃). The gain is √((r₊ + 0.01) / (r₋ + 0.01)): above 1 the reflection fits better. `None` if
/// the points of one side lie in a plane, or if both leave too much, √(r / 3) or the same with one scale: then the shapes rest in other
/// poses.
pub fn mirror_gain(source: &[Point3<f64>], target: &[Point3<f64>]) -> Option<f64> {
    let ((s, _), (t, _)) = (whitened(source)?, whitened(target)?);
    let mean = t.iter().zip(&s).map(|(t, s)| t * s.transpose()).sum::<Matrix3<f64>>() / s.len() as f64;
    let mut values: Vec<f64> = mean.singular_values().iter().copied().collect();
    values.sort_by(|a, b| b.total_cmp(a));
    let (both, third) = (values[0] + values[1], values[2] * mean.determinant().signum());
    let residual = |third: f64| (6.0 - 2.0 * (both + third)).max(0.0);
    let [with_scale, freed] = MAX_MISFIT;
    if misfit(source, target) > with_scale && residual(third.abs()) > 3.0 * freed * freed {
        return None;
    }
    Some(((residual(third) + 0.01) / (residual(-third) + 0.01)).sqrt())
}

/// What the better of the best rotation and the best reflection, with one scale, leaves of the distances of corresponding points,
/// relative to the spread of `target`.
fn misfit(source: &[Point3<f64>], target: &[Point3<f64>]) -> f64 {
    let about_mean = |points: &[Point3<f64>]| -> Vec<Vector3<f64>> {
        let mean = points.iter().map(|p| p.coords).sum::<Vector3<f64>>() / points.len() as f64;
        points.iter().map(|p| p.coords - mean).collect()
    };
    let (s, t) = (about_mean(source), about_mean(target));
    let squares = |points: &[Vector3<f64>]| points.iter().map(Vector3::norm_squared).sum::<f64>();
    let both: Matrix3<f64> = t.iter().zip(&s).map(|(t, s)| t * s.transpose()).sum();
    // A reflection may take all singular values where a rotation takes the third with its sign, or the other way round.
    let nuclear: f64 = both.singular_values().sum();
    (1.0 - nuclear * nuclear / (squares(&s) * squares(&t)).max(f64::MIN_POSITIVE)).max(0.0).sqrt()
}

/// The points moved and scaled to mean 0 and covariance 1, and their spread along the longest direction before; `None` if they lie
/// in a plane.
pub fn whitened(points: &[Point3<f64>]) -> Option<(Vec<Vector3<f64>>, f64)> {
    let mean = points.iter().map(|p| p.coords).sum::<Vector3<f64>>() / points.len() as f64;
    let covariance =
        points.iter().map(|p| p.coords - mean).map(|d| d * d.transpose()).sum::<Matrix3<f64>>() / points.len() as f64;
    let eigen = covariance.symmetric_eigen();
    let (low, high) = (eigen.eigenvalues.min(), eigen.eigenvalues.max());
    if low <= MIN_THICKNESS * MIN_THICKNESS * high {
        return None;
    }
    let roots = Matrix3::from_diagonal(&eigen.eigenvalues.map(|x| 1.0 / x.sqrt()));
    let root = eigen.eigenvectors * roots * eigen.eigenvectors.transpose();
    Some((points.iter().map(|p| root * (p.coords - mean)).collect(), high.sqrt()))
}

#[cfg(test)]
mod tests {
    use nalgebra::Rotation3;

    use super::*;

    #[test]
    fn a_reflection_is_told_from_a_rotation_whatever_the_proportions() {
        let cloud = (0..20).map(f64::from).map(|i| Point3::new(i.sin(), (2.3 * i).cos() * 2.0, (0.7 * i).sin()));
        let cloud: Vec<_> = cloud.collect();
        let turn = Rotation3::from_euler_angles(0.9, -0.8, 2.0);
        let stretched = |side: f64| {
            let moved = move |p: &Point3<f64>| turn * Point3::new(side * p.x, 1.7 * p.y, 0.8 * p.z + 0.2 * p.x);
            cloud.iter().map(moved).collect::<Vec<_>>()
        };
        // Affine maps leave r₊ or r₋ no residual, so that only the 0.01 stands on one side.
        assert!(mirror_gain(&cloud, &stretched(1.0)).unwrap() < 0.2);
        assert!(mirror_gain(&cloud, &stretched(-1.0)).unwrap() > 5.0);
        // Bent beyond what proportions make of a shape.
        let bent: Vec<_> = cloud.iter().map(|p| Point3::new(p.x, p.y, p.y * p.y - p.z)).collect();
        assert_eq!(mirror_gain(&cloud, &bent), None, "other poses tell no handedness");
        let flat: Vec<_> = cloud.iter().map(|p| Point3::new(p.x, p.y, 0.0)).collect();
        assert_eq!(mirror_gain(&cloud, &flat), None, "a plane has no handedness");
    }
}
