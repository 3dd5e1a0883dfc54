//! Metrics: the error of a result against a known one, and its faults where no result is known.
//!
//! | type | sees | needs |
//! |---|---|---|
//! | [`point_error`](point_error::PointError) | distance of vertices to their known positions | a known result |
//! | [`component_motion`](component_motion::ComponentMotion) | components out of place or turned | a known result |
//! | [`source_motion`](source_motion::SourceMotion) | parts that do not move as the source does | a source |
//! | [`edge_stretch`](edge_stretch::EdgeStretch) | edges that grow or shrink more than the source's | |
//! | [`area_change`](area_change::AreaChange) | the same for triangles | |
//! | [`flipped_triangles`](flipped_triangles::FlippedTriangles) | folds | |
//! | [`volume`](volume::Volume) | swelling, shrinking, turning inside out | |
//! | [`self_intersections`](self_intersections::SelfIntersections) | parts that run into each other | |
//! | [`component_gaps`](component_gaps::ComponentGaps) | components that drift apart | components |
//! | [`contact_slide`](contact_slide::ContactSlide) | feet that slide | frames, a map |
//! | [`jitter`](jitter::Jitter) | trembling | frames |
//! | [`closure`](closure::Closure) | lips and eyelids that do not close | vertices of both |
//! | [`map_tears`](map_tears::MapTears) | a correspondence that jumps | a map |
//! | [`map_collapse`](map_collapse::MapCollapse) | much of the target that follows little of the source | a map |
//! | [`rest_difference`](rest_difference::RestDifference) | rests that stand in other poses | a map |
//! | [`marker_fit`](marker_fit::MarkerFit) | markers in a wrong place, left and right swapped | markers |
//!
//! Two are not measured by default: `closure` needs vertices to be named, and `self_intersections` takes as long as all others
//! together. `docs/metrics.md` has formulas, statistics, limits and blind spots.

pub mod area_change;
pub mod closure;
pub mod component_gaps;
pub mod component_motion;
pub mod contact_slide;
pub mod edge_stretch;
pub mod flipped_triangles;
mod flips;
pub mod jitter;
pub mod map_collapse;
pub mod map_tears;
pub mod marker_fit;
pub mod point_error;
pub mod rest_difference;
pub mod self_intersections;
pub mod source_motion;
pub mod volume;

mod at_rest;
mod component_pairs;
mod component_tears;
mod crossing;
mod diagonal;
mod distribution;
mod elements;
mod motion;
mod size_change;
mod source_pose;
#[cfg(test)]
mod testing;
mod triangle_tree;
mod vertex_field;
