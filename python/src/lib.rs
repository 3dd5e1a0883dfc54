//! The compiled part of the Python package `mimesh`; its public face is written in Python, in `python/mimesh`.
//!
//! Functions take and give arrays, JSON and objects that own memory of Rust. Whatever takes time lets other threads of Python run
//! meanwhile, and ends soon after Ctrl-C.
//!
//! Its tests are in Python. A test of Rust would need an interpreter to link with, so that there is nothing here for one
//! (`cargo test --workspace --lib` makes one of every crate).

#[cfg(not(test))]
mod array;
#[cfg(not(test))]
mod command_line;
#[cfg(not(test))]
mod error;
#[cfg(not(test))]
mod in_memory;
#[cfg(not(test))]
mod job;
#[cfg(not(test))]
mod mesh;
#[cfg(not(test))]
mod picture;
#[cfg(not(test))]
mod pipeline;
#[cfg(not(test))]
mod registry;
#[cfg(not(test))]
mod remedies;
#[cfg(not(test))]
mod save;
#[cfg(not(test))]
mod stage;
#[cfg(not(test))]
mod surface;
#[cfg(not(test))]
mod transfer;
#[cfg(not(test))]
mod work;
#[cfg(not(test))]
mod written;

#[cfg(not(test))]
use pyo3::prelude::*;

/// The compiled part of `mimesh`.
#[cfg(not(test))]
#[pymodule(gil_used = false)]
mod _mimesh {
    #[pymodule_export]
    use super::array::View;
    #[pymodule_export]
    use super::command_line::{main, set_identity};
    #[pymodule_export]
    use super::mesh::{MeshData, load};
    #[pymodule_export]
    use super::picture::draw;
    #[pymodule_export]
    use super::pipeline::{check, plan, run};
    #[pymodule_export]
    use super::registry::{register_stage, registry};
    #[pymodule_export]
    use super::stage::{
        BoundData, MapData, bind, check_contract, check_stage, choose, cluster, correspond, fit, generate, link,
        measure, propose, sample, weights,
    };
    #[pymodule_export]
    use super::surface::SurfaceData;
    #[pymodule_export]
    use super::transfer::{TransferData, transfer};
    #[pymodule_export]
    use super::work::discard_all;

    use super::{Bound, PyModule, PyResult};

    #[pymodule_init]
    fn init(_module: &Bound<'_, PyModule>) -> PyResult<()> {
        mimesh::cli::set_memory_limit().map_err(pyo3::exceptions::PyValueError::new_err)
    }
}
