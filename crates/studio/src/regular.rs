//! Reading regular files: a pipe that lies in a folder would make the server wait, and a device has no end.

use std::{
    io::{self, Read},
    path::Path,
};

use mimesh_document::files::open_regular;

/// The bytes of a regular file.
///
/// # Errors
///
/// Those of the system, and that it is something else.
pub fn read(path: &Path) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    open_regular(path)?.read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// The text of a regular file.
///
/// # Errors
///
/// Those of [`read`], and that it is no UTF-8.
pub fn read_text(path: &Path) -> io::Result<String> {
    String::from_utf8(read(path)?).map_err(|error| io::Error::new(io::ErrorKind::InvalidData, error))
}
