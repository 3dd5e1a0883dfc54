//! Mutated files for every reader, and judges of what they give.
//!
//! A [`Target`] takes bytes and says whether its reader kept its promises: no panic, errors that name the file and a way out, finite
//! numbers, indices in range, and what is written is read again as it was. [`limits`] adds that it takes little time and memory.
//! [`mutate`] makes bytes out of others. The corpus beside this crate is replayed by an ordinary test, and [`session`] fuzzes for hours.

// The stages register themselves where their crate is linked.
use mimesh as _;

mod bytes;
pub mod corpus;
mod judge;
pub mod limits;
pub mod mutate;
mod others;
pub mod session;
pub mod target;
mod tree;

pub use target::{Target, targets};
