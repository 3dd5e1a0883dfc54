//! The stages that are linked, called one by one.

mod bound;
mod calls;
mod map;
mod settings;

pub use bound::{BoundData, bind};
pub use calls::{choose, cluster, fit, generate, link, measure, propose, sample, weights};
pub use map::{MapData, correspond};
pub use settings::{check_contract, check_stage};
