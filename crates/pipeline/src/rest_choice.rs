//! Whether both meshes rest in the same shape, as far as markers show it.

use mimesh_core::{
    spatial::{Orientation, Similarity},
    stage::Marker,
};
use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

use crate::{
    formats::Formats,
    input::{PoseInput, RestMesh, evenly_spaced, read_pose},
};

/// Fewer markers say little of a shape: a similarity transform has seven free numbers.
const MIN_MARKERS: usize = 8;

/// Rests are as different as animals of two kinds in one stance up to this misfit.
const MIN_MISFIT: f64 = 0.2;

/// A pose fits clearly better if its misfit is at most this part of that of the rest.
const CLEARLY_BETTER: f64 = 0.75;

/// The most poses that are tried.
const MAX_POSES: usize = 200;

/// A warning if the rests differ much in shape and a pose of the source is clearly nearer to the rest of the target; it names the nearest.
pub fn warning_of_rest(
    [source, target]: [&RestMesh; 2],
    poses: &[PoseInput],
    formats: &Formats,
    markers: &[Marker],
) -> Option<String> {
    if markers.len() < MIN_MARKERS {
        return None;
    }
    let to: Vec<_> = markers.iter().map(|m| m.target.position(&target.surface, &target.surface.positions)).collect();
    let misfit_at = |positions: &[Point3<f64>]| {
        let from: Vec<_> = markers.iter().map(|m| m.source.position(&source.surface, positions)).collect();
        misfit(&from, &to)
    };
    let at_rest = misfit_at(&source.surface.positions);
    if at_rest.is_nan() || at_rest < MIN_MISFIT {
        return None;
    }
    let misfit_of = |i: usize| {
        let positions = read_pose(source, formats, &poses[i].from).ok()?;
        Some((misfit_at(&source.surface.from_mesh(&positions).ok()?), i))
    };
    let tried = evenly_spaced(poses.len(), MAX_POSES);
    let best = tried.into_par_iter().filter_map(misfit_of).min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let (misfit, best) = best.filter(|(misfit, _)| *misfit <= CLEARLY_BETTER * at_rest)?;
    let name = &poses[best].name;
    let file = source.path.as_ref().map_or_else(|| "…".into(), |path| path.display().to_string());
    Some(format!(
        "source and target rest in different shapes: their markers differ by {:.0} % of the target's extent once laid on each other, \
         and by {:.0} % with the source in pose {name}; take that for its rest, `rest: {{ file: {file}, pose: {name} }}`, if its shape is \
         the one that the target rests in",
        100.0 * at_rest,
        100.0 * misfit
    ))
}

/// How far points `from` are from `to` once laid on them by a similarity transform: the root mean square distance, relative to that
/// of `to` from their mean.
fn misfit(from: &[Point3<f64>], to: &[Point3<f64>]) -> f64 {
    let laid = Similarity::fit(from, to, &vec![1.0; from.len()], Orientation::Fitted);
    let mean = to.iter().map(|q| q.coords).sum::<Vector3<f64>>() / to.len() as f64;
    let distance: f64 = from.iter().zip(to).map(|(p, q)| (laid.apply(p) - q).norm_squared()).sum();
    (distance / to.iter().map(|q| (q.coords - mean).norm_squared()).sum::<f64>()).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_similar_shape_has_no_misfit_and_a_bent_one_has() {
        let line = |bend: f64| -> Vec<Point3<f64>> {
            (0..12).map(f64::from).map(|i| Point3::new(i, (i / 3.0).sin(), bend * i * i / 11.0)).collect()
        };
        let larger: Vec<_> = line(0.0).iter().map(|p| Point3::new(5.0 - 2.0 * p.y, 2.0 * p.x, 2.0 * p.z)).collect();
        // Rounding of coordinates of about 20.
        assert!(misfit(&line(0.0), &larger) < 1e-12);
        // The arch of the bend is a fifth as high as long.
        assert!(misfit(&line(1.5), &larger) > 0.1);
    }
}
