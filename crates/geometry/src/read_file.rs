//! Reading of user files.

use std::io::{Error, Read, Result};
use std::path::Path;

/// The largest file that is read [bytes].
const MOST_BYTES: u64 = 1 << 31;

/// The bytes of a regular file of at most 2 GiB: devices and pipes may never end.
///
/// # Errors
/// If there is no such file, or it is no regular one, or too large: in words that follow
/// "cannot be read".
pub fn read_file(path: &Path) -> Result<Vec<u8>> {
    let status = std::fs::metadata(path)?;
    if !status.is_file() {
        return Err(Error::other("it is a folder, a device or a pipe, must be a regular file"));
    }
    if status.len() > MOST_BYTES {
        return Err(Error::other(format!(
            "it has {} bytes, must have at most {MOST_BYTES}",
            status.len()
        )));
    }
    let mut bytes = Vec::new();
    std::fs::File::open(path)?.take(MOST_BYTES).read_to_end(&mut bytes)?;
    Ok(bytes)
}
