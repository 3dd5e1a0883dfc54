//! Stages that are written in Python.
//!
//! Each kind of stage has a type `python` here, which knows the name and the settings of a class and calls an object of it. The class's
//! own name is an alias for that (`mimesh_core::plugin::Alias`).

mod call;
mod clusterer;
mod correspondence;
mod deformer;
mod landmarks;
mod metric;
mod sampler;
mod transfer;
mod weights;
