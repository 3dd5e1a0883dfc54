//! Stages of one's own, as a stranger to mimesh writes them: a sampler, weights and a transfer.
//!
//! Each is a struct of settings with the trait of its stage; `register!` makes it known, and from then on `list`, `show`,
//! `schema`, `check` and `run` of a program that links this crate know it and its doc comments. `main.rs` is that program:
//!
//! ```sh
//! cargo run --release -p own-plugin -- list
//! cargo run --release -p own-plugin -- show weights inverse_distance
//! cargo run --release -p own-plugin -- run examples/own-plugin/pipeline.yaml
//! ```
//!
//! `tests/contracts.rs` holds all three to the contracts of their stages. docs/adding-a-stage.md tells how to begin a crate
//! like this one outside of this repository: `mimesh new plugin NAME`.

pub mod curvature;
pub mod exaggerate;
pub mod inverse_distance;
