//! Results in another unit or axes than the target.

use mimesh_core::{mesh::Mesh, spatial::UnitAxes};
use nalgebra::{Point3, Vector3};

/// The change of unit and axes between the target and results in files of bare numbers.
#[derive(Clone, Debug)]
pub struct OutputChange {
    change: UnitAxes,
    rest: Mesh,
}

impl OutputChange {
    /// The change of a target that is `rest` at rest.
    pub fn new(change: UnitAxes, rest: &Mesh) -> Self {
        let mut rest = rest.clone();
        rest.positions.iter_mut().for_each(|p| *p = change.apply(p));
        let normals = rest.normals.iter_mut().flat_map(|normals| &mut normals.values);
        normals.for_each(|normal| *normal = change.turn(&Vector3::from(*normal)).into());
        Self { change, rest }
    }

    /// The target at rest after the change; its normals are turned along.
    pub fn rest(&self) -> &Mesh {
        &self.rest
    }

    /// `positions` of the target (#V × 3) after the change.
    pub fn positions(&self, positions: &[Point3<f64>]) -> Vec<Point3<f64>> {
        positions.iter().map(|p| self.change.apply(p)).collect()
    }
}
