//! The options that change a pipeline without its file.

use std::path::PathBuf;

use mimesh_document::diagnostic::Result;
use mimesh_pipeline::Options;

use crate::cli::{absolute_path::absolute, roots::Roots, view_script};

/// The options that change a pipeline without its file.
#[derive(Debug, clap::Args)]
pub struct Overrides {
    /// Replace a value of the file, e.g. transfer.type=gradient; the value is YAML, its paths are relative to the file
    #[arg(long = "set", value_name = "KEY=VALUE")]
    settings: Vec<String>,
    /// Write all results into this folder instead; each of several runs gets a folder of its name in it
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    #[command(flatten)]
    roots: Roots,
}

impl Overrides {
    /// The options as they were given, for another command.
    pub fn arguments(&self) -> Vec<String> {
        let mut arguments = Vec::new();
        let mut add = |option: &str, value: String| arguments.extend([option.to_owned(), value]);
        self.settings.iter().for_each(|setting| add("--set", setting.clone()));
        self.out.iter().for_each(|out| add("--out", out.display().to_string()));
        self.roots.folders().iter().for_each(|folder| add("--root", folder.display().to_string()));
        arguments
    }

    /// The options for a command that may run in another folder.
    ///
    /// # Errors
    ///
    /// A diagnostic for a path that is no Unicode.
    pub fn absolute_arguments(&self) -> Result<Vec<String>> {
        let folders = self.out.iter().map(|out| ("--out", out));
        let roots = self.roots.folders();
        let folders = folders.chain(roots.iter().map(|folder| ("--root", folder)));
        let mut arguments: Vec<String> = self.settings.iter().flat_map(|set| ["--set".into(), set.clone()]).collect();
        for (option, folder) in folders {
            arguments.extend([option.to_owned(), absolute(folder)?]);
        }
        Ok(arguments)
    }

    /// The same as options of the pipeline crate.
    pub fn options(&self) -> Options {
        Options {
            settings: self.settings.clone(),
            out: self.out.clone(),
            roots: self.roots.folders(),
            view_script: view_script(),
            ..Options::default()
        }
    }
}
