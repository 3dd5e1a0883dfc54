//! One of the two meshes at rest.

use std::path::PathBuf;

use mimesh_core::{
    Error,
    mesh::{Mesh, MeshSequence, Seams, Surface, Welding, inward_components},
    spatial::UnitAxes,
    stage::Selection,
};
use nalgebra::Point3;

use crate::axis::Axis;

/// One of the two meshes at rest, with its surface.
#[derive(Debug)]
pub struct RestMesh {
    /// Its file; `None` if a generator made it.
    pub path: Option<PathBuf>,
    /// The part of the file that is read.
    pub selection: Selection,
    /// The mesh with the poses and landmarks that come with it.
    pub sequence: MeshSequence,
    /// Its surface, with triangles that point outwards.
    pub surface: Surface,
    /// The components whose triangles point inwards in the file; those of the surface are turned.
    pub inward_components: Vec<u32>,
    /// The mirror image that stages see in place of the surface, and the axis along which it is mirrored.
    mirror_image: Option<(Axis, Surface)>,
    /// How its seams are welded.
    pub welding: Welding,
    /// The change that takes files of poses into the unit and axes of the mesh.
    pub poses_change: UnitAxes,
    /// The mesh as its file has it at rest, with its surface, where a pose serves as the rest. Points in files of markers lie on it.
    pub of_file: Option<(Mesh, Surface)>,
}

/// Areas below this part of the squared diagonal are rounding errors of the positions.
const MIN_AREA: f64 = 1e-12;

impl RestMesh {
    /// The mesh with its surface.
    ///
    /// # Errors
    ///
    /// As [`Surface::new`], and if no triangle has an area.
    pub fn new(
        path: Option<PathBuf>,
        selection: Selection,
        sequence: MeshSequence,
        welding: Welding,
    ) -> Result<Self, Error> {
        let (surface, inward_components) = outward_surface(&sequence.rest, &welding)?;
        let area: f64 = surface.area_normals(&surface.positions).iter().map(|normal| normal.norm()).sum();
        let diagonal = surface.diagonal();
        if area <= MIN_AREA * diagonal * diagonal {
            let shape = if diagonal == 0.0 { "all vertices lie on one point" } else { "all vertices lie on a line" };
            return Err(Error::data(format!("the mesh has no area: {shape}"), "export the mesh again with its shape"));
        }
        Ok(Self {
            path,
            selection,
            surface,
            sequence,
            inward_components,
            mirror_image: None,
            welding,
            poses_change: UnitAxes::IDENTITY,
            of_file: None,
        })
    }

    /// The mesh with the pose at `positions` (#V of the file) as its rest.
    ///
    /// # Errors
    ///
    /// Those of [`new`](Self::new).
    pub fn resting_at(self, positions: Vec<Point3<f64>>) -> Result<Self, Error> {
        let Self { path, selection, mut sequence, surface, welding, poses_change, .. } = self;
        let posed = Mesh { positions, ..sequence.rest.clone() };
        let at_rest = std::mem::replace(&mut sequence.rest, posed);
        Ok(Self { poses_change, of_file: Some((at_rest, surface)), ..Self::new(path, selection, sequence, welding)? })
    }

    /// The seams of the mesh, opened or not.
    ///
    /// # Errors
    ///
    /// Those of [`Seams::new`].
    pub fn seams(&self) -> Result<Seams, Error> {
        Seams::new(&self.sequence.rest, self.welding.tolerance)
    }

    /// Whether the surface has fewer vertices than the faces of the file: some are welded.
    pub fn has_seams(&self) -> bool {
        self.surface.vertex_count() + self.surface.strays.len() < self.sequence.rest.positions.len()
    }

    /// Opens the seams between pairs of vertices of the file, sorted and the smaller first, and no others.
    ///
    /// # Errors
    ///
    /// Those of [`Surface::welded`].
    pub fn open_seams(&mut self, opened: Vec<[u32; 2]>) -> Result<(), Error> {
        if self.welding.opened == opened {
            return Ok(());
        }
        self.welding.opened = opened;
        (self.surface, self.inward_components) = outward_surface(&self.sequence.rest, &self.welding)?;
        if let Some((axis, image)) = &mut self.mirror_image {
            *image = self.surface.mirrored(axis.index());
        }
        Ok(())
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

    /// The positions of a pose as its file has them (#V × 3), in the unit and axes of the mesh.
    pub fn in_own_units(&self, mut positions: Vec<Point3<f64>>) -> Vec<Point3<f64>> {
        if self.poses_change != UnitAxes::IDENTITY {
            positions.iter_mut().for_each(|p| *p = self.poses_change.apply(p));
        }
        positions
    }

    /// Positions of the surface as stages see it, from those of the file's, or the other way round.
    pub fn mirrored_positions(&self, mut positions: Vec<Point3<f64>>) -> Vec<Point3<f64>> {
        if let Some(axis) = self.mirror_axis() {
            positions.iter_mut().for_each(|p| p[axis.index()] = -p[axis.index()]);
        }
        positions
    }
}

/// The surface of `mesh` with all triangles outwards, and the components that were turned.
fn outward_surface(mesh: &Mesh, welding: &Welding) -> Result<(Surface, Vec<u32>), Error> {
    let mut surface = Surface::welded(mesh, welding)?;
    let inward = inward_components(&surface);
    surface.turn_components(&inward);
    Ok((surface, inward))
}
