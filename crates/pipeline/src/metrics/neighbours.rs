//! What a plan and its run have to know alike of how poses are measured.

use mimesh_core::mesh::PosesAre;

use crate::input::Prepared;

/// The number of poses before one that its measurements may look at.
pub const MEASURED_BEFORE: usize = 2;

/// Whether each pose is measured without those before it.
pub fn are_measured_alone(prepared: &Prepared) -> bool {
    prepared.poses_are == PosesAre::Shapes
}
