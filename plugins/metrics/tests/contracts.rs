//! Every metric keeps its contract.

use mimesh_core::testkit::contracts::keeps;
use mimesh_metrics as _;

#[test]
fn every_metric_keeps_its_contract() {
    for name in [
        "area_change",
        "closure",
        "component_gaps",
        "component_motion",
        "contact_slide",
        "edge_stretch",
        "flipped_triangles",
        "jitter",
        "map_collapse",
        "map_tears",
        "marker_fit",
        "point_error",
        "rest_difference",
        "self_intersections",
        "source_motion",
        "volume",
    ] {
        keeps("metric", name);
    }
}
