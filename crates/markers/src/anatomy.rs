//! The two systems of medical images, between which files and meshes are exchanged: a half turn about z apart.

use std::fmt;

use nalgebra::Point3;

use crate::{
    attacher::{Attacher, MAX_DISTANCE, is_too_far},
    points::PointFile,
    unit_axes::UnitAxes,
};

/// Mean distances from the surface below this, relative to the diagonal, say nothing against a system.
const NEAR: f64 = 1e-3;

/// A system is preferred if points lie nearer to the surface in it by this factor.
const CLEARLY_NEARER: f64 = 3.0;

/// The system of positions in a file of 3D Slicer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Anatomy {
    /// X to the left, Y to the back, Z to the head.
    Lps,
    /// X to the right, Y to the front, Z to the head.
    Ras,
}

impl Anatomy {
    /// The other system.
    pub fn other(self) -> Self {
        match self {
            Self::Lps => Self::Ras,
            Self::Ras => Self::Lps,
        }
    }

    /// The position, given in this system, in the other: (−x, −y, z).
    pub fn turned(p: &Point3<f64>) -> Point3<f64> {
        Point3::new(-p.x, -p.y, p.z)
    }
}

impl fmt::Display for Anatomy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Lps => "LPS",
            Self::Ras => "RAS",
        })
    }
}

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
