//! Live results: the pose that a page looks at, while markers move.
//!
//! In reading order: [`look`], [`pair`], [`preview`], [`result`], [`confidence`], [`frame`], [`worker`], [`socket`].

pub mod confidence;
pub mod frame;
pub mod look;
pub mod pair;
pub mod preview;
pub mod result;
pub mod socket;
pub mod worker;
