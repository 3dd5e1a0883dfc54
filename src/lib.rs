//! mimesh: deformation transfer between triangle meshes, as pipelines of swappable stages.
//!
//! The program [`cli`] on top of the crates:
//! - [`core`]: meshes, operators, the stage traits and the registry;
//! - [`document`]: YAML files with the places of their values, and diagnostics;
//! - [`markers`]: files of corresponding points;
//! - [`pipeline`]: what a YAML file declares, how it is checked, and how it runs.
//!
//! A program with its own stages links them and hands over:
//!
//! ```no_run
//! // use my_stages as _;
//! fn main() -> std::process::ExitCode {
//!     mimesh::cli::main()
//! }
//! ```

pub mod cli;

pub use mimesh_core as core;
pub use mimesh_document as document;
pub use mimesh_markers as markers;
pub use mimesh_pipeline as pipeline;

/// Links the stages that mimesh brings itself: a crate that is never named is not linked, and its stages not
/// registered.
#[cfg(feature = "bundled")]
mod bundled {
    use mimesh_clusterers as _;
    use mimesh_correspondences as _;
    use mimesh_deformers as _;
    use mimesh_formats as _;
    use mimesh_generators as _;
    use mimesh_key_points as _;
    use mimesh_landmarks as _;
    use mimesh_metrics as _;
    use mimesh_proximity as _;
    use mimesh_samplers as _;
    use mimesh_transfers as _;
    use mimesh_weights as _;
}
