//! Where the time of a run went, by the spans of [`tracing`] that the pipeline and its stages emit.
//!
//! A [`Profile`] records spans while its [`Recorder`] is a layer of the subscriber of the program. It gives a tree of
//! [`Row`]s, and a trace in the Trace Event format, which ui.perfetto.dev and chrome://tracing open.
//!
//! The label of a span is its name, with its field `type` in brackets: `correspondence (nonrigid_fit)`. Its field `count` is the number
//! of things that it stands for. All other fields are in the trace only. Spans of level `INFO` are stages, of which one runs at a time.
//!
//! Work that is handed to other threads has its span's parent given explicitly. A thread that waits may do such work of another
//! span meanwhile. That counts for the other span only.

mod frames;
mod recorder;
mod spans;
mod trace;
mod tree;

pub use recorder::{Profile, Recorder};
pub use tree::Row;
