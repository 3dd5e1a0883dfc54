//! The compiled part of the Python package `mimesh`; its public face is written in Python, in `python/mimesh`.
//!
//! Functions take and give arrays, JSON and objects that own memory of Rust. Whatever takes time lets other threads of Python run
//! meanwhile, and ends soon after Ctrl-C.

mod array;
mod command_line;
mod error;
mod in_memory;
mod job;
mod mesh;
mod picture;
mod pipeline;
mod registry;
mod remedies;
mod save;
mod stage;
mod surface;
mod transfer;
mod work;
mod written;

use pyo3::prelude::*;

/// The compiled part of `mimesh`.
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
