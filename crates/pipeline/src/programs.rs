//! Programs that stages run.

use std::{
    env,
    path::{Path, PathBuf},
};

/// The file of a program: where its path leads, or else the first of the name in the folders that the system searches.
pub fn program_file(program: &str) -> Option<PathBuf> {
    let path = Path::new(program);
    if path.components().count() > 1 {
        return path.is_file().then(|| path.into());
    }
    env::split_paths(&env::var_os("PATH")?).map(|folder| folder.join(program)).find(|file| file.is_file())
}
