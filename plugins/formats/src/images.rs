//! Images of materials that lie beside the file that names them.

use std::{collections::HashMap, path::PathBuf, sync::Arc};

use mimesh_core::{Error, mesh::Image, stage::FileInput};

use crate::paths::resolved;

/// No file has more images beside it: the others are not read.
const MAX_IMAGES: usize = 1024;

/// Images beside a file, each read once.
pub struct Beside<'a> {
    input: &'a dyn FileInput,
    known: HashMap<String, Arc<Image>>,
    /// Those that were found, by their files: two names may be of one.
    found: HashMap<PathBuf, Arc<Image>>,
}

impl<'a> Beside<'a> {
    /// Those beside `input`; none is read yet.
    pub fn new(input: &'a dyn FileInput) -> Self {
        Self { input, known: HashMap::new(), found: HashMap::new() }
    }

    /// The image `map` of a file in `folder`.
    pub fn get(&mut self, folder: &str, map: &str) -> Arc<Image> {
        let key = format!("{folder}{map}");
        if !self.known.contains_key(&key) && self.known.len() == MAX_IMAGES {
            let contents = Err(format!("is not read: there are more than {MAX_IMAGES} images"));
            return Arc::new(Image { name: map.into(), contents });
        }
        let image = match self.known.get(&key) {
            Some(known) => known.clone(),
            None => self.beside(folder, map),
        };
        self.known.insert(key, image.clone());
        image
    }

    /// The image `map` of a file in `folder`, which is empty or ends with a slash: where it is said to be, or in that folder if that
    /// is another machine's path.
    fn beside(&mut self, folder: &str, map: &str) -> Arc<Image> {
        let slashes = map.replace('\\', "/");
        let file = slashes.rsplit('/').next().unwrap_or(map);
        let mut problem = None;
        for name in [format!("{folder}{map}"), format!("{folder}{slashes}"), format!("{folder}{file}")] {
            let path = resolved(&self.input.path_of(&name));
            if let Some(found) = self.found.get(&path) {
                return found.clone();
            }
            match self.input.referenced(&name) {
                Ok(contents) => {
                    let image = Arc::new(Image { name: file.into(), contents: Ok(contents) });
                    self.found.insert(path, image.clone());
                    return image;
                }
                // What is told is why it is not where it is said to be.
                Err(error) => _ = problem.get_or_insert_with(|| reason(&error)),
            }
        }
        Arc::new(Image { name: file.into(), contents: Err(problem.unwrap_or_default()) })
    }
}

/// Why a file that another one names could not be opened.
pub fn reason(error: &Error) -> String {
    match error {
        Error::Io { source, .. } => format!("cannot be read ({source})"),
        Error::OutOfReach { reason, .. } => format!("is not opened, {reason}"),
        other => format!("cannot be read ({other})"),
    }
}
