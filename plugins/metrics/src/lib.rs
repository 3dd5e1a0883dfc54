//! Metrics: how far a result is from what it should be, and what is wrong with it where that is not known.
//!
//! | type | sees | needs |
//! |---|---|---|
//! | [`point_error`](point_error::PointError) | distance of vertices to where they should be | the truth |
//! | [`component_motion`](component_motion::ComponentMotion) | components out of place or turned | the truth |
//! | [`edge_stretch`](edge_stretch::EdgeStretch) | edges longer or shorter than the source's motion makes them | |
//! | [`area_change`](area_change::AreaChange) | the same of triangle areas | |
//! | [`flipped_triangles`](flipped_triangles::FlippedTriangles) | folds | |
//! | [`volume`](volume::Volume) | swelling, shrinking, turning inside out | |
//! | [`self_intersections`](self_intersections::SelfIntersections) | parts that run into each other | |
//! | [`component_gaps`](component_gaps::ComponentGaps) | components that drift apart | components |
//! | [`contact_slide`](contact_slide::ContactSlide) | feet that slide | frames, a map |
//! | [`jitter`](jitter::Jitter) | trembling | frames |
//! | [`closure`](closure::Closure) | lips and eyelids that do not close | vertices of both |
//! | [`map_tears`](map_tears::MapTears) | a correspondence that jumps | a map |
//! | [`marker_fit`](marker_fit::MarkerFit) | markers in a wrong place, left and right swapped | markers |
//!
//! All are measured by default but `closure`, which needs vertices to be named, and `self_intersections`, which takes as long as all
//! others together. `docs/metrics.md` tells formulas, limits and what each misses.

pub mod area_change;
pub mod closure;
pub mod component_gaps;
pub mod component_motion;
pub mod contact_slide;
pub mod edge_stretch;
pub mod flipped_triangles;
pub mod jitter;
pub mod map_tears;
pub mod marker_fit;
pub mod point_error;
pub mod self_intersections;
pub mod volume;

mod change;
mod crossing;
mod elements;
mod linked;
mod size;
mod spread;
#[cfg(test)]
mod testing;
mod triangle_tree;
