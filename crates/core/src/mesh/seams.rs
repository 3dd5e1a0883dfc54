use nalgebra::Point3;

use super::{Mesh, weld};
use crate::{Error, Result};

/// Vertices of a source part in a pose if their distance grows by more than this, relative to the diagonal.
///
/// Copies of one vertex differ by the rounding of files and quantised formats, which is no opening: a seam torn by it would
/// come apart in the target.
const MIN_OPENING: f64 = 1e-4;

/// The seams of a mesh, and those that have parted in the poses that were shown so far.
#[derive(Clone, Debug)]
pub struct Seams {
    pairs: Vec<[u32; 2]>,
    /// The distance of each pair at rest.
    rest: Vec<f64>,
    has_parted: Vec<bool>,
    min_opening: f64,
    vertex_count: usize,
}

impl Seams {
    /// The seams of `mesh` that are welded for vertices nearer to each other than `tolerance`, relative to the diagonal.
    ///
    /// # Errors
    ///
    /// The errors of [`Mesh::validate`].
    pub fn new(mesh: &Mesh, tolerance: f64) -> Result<Self> {
        mesh.validate()?;
        let (triangles, _) = mesh.polygons.fans();
        let diagonal = mesh.diagonal();
        let edges = weld::edges(&mesh.positions, &triangles, tolerance * diagonal);
        let mut pairs: Vec<[u32; 2]> = edges.into_iter().flatten().filter(|[a, b]| a != b).collect();
        pairs.sort_unstable();
        pairs.dedup();
        let rest = pairs.iter().map(|pair| distance(&mesh.positions, pair)).collect();
        let has_parted = vec![false; pairs.len()];
        let min_opening = MIN_OPENING.max(2.0 * tolerance) * diagonal;
        Ok(Self { pairs, rest, has_parted, min_opening, vertex_count: mesh.positions.len() })
    }

    /// Pairs of vertices of the mesh that are welded, the smaller first, sorted.
    pub fn pairs(&self) -> &[[u32; 2]] {
        &self.pairs
    }

    /// Looks which pairs part when the mesh is at `positions`; nothing of the pose is kept.
    ///
    /// # Errors
    ///
    /// [`Error::Shape`] if `positions` does not have as many entries as the mesh has vertices.
    pub fn see(&mut self, positions: &[Point3<f64>]) -> Result<()> {
        Error::check_shape("vertices", self.vertex_count, positions.len())?;
        for ((pair, rest), has_parted) in self.pairs.iter().zip(&self.rest).zip(&mut self.has_parted) {
            *has_parted |= distance(positions, pair) - rest > self.min_opening;
        }
        Ok(())
    }

    /// What has parted in the poses shown to `self` or to `other`, the same seams.
    pub fn or(mut self, other: Self) -> Self {
        self.has_parted.iter_mut().zip(other.has_parted).for_each(|(one, other)| *one |= other);
        self
    }

    /// The pairs that have parted in any pose, sorted.
    pub fn opened(&self) -> Vec<[u32; 2]> {
        let parted = self.pairs.iter().zip(&self.has_parted).filter(|(_, has_parted)| **has_parted);
        parted.map(|(pair, _)| *pair).collect()
    }
}

fn distance(positions: &[Point3<f64>], [a, b]: &[u32; 2]) -> f64 {
    (positions[*a as usize] - positions[*b as usize]).norm()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        mesh::{Surface, Welding},
        testkit::meshes::{mouth, open_mouth},
    };

    #[test]
    fn what_the_poses_part_is_opened_and_other_seams_are_not() {
        let mesh = mouth(8);
        let mut seams = Seams::new(&mesh, 0.0).unwrap();
        let closed = Surface::new(&mesh).unwrap();
        // The lips from corner to corner, and the split cheek.
        assert_eq!(closed.vertex_count(), mesh.positions.len() - seams.pairs().len());
        seams.see(&mesh.positions).unwrap();
        assert!(seams.opened().is_empty(), "nothing parts at rest");
        let posed = open_mouth(&mesh, 0.2);
        seams.see(&posed).unwrap();
        // A pose in which the lips are closed again takes nothing back.
        seams.see(&mesh.positions).unwrap();
        let opened = seams.opened();
        assert!(!opened.is_empty() && opened.len() < seams.pairs().len());
        assert!(opened.iter().all(|[a, b]| (posed[*a as usize] - posed[*b as usize]).norm() > 0.0));
        let surface = Surface::welded(&mesh, &Welding { opened, ..Welding::default() }).unwrap();
        let back = surface.to_mesh(&surface.from_mesh(&posed).unwrap()).unwrap();
        assert_eq!(back, posed, "nothing of the pose is lost");
        assert_eq!(surface.components().count(), 1, "the mouth opens within one surface");
    }

    #[test]
    fn rounding_opens_nothing() {
        let mesh = mouth(8);
        let mut seams = Seams::new(&mesh, 0.0).unwrap();
        seams.see(&open_mouth(&mesh, 5e-5)).unwrap();
        assert!(seams.opened().is_empty());
        assert!(seams.see(&mesh.positions[1..]).is_err());
    }
}
