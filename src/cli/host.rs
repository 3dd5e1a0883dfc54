//! The program around the command line: this one, or an interpreter of Python.

use std::{
    ffi::OsString,
    path::{Path, PathBuf},
};

use mimesh_document::{Diagnostic, Kind, Location, diagnostic::Result};

/// The program that the command line is a part of.
#[derive(Clone, Debug)]
pub struct Host {
    /// The arguments; the first is the name of the program.
    pub arguments: Vec<OsString>,
    /// Loads a file of stages written in Python; `None` for a program without an interpreter.
    pub load_python: Option<fn(&Path) -> Result<()>>,
    /// The identity of the program for the cache; `None` for the hash of its own file.
    pub identity: Option<fn() -> Result<String>>,
}

impl Host {
    /// A program of its own, with the arguments of the process.
    pub fn of_process() -> Self {
        Self { arguments: std::env::args_os().collect(), load_python: None, identity: None }
    }

    /// Loads the file of `--python`.
    pub(super) fn load(&self, file: &PathBuf) -> Result<()> {
        let Some(load) = self.load_python else {
            let location = Location::Argument(format!("--python {}", file.display()));
            let message = "this program has no Python, so that it cannot run stages written in it";
            let diagnostic = Diagnostic::new(Kind::Usage, message).at(location);
            return Err(diagnostic.hint("`pip install mimesh` installs a command `mimesh` that can").into());
        };
        load(file)
    }
}
