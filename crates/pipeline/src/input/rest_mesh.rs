//! One of the two meshes at rest.

use std::path::PathBuf;

use mimesh_core::{
    Error,
    mesh::{MeshSequence, Surface},
};

/// One of the two meshes at rest, with its surface.
#[derive(Debug)]
pub struct RestMesh {
    /// Its file; `None` if a generator made it.
    pub path: Option<PathBuf>,
    /// The mesh with the poses and landmarks that come with it.
    pub sequence: MeshSequence,
    /// Its surface.
    pub surface: Surface,
}

/// Areas below this part of the squared diagonal are rounding errors of the positions.
const MIN_AREA: f64 = 1e-12;

impl RestMesh {
    /// The mesh with its surface.
    ///
    /// # Errors
    ///
    /// As [`Surface::new`], and if no triangle has an area.
    pub fn new(path: Option<PathBuf>, sequence: MeshSequence) -> Result<Self, Error> {
        let surface = Surface::new(&sequence.rest)?;
        let area: f64 = surface.area_normals(&surface.positions).iter().map(|normal| normal.norm()).sum();
        let diagonal = surface.diagonal();
        if area <= MIN_AREA * diagonal * diagonal {
            let shape = if diagonal == 0.0 { "all vertices lie on one point" } else { "all vertices lie on a line" };
            return Err(Error::data(format!("the mesh has no area: {shape}"), "export the mesh again with its shape"));
        }
        Ok(Self { path, surface, sequence })
    }

    /// The volume inside, negative if faces point inwards; `None` if the surface is open.
    pub fn volume(&self) -> Option<f64> {
        let surface = &self.surface;
        if !surface.topology().boundary.is_empty() {
            return None;
        }
        let normals = surface.area_normals(&surface.positions);
        let corner = |t: &[u32; 3]| surface.positions[t[0] as usize] - surface.positions[0];
        Some(surface.triangles.iter().zip(&normals).map(|(t, normal)| corner(t).dot(normal) / 6.0).sum())
    }
}
