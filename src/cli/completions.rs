//! `mimesh completions`: completions of the command line for a shell.

use clap_complete::Shell;

use crate::cli::{CommandResult, status::Status, terminal};

/// Prints completions for a shell.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  mimesh completions bash > ~/.local/share/bash-completion/completions/mimesh")]
pub struct Completions {
    /// The shell to complete in
    shell: Shell,
}

impl Completions {
    /// Runs the command; `cli` is the definition of the whole command line.
    pub fn run(&self, mut cli: clap::Command) -> CommandResult {
        let name = cli.get_name().to_owned();
        let mut script = Vec::new();
        clap_complete::generate(self.shell, &mut cli, name, &mut script);
        terminal::print(&String::from_utf8_lossy(&script));
        Ok(Status::Done)
    }
}
