//! Pipelines: what a YAML file declares, and how it is read, checked and run.
//!
//! A file becomes a [`Document`] (values and their places), the document a typed [`Pipeline`] ([`parse`]), the pipeline
//! with the files it names something [`Prepared`] ([`prepare`]), and that a [`Report`] ([`run()`]). Up to `prepare`
//! diagnostics are collected and told together; nothing is computed before there are none. A file that declares several runs
//! becomes a document for each of them first ([`compose`]).

pub mod cache;
pub mod check;
pub mod compose;
pub mod document;
mod formats;
pub mod gates;
mod hash;
pub mod judge;
pub mod key_points;
mod one_or_many;
pub mod overrides;
pub mod parse;
pub mod pictures;
mod places;
pub mod plan;
mod poses;
pub mod process;
mod ranges;
pub mod report;
pub mod resolve;
mod run;
mod shelf;
mod spec;
pub mod staging;
#[cfg(test)]
mod testing;
mod watch;
pub mod words;

pub use check::{Options, Prepared, PreparedSource, prepare, prepare_all, prepare_source};
pub use compose::Variant;
pub use document::{At, Document, Step};
pub use formats::{Formats, Unknown, Writes};
pub use hash::hash_file;
pub use one_or_many::OneOrMany;
pub use poses::spread;
pub use ranges::{choices, described_choices, range, settings_schema};
pub use report::Report;
pub use run::{Outcome, run};
pub use spec::{PictureSettings, Pipeline, Source, Target, Up, ViewFrom};
pub use watch::{Unwatched, Watch};
