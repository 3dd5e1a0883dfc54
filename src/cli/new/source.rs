//! The folder of mimesh's source, which a new crate depends on.

use std::{
    fs,
    path::{Path, PathBuf, absolute},
};

use mimesh_document::{
    diagnostic::{Diagnostic, Kind, Location, Result},
    files::read_text,
};

/// The folder of mimesh's source.
pub struct Source {
    /// The folder as an absolute path.
    pub folder: PathBuf,
    /// The text of its `Cargo.lock`, if there is one: with it a new crate gets the versions that mimesh is tested with.
    pub lock: Option<String>,
    /// The text of its `Cargo.toml`.
    manifest: String,
}

impl Source {
    /// Takes the folder `given`, else the one that this program was built from.
    ///
    /// # Errors
    ///
    /// A diagnostic if the folder is not mimesh's source.
    pub fn find(given: Option<&Path>) -> Result<Self> {
        let folder = given.unwrap_or(Self::of_program());
        if !folder.join("crates/core/Cargo.toml").is_file() || !folder.join("src/cli").is_dir() {
            return Err(not_found(given).into());
        }
        let manifest = read_text(&folder.join("Cargo.toml"))?;
        let lock = fs::read_to_string(folder.join("Cargo.lock")).ok();
        // A relative path would mean another folder in the manifest of the new crate.
        let folder = absolute(folder).unwrap_or_else(|_| folder.into());
        Ok(Self { folder, manifest, lock })
    }

    /// The folder that this program was built from.
    pub fn of_program() -> &'static Path {
        Path::new(env!("CARGO_MANIFEST_DIR"))
    }

    /// The right side of `name = …` among mimesh's dependencies in `Cargo.toml`.
    pub fn dependency(&self, name: &str) -> Option<&str> {
        let table = self.manifest.split("[workspace.dependencies]").nth(1)?;
        table.lines().find_map(|line| line.strip_prefix(name)?.trim_start().strip_prefix('=').map(str::trim))
    }
}

fn not_found(given: Option<&Path>) -> Diagnostic {
    match given {
        Some(folder) => {
            let message = "is not the source of mimesh: expected Cargo.toml, crates/core/ and src/";
            let diagnostic = Diagnostic::new(Kind::MissingInput, message).at(Location::File(folder.into()));
            diagnostic.hint("give the folder that mimesh was cloned into")
        }
        None => {
            let message = "the source that this program was built from is not there any more";
            let hint = "a new crate depends on it: clone mimesh, and give its folder with `--mimesh DIR`";
            Diagnostic::new(Kind::MissingInput, message).hint(hint)
        }
    }
}
