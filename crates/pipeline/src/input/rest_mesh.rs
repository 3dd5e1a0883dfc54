//! One of the two meshes at rest.

use std::path::PathBuf;

use mimesh_core::{
    Error,
    mesh::{MeshSequence, Surface, inward_components},
};
use nalgebra::Point3;

use crate::spec::Axis;

/// One of the two meshes at rest, with its surface.
#[derive(Debug)]
pub struct RestMesh {
    /// Its file; `None` if a generator made it.
    pub path: Option<PathBuf>,
    /// The mesh with the poses and landmarks that come with it.
    pub sequence: MeshSequence,
    /// Its surface, with triangles that point outwards.
    pub surface: Surface,
    /// The components whose triangles point inwards in the file; those of the surface are turned.
    pub inward_components: Vec<u32>,
    /// The mirror image that stages see in place of the surface, and the axis along which it is mirrored.
    mirror_image: Option<(Axis, Surface)>,
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
        let mut surface = Surface::new(&sequence.rest)?;
        let area: f64 = surface.area_normals(&surface.positions).iter().map(|normal| normal.norm()).sum();
        let diagonal = surface.diagonal();
        if area <= MIN_AREA * diagonal * diagonal {
            let shape = if diagonal == 0.0 { "all vertices lie on one point" } else { "all vertices lie on a line" };
            return Err(Error::data(format!("the mesh has no area: {shape}"), "export the mesh again with its shape"));
        }
        let inward_components = inward_components(&surface);
        surface.turn_components(&inward_components);
        Ok(Self { path, surface, sequence, inward_components, mirror_image: None })
    }

    /// Whether all components point inwards in the file.
    pub fn is_inside_out(&self) -> bool {
        self.inward_components.len() == self.surface.components().count()
    }

    /// The same mesh, of which stages see the mirror image along `axis`.
    pub fn mirrored(self, axis: Axis) -> Self {
        Self { mirror_image: Some((axis, self.surface.mirrored(axis.index()))), ..self }
    }

    /// The axis along which stages see it mirrored.
    pub fn mirror_axis(&self) -> Option<Axis> {
        self.mirror_image.as_ref().map(|(axis, _)| *axis)
    }

    /// The surface as stages see it: its mirror image, if that is to be.
    pub fn seen_surface(&self) -> &Surface {
        self.mirror_image.as_ref().map_or(&self.surface, |(_, image)| image)
    }

    /// Positions of the surface from those that a stage gave for the surface that it saw.
    pub fn from_seen(&self, mut positions: Vec<Point3<f64>>) -> Vec<Point3<f64>> {
        if let Some(axis) = self.mirror_axis() {
            positions.iter_mut().for_each(|p| p[axis.index()] = -p[axis.index()]);
        }
        positions
    }
}
