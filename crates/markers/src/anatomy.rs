//! The two systems of medical images, between which files and meshes are exchanged: a half turn about z apart.

use std::fmt;

use nalgebra::Point3;

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
