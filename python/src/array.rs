//! Slices of Rust memory -> read-only numpy arrays that share it.
//!
//! Uses the array interface protocol: an object tells address, shape and type, and numpy makes a view that keeps the
//! object alive. It needs neither numpy's C interface nor unsafe code here.

use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use std::any::Any;
use std::sync::Arc;
use trimtess::glam::{DVec3, Vec2, Vec3};

/// Memory that numpy views share. Alive as long as one of them.
#[pyclass(frozen, weakref, module = "trimtess._trimtess")]
pub(crate) struct Buffer {
    /// Owns the memory, and never changes it.
    _owner: Arc<dyn Any + Send + Sync>,
    address: usize,
    rows: usize,
    /// Numbers per row; `None` for an array of one dimension.
    columns: Option<usize>,
    type_code: &'static str,
}

#[pymethods]
impl Buffer {
    /// The description that numpy reads: the protocol's version 3.
    #[getter]
    fn __array_interface__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let shape = match self.columns {
            Some(columns) => PyTuple::new(py, [self.rows, columns])?,
            None => PyTuple::new(py, [self.rows])?,
        };
        let interface = PyDict::new(py);
        interface.set_item("version", 3)?;
        interface.set_item("shape", shape)?;
        interface.set_item("typestr", self.type_code)?;
        // The second value: read-only.
        interface.set_item("data", (self.address, true))?;
        Ok(interface)
    }
}

/// A row of an array: numbers of one type without padding.
pub(crate) trait Row: Copy + Send + Sync + 'static {
    /// Numbers per row; `None` for scalars.
    const COLUMNS: Option<usize>;
    /// numpy's code for the type of a number: its kind and size in bytes.
    const TYPE: &'static str;
}

/// Implements [`Row`] and checks that rows have no padding.
macro_rules! rows {
    ($($row:ty: $columns:expr, $number:ty, $kind:literal;)*) => {
        $(
            impl Row for $row {
                const COLUMNS: Option<usize> = $columns;
                #[cfg(target_endian = "little")]
                const TYPE: &'static str = concat!("<", $kind);
                #[cfg(target_endian = "big")]
                const TYPE: &'static str = concat!(">", $kind);
            }
            const _: () = {
                let columns = match $columns { Some(columns) => columns, None => 1 };
                assert!(size_of::<$row>() == size_of::<$number>() * columns);
            };
        )*
    };
}

rows! {
    DVec3: Some(3), f64, "f8";
    Vec3: Some(3), f32, "f4";
    Vec2: Some(2), f32, "f4";
    [u32; 3]: Some(3), u32, "u4";
    u8: None, u8, "u1";
    u32: None, u32, "u4";
    u64: None, u64, "u8";
}

/// A numpy view of `rows`, which `owner` owns and never changes.
pub(crate) fn view<'py, T: Row>(
    py: Python<'py>,
    owner: &Arc<impl Any + Send + Sync>,
    rows: &[T],
) -> PyResult<Bound<'py, PyAny>> {
    let owner: Arc<dyn Any + Send + Sync> = owner.clone();
    let buffer = Buffer {
        _owner: owner,
        address: rows.as_ptr() as usize,
        rows: rows.len(),
        columns: T::COLUMNS,
        type_code: T::TYPE,
    };
    py.import("numpy")?.call_method1("asarray", (Bound::new(py, buffer)?,))
}

/// A (4, 4) array of doubles: a transform that multiplies columns (x, y, z, 1).
pub(crate) fn matrix<'py>(py: Python<'py>, transform: &trimtess::glam::DAffine3) -> PyResult<Bound<'py, PyAny>> {
    let rows = trimtess::glam::DMat4::from(*transform).transpose().to_cols_array_2d();
    let array = py.import("numpy")?.call_method1("array", (rows,))?;
    array.call_method1("setflags", (false,))?;
    Ok(array)
}
