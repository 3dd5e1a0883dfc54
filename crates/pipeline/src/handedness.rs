//! Targets that are mirror images of the source.

use mimesh_core::{
    Result,
    mesh::{Surface, SurfacePoint},
    spatial::{MIRRORED, Orientation, Similarity, mirror_gain},
    stage::{Marker, TransferPair, TriangleMap},
};
use nalgebra::Point3;

use crate::{axis::Axis, input::RestMesh};

/// Fewer markers say too little of left and right.
const MIN_MARKERS: usize = 6;

/// What looks wrong if `markers` say that the meshes, as stages see them, are mirror images.
pub fn warning_of_markers(source: &RestMesh, target: &RestMesh, markers: &[Marker]) -> Option<String> {
    if markers.len() < MIN_MARKERS {
        return None;
    }
    let on = |surface: &Surface, side: fn(&Marker) -> SurfacePoint| -> Vec<_> {
        markers.iter().map(|marker| side(marker).position(surface, &surface.positions)).collect()
    };
    let source = on(&source.surface, |marker| marker.source);
    warning("markers", &source, &on(target.seen_surface(), |marker| marker.target), target.mirror_axis())
}

/// What looks wrong if a map says that the meshes of `pair`, the target mirrored along `axis` if any, are mirror images. Where there
/// are markers, they have said so before.
pub fn warning_of_map(pair: TransferPair<'_>, map: &TriangleMap, axis: Option<Axis>) -> Result<Option<String>> {
    if pair.markers.len() >= MIN_MARKERS {
        return Ok(None);
    }
    let [source, target] = map.sample(pair)?;
    Ok(warning("correspondence", &source, &target, axis))
}

/// What looks wrong if corresponding points from `origin` say that the meshes are mirror images.
fn warning(origin: &str, source: &[Point3<f64>], target: &[Point3<f64>], axis: Option<Axis>) -> Option<String> {
    if mirror_gain(source, target).is_none_or(|gain| gain <= MIRRORED) {
        return None;
    }
    Some(match axis {
        Some(axis) => format!(
            "`mirrored: {}` fits worse than none by the {origin}: remove it, or exchange left and right in the markers of one \
             side",
            axis.name()
        ),
        None => format!(
            "left and right are swapped by the {origin}: if the target is a mirror image of the source, say so with \
             `target: {{ mirrored: {} }}`; else exchange left and right in the markers of one side",
            best_axis(source, target).name()
        ),
    })
}

/// The axis along which the target needs least turning if it is mirrored.
fn best_axis(source: &[Point3<f64>], target: &[Point3<f64>]) -> Axis {
    let angle = |axis: &Axis| {
        let mirrored = |p: &Point3<f64>| {
            let mut p = *p;
            p[axis.index()] = -p[axis.index()];
            p
        };
        let target: Vec<_> = target.iter().map(mirrored).collect();
        Similarity::fit(source, &target, &vec![1.0; source.len()], Orientation::Fitted).angle_degrees()
    };
    Axis::ALL.into_iter().min_by(|a, b| angle(a).total_cmp(&angle(b))).unwrap_or(Axis::X)
}
