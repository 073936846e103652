//! Compressed views of glTF files (EXT_meshopt_compression), unpacked by meshoptimizer.

use crate::errors::build_error;
use meshopt::ffi;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use std::ffi::{c_int, c_uchar, c_void};

/// Rows of so many bytes at most: the format's own limit.
const MOST_STRIDE: usize = 256;

/// Unpack `count` rows of `stride` bytes.
#[pyfunction]
pub(crate) fn decode_meshopt<'py>(
    py: Python<'py>,
    data: &[u8],
    count: usize,
    stride: usize,
    mode: &str,
    filter: &str,
) -> PyResult<Bound<'py, PyBytes>> {
    let rows = unpacked(data, count, stride, mode, filter).map_err(build_error)?;
    Ok(PyBytes::new(py, &rows))
}

/// The error completes the sentence that begins with the view.
fn unpacked(
    data: &[u8],
    count: usize,
    stride: usize,
    mode: &str,
    filter: &str,
) -> Result<Vec<u8>, String> {
    // The preconditions of the library.
    let is_vertex = mode == "ATTRIBUTES";
    let fits = match mode {
        "ATTRIBUTES" => stride.is_multiple_of(4) && (4..=MOST_STRIDE).contains(&stride),
        "TRIANGLES" => matches!(stride, 2 | 4) && count.is_multiple_of(3),
        "INDICES" => matches!(stride, 2 | 4),
        _ => return Err(format!("has mode {mode:?}, must be ATTRIBUTES, TRIANGLES or INDICES")),
    };
    let filtered: Option<Filter> = match filter {
        "NONE" => None,
        "OCTAHEDRAL" => Some(ffi::meshopt_decodeFilterOct),
        "QUATERNION" => Some(ffi::meshopt_decodeFilterQuat),
        "EXPONENTIAL" => Some(ffi::meshopt_decodeFilterExp),
        "COLOR" => Some(ffi::meshopt_decodeFilterColor),
        _ => return Err(format!("has the unknown filter {filter:?}")),
    };
    let filter_fits = match filter {
        "OCTAHEDRAL" | "COLOR" => is_vertex && matches!(stride, 4 | 8),
        "QUATERNION" => is_vertex && stride == 8,
        _ => is_vertex || filtered.is_none(),
    };
    if !(fits && filter_fits) {
        return Err(format!(
            "has {count} rows of {stride} bytes, which {mode} and {filter} do not have"
        ));
    }
    let size = count.checked_mul(stride).ok_or("is too large")?;
    let mut rows: Vec<u8> = Vec::new();
    rows.try_reserve_exact(size).map_err(|_| format!("needs {size} bytes, which are not there"))?;
    rows.resize(size, 0);

    // SAFETY: the library writes `count` rows of `stride` bytes and reads no further than the
    // data's length, whatever it holds; strides and counts are those that it asks for, and a vector
    // of bytes from the allocator is aligned for words.
    #[allow(
        unsafe_code,
        reason = "the crate's safe functions know the type of a row when it is compiled"
    )]
    let status = unsafe {
        let target = rows.as_mut_ptr().cast::<c_void>();
        let decode: Decoder = match mode {
            "ATTRIBUTES" => ffi::meshopt_decodeVertexBuffer,
            "TRIANGLES" => ffi::meshopt_decodeIndexBuffer,
            _ => ffi::meshopt_decodeIndexSequence,
        };
        let status = decode(target, count, stride, data.as_ptr(), data.len());
        if let Some(filter) = filtered.filter(|_| status == 0) {
            filter(target, count, stride);
        }
        status
    };
    if status == 0 { Ok(rows) } else { Err(format!("holds no {mode} that can be unpacked")) }
}

type Decoder = unsafe extern "C" fn(*mut c_void, usize, usize, *const c_uchar, usize) -> c_int;
type Filter = unsafe extern "C" fn(*mut c_void, usize, usize);
