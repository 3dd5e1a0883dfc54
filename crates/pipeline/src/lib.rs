//! Pipelines: what a YAML file declares, and how it is read, checked, planned, run, measured and reported.
//!
//! A file becomes one [document](mimesh_document::Document) a run ([`compose`]), each document a typed [`Pipeline`] ([`mod@parse`]),
//! and that, with the files it names, something [`Prepared`] ([`check`]). All mistakes are collected until then, and a pipeline
//! with mistakes does not run. A [`Plan`] decides which results of the [`cache`] are used, [`run()`] executes it, and a [`Report`]
//! says what came of it.
//!
//! The crate knows no command line and no terminal: errors carry a [`Kind`](mimesh_document::Kind), ways out that depend on the
//! program around it are [remedies](mimesh_document::Remedy), and progress goes to a [`Progress`].

pub mod axis;
pub mod cache;
pub mod cached_run;
pub mod check;
pub mod choices;
pub mod compose;
mod file_on_disk;
pub mod formats;
pub mod globs;
mod handedness;
pub mod input;
pub mod json;
pub mod key_points;
pub mod marker_source;
pub mod metrics;
mod one_or_many;
pub mod page;
pub mod parse;
pub mod pictures;
pub mod placeholder;
pub mod plan;
pub mod pose_files;
mod pose_units;
pub mod profile;
mod programs;
pub mod progress;
pub mod propose;
pub mod report;
pub mod rest;
mod rest_choice;
mod run;
pub mod schema;
pub mod seam_points;
pub mod shapes;
pub mod shard;
pub mod spec;
pub mod spelled_out;
pub mod staging;
#[cfg(test)]
mod testing;
pub mod text;

pub use check::{
    Options, check_text, prepare_all, prepare_document, prepare_meshes, prepare_posed_meshes, prepare_source,
};
pub use file_on_disk::Reach;
pub use formats::Formats;
pub use input::{Prepared, PreparedSource};
pub use one_or_many::OneOrMany;
pub use plan::Plan;
pub use progress::Progress;
pub use propose::ALLOW_COMMANDS;
pub use report::Report;
pub use run::{Finished, GIVE_MARKERS, prepare_stages, run};
pub use spec::Pipeline;
