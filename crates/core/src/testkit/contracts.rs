//! The contracts of stages, as checks that hold any implementation to them; they panic with the name and what is wrong.
//!
//! mimesh runs them over its whole registry; a plug-in runs them on its own stages the same way.

pub use super::{
    clusterer::clusterer,
    correspondence::correspondence,
    deformer::deformer,
    format::format,
    generator::generator,
    key_points::key_points,
    landmarks::landmarks,
    metric::metric,
    proximity::proximity,
    registered::{described, keeps, round_trips},
    sampler::sampler,
    transfer::transfer,
    weights::weights,
};
