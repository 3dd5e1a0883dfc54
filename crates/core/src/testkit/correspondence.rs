//! The contract of correspondences.

use super::support::{bent_bar, one_thread, watched};
use crate::{
    mesh::SurfacePoint,
    stage::{Correspondence, Marker, TransferPair},
};

/// The contract of [`Correspondence`].
pub fn correspondence(name: &str, stage: &dyn Correspondence) {
    let surface = bent_bar();
    let markers: Vec<_> = (0..surface.vertex_count() as u32)
        .step_by(10)
        .map(|v| Marker { name: v.to_string(), source: SurfacePoint::Vertex(v), target: SurfacePoint::Vertex(v) })
        .collect();
    let pair = TransferPair { source: &surface, target: &surface, markers: &markers, proximity: None };
    let map = stage.correspond(pair).unwrap_or_else(|error| panic!("{name}: {error}"));
    map.check(pair).unwrap_or_else(|error| panic!("{name}: {error}"));
    let again = one_thread(|| watched(name, |work| stage.correspond_watched(pair, work)));
    let again = again.unwrap_or_else(|error| panic!("{name}: fails on one thread: {error}"));
    assert!(map == again, "{name}: another map on one thread, or while somebody waits");
    let barycentres = surface.barycentres(&surface.positions);
    let edge =
        surface.triangles.iter().map(|t| (surface.positions[t[0] as usize] - surface.positions[t[1] as usize]).norm());
    let edge = edge.fold(0.0, f64::max);
    for (t, partner) in map.triangles.iter().enumerate() {
        let Some(partner) = *partner else {
            panic!("{name}: triangle {t} of a surface paired with itself is an orphan")
        };
        let distance = (barycentres[t] - barycentres[partner as usize]).norm();
        assert!(distance <= edge, "{name}: triangle {t} paired with itself gives {partner}, {distance} away");
    }
}
