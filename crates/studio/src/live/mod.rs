//! Live results: the pose that a page looks at, while markers move.

pub mod preview;
pub mod socket;
