//! Runs within `strace`, which makes system calls slow, refuses them or kills the run at them.

use std::process::{Command, Stdio};

use crate::common::Project;

/// The run whose results are told apart.
pub fn run_command(project: &Project) -> Command {
    project.command(&["run", "p.yaml", "--no-cache", "--quiet", "--threads", "1"])
}

/// The run, with `strace` and these options of it around.
pub fn traced(project: &Project, options: &[&str]) -> Command {
    let mimesh = run_command(project);
    let mut command = Command::new("strace");
    command.args(["-f", "-qq", "-o", "trace.txt"]).args(options).arg(mimesh.get_program()).args(mimesh.get_args());
    command.current_dir(project.path(".")).stdout(Stdio::null());
    mimesh.get_envs().for_each(|(name, value)| _ = command.env(name, value.unwrap_or_default()));
    command
}
