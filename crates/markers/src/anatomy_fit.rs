//! In which system of medical images points lie on their mesh.

use crate::{
    attacher::{Attacher, MAX_DISTANCE, is_too_far},
    points::PointFile,
    unit_axes::UnitAxes,
};

/// Mean distances from the surface below this, relative to the diagonal, say nothing against a system.
const NEAR: f64 = 1e-3;

/// A system is preferred if points lie nearer to the surface in it by this factor.
const CLEARLY_NEARER: f64 = 3.0;

/// The system in which the points of a file are taken to lie on a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fit {
    /// That of the file.
    AsWritten,
    /// The other one.
    Turned,
    /// The points lie on the mesh alike in both, at different places.
    Either,
    /// Most points lie off the mesh in both.
    Neither,
}

/// In which system the points of `file` lie on the mesh.
pub fn fit(file: &PointFile, attacher: &Attacher<'_>) -> Fit {
    let positions = file.positions_in_space();
    let [written, turned] = [UnitAxes::IDENTITY, UnitAxes::HALF_TURN].map(|unit_axes| {
        let attached = positions.iter().map(|position| attacher.attach(&unit_axes.apply(position)));
        attached.collect::<Vec<_>>()
    });
    let count = positions.len();
    let far = [&written, &turned].map(|all| all.iter().filter(|attached| is_too_far(attached.distance)).count());
    let fits = far.map(|far| 2 * far < count);
    match fits {
        [false, false] => return Fit::Neither,
        [true, false] => return Fit::AsWritten,
        [false, true] => return Fit::Turned,
        [true, true] => {}
    }
    // A few strays must not decide, so that no distance counts for more than one that is refused.
    let capped = |distance: f64| if is_too_far(distance) { MAX_DISTANCE } else { distance };
    let means = [&written, &turned]
        .map(|all| all.iter().map(|attached| capped(attached.distance)).sum::<f64>() / count.max(1) as f64);
    let clearly = |a: usize, b: usize| means[b] > NEAR && means[b] > CLEARLY_NEARER * means[a];
    let place = |point| attacher.mesh.position(point);
    let same = written.iter().zip(&turned).all(|(a, b)| match (place(a.point), place(b.point)) {
        (Some(a), Some(b)) => (a - b).norm() <= NEAR * attacher.diagonal,
        _ => false,
    });
    match (clearly(0, 1), clearly(1, 0)) {
        (true, _) => Fit::AsWritten,
        (_, true) => Fit::Turned,
        _ if same => Fit::AsWritten,
        _ => Fit::Either,
    }
}
