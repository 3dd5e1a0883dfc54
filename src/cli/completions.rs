use clap_complete::Shell;

use super::{Ended, terminal};
use crate::status::Status;

/// Prints completions for a shell.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  mimesh completions bash > ~/.local/share/bash-completion/completions/mimesh")]
pub struct Completions {
    /// The shell
    shell: Shell,
}

impl Completions {
    /// Runs the command; `cli` is the whole command line.
    pub fn run(&self, mut cli: clap::Command) -> Ended {
        let name = cli.get_name().to_owned();
        let mut script = Vec::new();
        clap_complete::generate(self.shell, &mut cli, name, &mut script);
        terminal::print(&String::from_utf8_lossy(&script));
        Ok(Status::Done)
    }
}
