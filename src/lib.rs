//! mimesh: deformation transfer between triangle meshes, as pipelines of swappable stages.
//!
//! In reading order:
//! - [`core`]: meshes, operators, the stage traits and the registry (crate `mimesh-core`);
//! - [`pipeline`]: what a YAML file declares, how it is read and checked, and how it runs;
//! - [`markers`]: files of corresponding points;
//! - [`page`]: what a run or several look like in a browser;
//! - [`diagnostic`] and [`status`]: how something wrong is told, and with which exit status;
//! - [`mod@bench`]: every method where the result is known;
//! - [`cli`]: the command line, one file a subcommand.
//!
//! A program with its own stages links them and hands over:
//!
//! ```no_run
//! // use my_stages as _;
//! fn main() -> std::process::ExitCode {
//!     mimesh::cli::main()
//! }
//! ```

pub mod bench;
pub mod cli;
pub mod diagnostic;
pub mod markers;
pub mod page;
pub mod pipeline;
pub mod status;
mod text;

pub use mimesh_core as core;
pub use pipeline::Pipeline;

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
    use mimesh_metrics as _;
    use mimesh_proximity as _;
    use mimesh_samplers as _;
    use mimesh_transfers as _;
    use mimesh_weights as _;
}
