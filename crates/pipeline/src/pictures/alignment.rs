//! Cameras that see source and target from one side.

use mimesh_core::{
    mesh::{Surface, SurfacePoint},
    spatial::{Orientation, Similarity},
    stage::{Marker, TransferPair, TriangleMap},
};
use nalgebra::{Matrix3, Point3, Vector3};

use super::Camera;
use crate::{
    input::{Prepared, RestMesh},
    spec::{PictureSettings, Up},
};

/// Fewer markers do not say how a mesh is turned.
const MIN_MARKERS: usize = 4;

impl Camera {
    /// Returns the cameras for source and target of a run, which see both from one side.
    ///
    /// The target is turned as its markers say, or as `map` says where there are few; quarter turns are exact, so that a mesh that
    /// stands stays upright. With neither, the axes that point up tell. What the pipeline says in `pictures` comes first.
    pub fn of_pair(prepared: &Prepared, map: Option<&TriangleMap>) -> [Self; 2] {
        let Prepared { pipeline, source, target, formats, .. } = prepared;
        let up_of = |said: Option<Up>, mesh: &RestMesh| said.or_else(|| formats.up_of(mesh.path.as_deref()?));
        let (source_up, target_up) = (up_of(pipeline.source.up, source), up_of(pipeline.target.up, target));
        let settings = PictureSettings { up: pipeline.pictures.up.or(source_up), ..pipeline.pictures };
        let of_source = Self::from(settings);
        if settings.target_up.is_some() {
            return [of_source, Self::of_target(settings)];
        }
        match turn(prepared, map) {
            Some(turn) => [of_source, Self { turn, ..of_source }],
            None => [of_source, Self::of_target(PictureSettings { target_up, ..settings })],
        }
    }
}

/// Returns the rotation that takes the target of the file into the axes of the source, mirrored if the target is a mirror image.
fn turn(prepared: &Prepared, map: Option<&TriangleMap>) -> Option<Matrix3<f64>> {
    let (source, target) = (&prepared.source.surface, prepared.target.seen_surface());
    let markers = prepared.markers();
    let points = if markers.len() >= MIN_MARKERS {
        let on = |surface: &Surface, side: fn(&Marker) -> SurfacePoint| -> Vec<Point3<f64>> {
            markers.iter().map(|marker| side(marker).position(surface, &surface.positions)).collect()
        };
        [on(source, |marker| marker.source), on(target, |marker| marker.target)]
    } else {
        map?.sample(TransferPair { source, target, markers, proximity: None }).ok()?
    };
    let [source, target] = points;
    let turn = Similarity::orient(&target, &source, &vec![1.0; source.len()], Orientation::Auto)?.rotation;
    let axis = prepared.target.mirror_axis();
    let mirror = axis.map(|axis| {
        let mut signs = Vector3::repeat(1.0);
        signs[axis.index()] = -1.0;
        Matrix3::from_diagonal(&signs)
    });
    Some(mirror.map_or(turn, |mirror| turn * mirror))
}
