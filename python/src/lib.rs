//! The Python package `trimtess`: the library's stages as objects, meshes as numpy arrays without copies.
//!
//! Everything that takes time runs on a thread of its own without the interpreter's lock ([`job`]); arrays are views of
//! memory that a Rust object keeps alive ([`array`]); errors are exceptions with fields ([`errors`]).

mod array;

mod errors;

mod job;

mod diagnostic;

mod model;

mod read;

mod flat;

mod check;

mod save;

mod mesh;

#[cfg(feature = "wgpu")]
mod picture;

mod view;

mod attributes;

mod session;

mod prepared;

use pyo3::prelude::*;

/// The threads of a cancelled call free what others made, which takes longer with the system's (decision 041).
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

/// The compiled half of `trimtess`. `trimtess/__init__.py` shows what is public.
#[pymodule]
fn _trimtess(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_function(wrap_pyfunction!(read::read, module)?)?;
    module.add_class::<array::Buffer>()?;
    module.add_class::<diagnostic::Diagnostic>()?;
    module.add_class::<model::Model>()?;
    module.add_class::<model::Part>()?;
    module.add_class::<model::Face>()?;
    module.add_class::<model::Edge>()?;
    module.add_class::<model::Instance>()?;
    module.add_class::<prepared::Prepared>()?;
    module.add_class::<view::View>()?;
    module.add_class::<attributes::Attributes>()?;
    module.add_class::<session::Session>()?;
    module.add_class::<session::Frame>()?;
    module.add_class::<session::Tile>()?;
    module.add_class::<mesh::Mesh>()?;
    module.add_class::<mesh::MeshPart>()?;
    module.add_class::<flat::Flat>()?;
    module.add_class::<check::Check>()?;
    module.add_class::<check::PartCheck>()?;
    module.add_class::<check::Deviation>()?;
    module.add_class::<check::Spread>()?;
    module.add_class::<save::Saved>()?;
    Ok(())
}
