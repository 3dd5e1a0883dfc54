//! The points of markers on one mesh alone, as for a picture of it.

use std::path::Path;

use super::{
    Side,
    attach::{self, Attacher},
    indices::{Given, check, on_surface},
    points, usual,
};
use crate::{
    core::mesh::SurfacePoint,
    diagnostic::{Diagnostics, Result},
};

/// The points in `file` on the surface of `side`: of pairs those of that side, where they are known.
///
/// # Errors
///
/// All that is wrong with the file, and points that are not on the mesh.
pub fn points_on(file: &Path, side: Side<'_>) -> Result<Vec<SurfacePoint>> {
    let points: Vec<SurfacePoint> = if points::is_one_sided(file) {
        let points = points::read(file)?;
        let attacher = Attacher::new(side)?;
        let usual = usual::fitting(&attacher, &attach::positions(&points)).unwrap_or(usual::Usual::NOTHING);
        attach::attach(&points, &attacher, usual)?.into_iter().map(|attached| attached.point).collect()
    } else {
        let markers = super::read(file)?;
        let given: Vec<Given> = (0..markers.entries.len())
            .filter_map(|i| {
                let point = markers.entries[i].of(side.name)?;
                let location = markers.entries[i].location.clone();
                Some(Given { label: format!("marker {}", markers.name(i)), point, location })
            })
            .collect();
        let diagnostics = check(side, &given);
        if !diagnostics.is_empty() {
            return Err(Diagnostics { diagnostics });
        }
        given.into_iter().map(|given| given.point).collect()
    };
    // What is on the mesh is on its surface.
    Ok(points.into_iter().filter_map(|point| on_surface(side, point).ok()).collect())
}
