//! Poses that a merge misses.

use mimesh_document::{Diagnostic, Kind};

use super::frames::in_ranges;
use crate::{plan::Plan, text::count};

/// Remedy: compute poses; the argument names them in ranges.
pub const COMPUTE_POSES: &str = "compute_poses";

/// Why `plan` cannot be executed, if it is to take poses from the cache that no part has computed.
pub fn missing_poses(plan: &Plan) -> Option<Diagnostic> {
    let missing = plan.missing();
    if !plan.extent.is_merge() || missing.is_empty() {
        return None;
    }
    let ranges = in_ranges(missing);
    let all = count(plan.order.len(), "pose", "poses");
    let message = format!("{} of {all} not computed: {ranges}", missing.len());
    let diagnostic = Diagnostic::new(Kind::Busy, message);
    let is_exact_motion = plan.order.warm() == 0 && plan.cached.as_ref().is_some_and(|cached| cached.motion);
    Some(match is_exact_motion {
        // Exact frames need all frames before them.
        true => diagnostic.hint("if its parts were computed after warm frames, give their number here too").remedy(
            COMPUTE_POSES,
            in_ranges(plan.order.poses()),
            "compute the motion as a whole",
        ),
        false => diagnostic.remedy(COMPUTE_POSES, ranges, "compute them first"),
    })
}
