//! The option for folders whose files meshes may open.

use std::path::PathBuf;

use mimesh_pipeline::{Formats, Reach};

/// Folders whose files meshes may open.
#[derive(Clone, Debug, Default, clap::Args)]
pub struct Roots {
    /// Let meshes refer to files in this folder too, beside their own and that of the pipeline; may be given several times
    #[arg(long = "root", value_name = "DIR")]
    folders: Vec<PathBuf>,
}

impl Roots {
    /// The folders.
    pub fn folders(&self) -> Vec<PathBuf> {
        self.folders.clone()
    }

    /// All formats with their default settings, for meshes that no pipeline names.
    pub fn formats(&self) -> Formats {
        Formats::new(vec![], Reach::new(&self.folders))
    }
}
