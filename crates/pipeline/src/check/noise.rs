//! Triangles that are apart by noise in the last digits of a file.

use mimesh_core::mesh::{Surface, Welding};

use crate::input::RestMesh;

/// The tolerances that [`noise_warning`] tries: boundaries nearer to each other are apart by rounding, not by design.
const NOISE: [f64; 3] = [1e-6, 1e-5, 1e-4];

/// A sentence if fewer components are left where boundaries are welded that nearly coincide.
pub(super) fn noise_warning(name: &str, mesh: &RestMesh) -> Option<String> {
    let count = mesh.surface.components().count();
    if count < 2 || mesh.welding.tolerance > 0.0 || mesh.surface.topology().boundary.is_empty() {
        return None;
    }
    let welded = |tolerance: f64| {
        let welding = Welding { tolerance, ..mesh.welding.clone() };
        Some((tolerance, Surface::welded(&mesh.sequence.rest, &welding).ok()?.components().count()))
    };
    // The smallest tolerance of those that join most.
    let (tolerance, left) = NOISE.into_iter().filter_map(welded).min_by_key(|(_, left)| *left)?;
    let file = mesh.path.as_ref().map(|path| format!(" ({})", path.display())).unwrap_or_default();
    (left < count).then(|| {
        format!(
            "the {name}{file} has {count} components, some of whose boundaries lie within {tolerance:e} of the diagonal of each \
             other: `weld_tolerance: {tolerance:e}` in `{name}` would make {left} of them"
        )
    })
}
