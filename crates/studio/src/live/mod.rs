//! Live results: the pose that a page looks at, while markers move.
//!
//! In reading order: [`look`], [`pair`], [`preview`], [`measure`], [`frames`], [`result`], [`confidence`], [`frame`], [`page`], [`worker`],
//! [`ahead`], [`socket`].

pub mod ahead;
pub mod confidence;
pub mod frame;
pub mod frames;
pub mod look;
pub mod measure;
pub mod page;
pub mod pair;
pub mod preview;
pub mod result;
pub mod socket;
pub mod worker;
