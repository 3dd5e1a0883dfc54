//! Images of materials that lie beside the file that names them.

use mimesh_core::{Error, mesh::Image, stage::FileInput};

/// The image `map` of a file in `folder`, which is empty or ends with a slash: where it is said to be, or in that folder if that is
/// another machine's path.
pub fn beside(input: &dyn FileInput, folder: &str, map: &str) -> Image {
    let slashes = map.replace('\\', "/");
    let file = slashes.rsplit('/').next().unwrap_or(map);
    let mut tries = [format!("{folder}{map}"), format!("{folder}{slashes}"), format!("{folder}{file}")].into_iter();
    let first = tries.next().map_or_else(|| Err(String::new()), |name| input.referenced(&name).map_err(|e| reason(&e)));
    let contents = tries.fold(first, |found, name| found.or_else(|error| input.referenced(&name).map_err(|_| error)));
    Image { name: file.into(), contents }
}

/// Why a file that another one names could not be opened.
pub fn reason(error: &Error) -> String {
    match error {
        Error::Io { source, .. } => format!("cannot be read ({source})"),
        Error::OutOfReach { reason, .. } => format!("is not opened, {reason}"),
        other => format!("cannot be read ({other})"),
    }
}
