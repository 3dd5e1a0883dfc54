//! The files of a job.

/// A file that is written for an engine.
#[derive(Debug)]
pub struct JobFile {
    /// Its name in the folder of the job.
    pub name: &'static str,
    /// What it holds.
    pub text: String,
    /// Whether it is a script to be run.
    pub is_script: bool,
}

impl JobFile {
    /// A file that engines read.
    pub fn data(name: &'static str, text: String) -> Self {
        Self { name, text, is_script: false }
    }

    /// A script.
    pub fn script(name: &'static str, text: String) -> Self {
        Self { name, text, is_script: true }
    }
}
