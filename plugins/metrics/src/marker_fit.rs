//! Markers in a wrong place, and left and right swapped.

use mimesh_core::{
    Figures, Result, register,
    spatial::{MIRRORED, mirror_gain, whitened},
    stage::{BoundMetric, Measured, Metric, MetricContext, Statistic, TransferPair},
};
use nalgebra::{DMatrix, Point3, Vector3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{
    at_rest::AtRest,
    diagonal,
    distribution::{Distribution, first_largest},
};

register!(Metric: MarkerFit);

/// Markers in a wrong place, and left and right swapped, at rest.
///
/// **A marker against the others.** The smoothest map from source to target through all markers but one says where that one should
/// lie. The map is biharmonic: p ↦ Σ wⱼ ‖p − sⱼ‖ + A p + t. The residual r of the marker is its distance from there. Its score is r
/// √m with m its diagonal value in the inverse of the system of all markers: a marker far from all others may miss by more (Rippa
/// 1999).
///
/// **Left and right.** Both sides are freed of place, size and proportions: s̃ = Cₛ^(−1/2) (s − s̄) with the covariance C. The mean
/// of t̃ s̃ᵀ has singular values σ₁ ≥ σ₂ ≥ |σ₃|, where σ₃ has the sign of its determinant. The best rotation leaves r₊ = 6 − 2 (σ₁
/// + σ₂ + σ₃), and the best reflection leaves r₋ = 6 − 2 (σ₁ + σ₂ − σ₃).
///
/// The outlier is the largest score over the median score, both plus 0.1 % of the diagonal. If that marker's residual is below 15 %
/// of the diagonal, it counts in proportion: a marker that stands out by little is a hump of the body.
///
/// In place of fewer than eight markers, points of the map tell left from right, and no more. Markers nearly in a plane, spread across
/// it by less than 1/50 of their spread along it, lack the statistics that need three dimensions. Of more than 600 markers every n-th
/// is used. All poses have the same statistics.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct MarkerFit {}

/// The smallest number of markers that can fit each other.
const MIN_MARKERS: usize = 8;
/// The largest number of markers that are used, since the work grows with the third power.
const MAX_MARKERS: usize = 600;
/// The residual from which an outlier counts in full, in percent of the diagonal.
const FULL_RESIDUAL: f64 = 15.0;

#[typetag::serde(name = "marker_fit")]
impl Metric for MarkerFit {
    fn bind<'a>(&self, context: MetricContext<'a>) -> Result<Box<dyn BoundMetric + 'a>> {
        let mut statistics = Figures::default();
        if let Some(pair) = context.pair.filter(|pair| pair.markers.len() >= MIN_MARKERS) {
            pair.check_markers()?;
            let diagonal = diagonal::of_target(context.surface)?;
            fit(pair, diagonal, &mut statistics);
        } else if let Some((pair, map)) = context.pair.zip(context.map) {
            let [source, target] = map.sample(pair)?;
            set_mirrored(mirror_gain(&source, &target), &mut statistics);
        }
        let worst = statistics.number("worst").and_then(|worst| context.pair?.markers.get(worst as usize));
        let about = worst.map(|marker| ("outlier", format!("marker {}", marker.name))).into_iter().collect();
        Ok(AtRest::boxed(context, Measured { statistics, about, ..Measured::default() }))
    }

    fn statistics(&self) -> Vec<Statistic> {
        vec![
            Statistic::new("mirrored", "0 or 1", "1 if `mirror_gain` is above 1.2: left and right are swapped.")
                .with_title("left and right are swapped")
                .with_limits(0.0, 0.0),
            Statistic::new(
                "mirror_gain",
                "ratio",
                "√((r₊ + 0.01) / (r₋ + 0.01)): above 1 a reflection fits better than a rotation; none where \
                 neither fits.",
            ),
            Statistic::new(
                "outlier",
                "ratio",
                "Largest score relative to the median score; 1 if all markers fit alike.",
            )
            .with_title("misfit of the worst marker relative to the others")
            .with_limits(7.0, 50.0),
            Statistic::new("residual_p50", "%", "Median residual."),
            Statistic::new("residual_max", "%", "Largest residual."),
            Statistic::index("worst", "Marker with the largest score, by its place in the list."),
        ]
    }

    fn fault(&self) -> &'static str {
        "a marker lies far from where the others expect it, or left and right are swapped: correct it, or leave it out if both places are the same part"
    }

    fn by_default(&self) -> bool {
        true
    }

    fn is_of_rest(&self) -> bool {
        true
    }
}

/// Sets the statistics that markers of this number and arrangement have.
fn fit(pair: TransferPair<'_>, diagonal: f64, statistics: &mut Figures) {
    let step = pair.markers.len().div_ceil(MAX_MARKERS);
    let used = || pair.markers.iter().step_by(step);
    let source: Vec<_> = used().map(|m| m.source.position(pair.source, &pair.source.positions)).collect();
    let target: Vec<_> = used().map(|m| m.target.position(pair.target, &pair.target.positions)).collect();
    set_mirrored(mirror_gain(&source, &target), statistics);
    let Some(misfits) = misfits(&source, &target) else { return };
    let all: Vec<f64> = misfits.iter().map(|misfit| misfit.score).collect();
    let (Some(scores), Some(worst)) = (Distribution::unweighted(all.iter().copied()), first_largest(&all)) else {
        return;
    };
    let (median, max) = (scores.percentile(0.5), scores.max());
    let residuals = misfits.iter().map(|misfit| 100.0 * misfit.residual / diagonal);
    let Some(residuals) = Distribution::unweighted(residuals) else { return };
    // Scores of markers that fit to rounding are noise.
    let floor = 1e-3 * diagonal;
    // A marker that stands out by little is a hump of the body, no mistake.
    let residual = 100.0 * misfits[worst].residual / diagonal;
    statistics.set("outlier", (max + floor) / (median + floor) * (residual / FULL_RESIDUAL).min(1.0));
    statistics.set("residual_p50", residuals.percentile(0.5));
    statistics.set("residual_max", residuals.max());
    statistics.set("worst", step * worst);
}

/// Sets the statistics of left and right.
fn set_mirrored(gain: Option<f64>, statistics: &mut Figures) {
    if let Some(gain) = gain {
        statistics.set("mirrored", u8::from(gain > MIRRORED));
        statistics.set("mirror_gain", gain);
    }
}

/// How badly a marker fits the others.
struct Misfit {
    /// The distance between it and the place that the others give it.
    residual: f64,
    /// The residual, weighted by how certain that place is.
    score: f64,
}

/// How badly each point of `target` fits the smoothest map through all others; `None` if points lie in a plane.
///
/// All residuals come from one inverse of the full system: rₖ = (M⁻¹ b)ₖ / (M⁻¹)ₖₖ (Rippa 1999). There 1 / (M⁻¹)ₖₖ is the square of
/// what a map of this smoothness may differ by.
fn misfits(source: &[Point3<f64>], target: &[Point3<f64>]) -> Option<Vec<Misfit>> {
    let n = source.len();
    let (_, scale) = whitened(source)?;
    let mut m = DMatrix::zeros(n + 4, n + 4);
    for i in 0..n {
        for j in 0..n {
            m[(i, j)] = -(source[i] - source[j]).norm() / scale;
        }
        let from_first = (source[i] - source[0]) / scale;
        for (k, value) in [1.0, from_first.x, from_first.y, from_first.z].into_iter().enumerate() {
            m[(i, n + k)] = value;
            m[(n + k, i)] = value;
        }
    }
    let inverse = m.try_inverse()?;
    let misfit = |k: usize| {
        let sum: Vector3<f64> = (0..n).map(|j| (target[j] - target[0]) * inverse[(k, j)]).sum();
        let certainty = inverse[(k, k)].abs();
        Misfit { residual: sum.norm() / certainty, score: sum.norm() / certainty.sqrt() }
    };
    Some((0..n).map(misfit).collect())
}

#[cfg(test)]
mod tests {
    use mimesh_core::{
        mesh::{Mesh, Surface, SurfacePoint},
        stage::{Marker, MetricInput},
        testkit::meshes,
    };

    use super::*;
    use crate::testing::assert_statistic;

    /// A capsule bent and thickened, paired by `partner` of every fifth vertex with itself at rest.
    fn measure(partner: impl Fn(u32) -> u32) -> Figures {
        let source = meshes::capsule(12, 6, 3.0);
        let bent = |p: &Point3<f64>| Point3::new(1.2 * p.x + 0.1 * p.y * p.y, p.y, 0.9 * p.z + 0.3 * p.x);
        let positions = source.positions.iter().map(bent).collect();
        let target = Surface::from_triangles(positions, source.triangles.clone()).unwrap();
        let marker = |v: u32| Marker {
            name: v.to_string(),
            source: SurfacePoint::Vertex(v),
            target: SurfacePoint::Vertex(partner(v)),
        };
        let markers: Vec<_> = (0..source.vertex_count() as u32).step_by(5).map(marker).collect();
        let mesh = Mesh::from_triangles(target.positions.clone(), &target.triangles);
        let pair = TransferPair { source: &source, target: &target, markers: &markers, proximity: None };
        let context = MetricContext { pair: Some(pair), ..MetricContext::alone(&mesh, &target) };
        MarkerFit {}.bind(context).unwrap().measure(MetricInput::alone(context.at_rest())).unwrap().statistics
    }

    #[test]
    fn markers_of_a_smooth_map_fit_and_one_on_the_wrong_side_is_named() {
        let good = measure(|v| v);
        assert_statistic(&good, "mirrored", 0.0, 0.0);
        assert!(good.number("outlier").unwrap() < 7.0, "{good:?}");
        let bad = measure(|v| if v == 45 { 51 } else { v });
        assert_statistic(&bad, "worst", 9.0, 0.0);
        assert!(bad.number("outlier").unwrap() > 12.0, "{bad:?}");
    }

    #[test]
    fn swapped_sides_are_seen_whatever_the_proportions() {
        let source = meshes::capsule(12, 6, 3.0);
        let mirrored = |v: u32| {
            let p = source.positions[v as usize];
            let distance = |u: &u32| (source.positions[*u as usize] - Point3::new(-p.x, p.y, p.z)).norm();
            (0..source.vertex_count() as u32).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap()
        };
        let statistics = measure(mirrored);
        assert_statistic(&statistics, "mirrored", 1.0, 0.0);
        assert!(statistics.number("mirror_gain").unwrap() > 3.0, "{statistics:?}");
    }

    #[test]
    fn the_residual_is_what_leaving_the_marker_out_gives() {
        // The formula against the map through all but one, solved for itself.
        let source: Vec<_> =
            (0..12).map(f64::from).map(|i| Point3::new(i.sin(), (2.3 * i).cos(), (0.7 * i).sin())).collect();
        let target: Vec<_> = source.iter().map(|p| Point3::new(p.x + p.y * p.y, p.y, p.z - 0.3 * p.x * p.y)).collect();
        let all = misfits(&source, &target).unwrap();
        for left_out in [0usize, 5, 11] {
            let rest: Vec<usize> = (0..12).filter(|&k| k != left_out).collect();
            let kernel = |a: usize, b: usize| -(source[a] - source[b]).norm();
            let affine = |a: usize| [1.0, source[a].x, source[a].y, source[a].z];
            let size = rest.len() + 4;
            let m = DMatrix::from_fn(size, size, |i, j| match (rest.get(i), rest.get(j)) {
                (Some(&a), Some(&b)) => kernel(a, b),
                (Some(&a), None) => affine(a)[j - rest.len()],
                (None, Some(&b)) => affine(b)[i - rest.len()],
                (None, None) => 0.0,
            });
            let b = DMatrix::from_fn(size, 3, |i, k| rest.get(i).map_or(0.0, |&a| target[a][k]));
            let x = m.lu().solve(&b).unwrap();
            let row = |i: usize| rest.get(i).map_or_else(|| affine(left_out)[i - rest.len()], |&a| kernel(left_out, a));
            let at = Vector3::from_fn(|k, _| (0..size).map(|i| row(i) * x[(i, k)]).sum());
            let expected = (target[left_out].coords - at).norm();
            // Two solutions of systems of condition about 1e3.
            assert!((all[left_out].residual - expected).abs() < 1e-10, "{} {expected}", all[left_out].residual);
        }
    }
}
