//! Images of materials that lie beside the file that names them.

use std::{collections::HashMap, sync::Arc};

use mimesh_core::{Error, mesh::Image, stage::FileInput};

/// No file has more images beside it: the others are not read.
const MAX_IMAGES: usize = 1024;

/// Images beside a file, each read once.
pub struct Beside<'a> {
    input: &'a dyn FileInput,
    known: HashMap<String, Arc<Image>>,
}

impl<'a> Beside<'a> {
    /// Those beside `input`; none is read yet.
    pub fn new(input: &'a dyn FileInput) -> Self {
        Self { input, known: HashMap::new() }
    }

    /// The image `map` of a file in `folder`, as [`beside`] finds it.
    pub fn get(&mut self, folder: &str, map: &str) -> Arc<Image> {
        let key = format!("{folder}{map}");
        if !self.known.contains_key(&key) && self.known.len() == MAX_IMAGES {
            let contents = Err(format!("is not read: there are more than {MAX_IMAGES} images"));
            return Arc::new(Image { name: map.into(), contents });
        }
        self.known.entry(key).or_insert_with(|| Arc::new(beside(self.input, folder, map))).clone()
    }
}

/// The image `map` of a file in `folder`, which is empty or ends with a slash: where it is said to be, or in that folder if that is
/// another machine's path.
fn beside(input: &dyn FileInput, folder: &str, map: &str) -> Image {
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
