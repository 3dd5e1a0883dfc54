//! The command line: one file for each subcommand. Results go to stdout, everything else to stderr.

mod absolute_path;
mod cache;
mod check;
mod choice;
mod compare;
mod completions;
mod components;
mod flags;
mod help_commands;
mod host;
mod inspect;
mod keypoints;
mod list;
mod markers;
mod memory;
mod merge;
mod mesh_pair;
mod new;
mod openjd_progress;
mod out_file;
mod overrides;
mod plan;
mod posed_meshes;
mod prepare;
mod profile;
mod progress;
mod registry;
mod render;
mod results_file;
mod roots;
mod run;
mod saved_pipeline;
mod schema;
mod score;
mod shard_options;
mod show;
mod signals;
mod status;
#[cfg(feature = "studio")]
mod studio;
mod submit;
mod summary;
mod terminal;
mod transfer;

use std::{path::PathBuf, process::ExitCode};

use clap::{CommandFactory, Parser, Subcommand, error::ErrorKind};
use mimesh_document::{Diagnostic, Kind, diagnostic};
use mimesh_pipeline::input::ViewScript;

pub use self::{host::Host, memory::set_from_environment as set_memory_limit};
use crate::cli::status::Status;

/// Deformation transfer between triangle meshes: a target takes the poses of a source.
#[derive(Debug, Parser)]
#[command(
    name = "mimesh",
    version,
    max_term_width = 100,
    after_help = "Examples:
  mimesh transfer horse.glb camel.obj     two files in, motion out
  mimesh run pipelines/gallop.yaml        generated animals, nothing to download
  mimesh check horse-to-camel.yaml        find errors without computing
  mimesh show transfer gradient           settings of a stage

Exit status: 0 done, 1 internal error, 2 usage, 3 a quality gate failed, 4 partly done, 65 bad data,
66 input missing, 71 not enough memory, 73 cannot write, 75 not now: another process writes the same files or computes
the same result, or poses to merge are missing, 78 bad pipeline, 130 interrupted."
)]
struct Cli {
    /// The most memory to take, e.g. 8G: work that needs more is refused with a number [default: what the machine has]
    #[arg(long, global = true, value_name = "SIZE", env = memory::VARIABLE, hide_env_values = true, value_parser = memory::size)]
    memory: Option<u64>,
    /// A file of stages written in Python, which pipelines may then name; no pipeline can ask for it
    #[arg(long, global = true, value_name = "FILE")]
    python: Vec<PathBuf>,
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Transfer(transfer::TransferCommand),
    #[cfg(feature = "studio")]
    #[command(name = "studio")]
    Studio(studio::StudioCommand),
    Run(run::Run),
    Check(check::Check),
    Plan(plan::PlanCommand),
    Prepare(prepare::Prepare),
    Merge(merge::MergeCommand),
    Submit(submit::Submit),
    #[command(name = "keypoints")]
    KeyPoints(keypoints::KeyPoints),
    Markers(markers::Markers),
    List(list::List),
    Show(show::Show),
    Schema(schema::Schema),
    Inspect(inspect::Inspect),
    Score(score::Score),
    Compare(compare::Compare),
    Render(render::Render),
    Cache(cache::CacheCommand),
    New(new::New),
    Completions(completions::Completions),
}

/// Which argument is no Unicode; only names of files may be none.
fn not_unicode(host: &Host) -> Diagnostic {
    let arguments = host.arguments.iter().skip(1).filter(|argument| argument.to_str().is_none());
    let mut named: Vec<String> = arguments.map(|argument| format!("`{}`", argument.to_string_lossy())).collect();
    if named.is_empty() {
        named.push(format!("the environment variable {}", memory::VARIABLE));
    }
    let message = format!("{}: expected Unicode", named.join(" or "));
    Diagnostic::new(Kind::Usage, message).hint("give it another name, or go to its folder and name it from there")
}

/// Runs the command line of this process and returns its exit status.
///
/// A program with its own stages calls this function too. It gets every command, and its own stages beside the
/// bundled ones.
pub fn main() -> ExitCode {
    ExitCode::from(run(&Host::of_process()))
}

/// Runs the command line for `host` and returns its exit status.
pub fn run(host: &Host) -> u8 {
    signals::hold_file_size_limit();
    cache::set_identity(host.identity);
    ended_with(run_command(host)) as u8
}

/// The status of the command that the arguments of `host` name.
fn run_command(host: &Host) -> Status {
    let cli = match Cli::try_parse_from(&host.arguments) {
        Ok(cli) => cli,
        Err(error) if error.kind() == ErrorKind::InvalidUtf8 => {
            terminal::report_one(&not_unicode(host));
            return Status::Usage;
        }
        Err(error) => {
            let printed = error.print();
            if error.use_stderr() {
                return Status::Usage;
            }
            // Help and version go to stdout.
            terminal::note(printed);
            return Status::Done;
        }
    };
    memory::set(cli.memory);
    let result = cli.python.iter().try_for_each(|file| host.load(file)).and_then(|()| match cli.command {
        Command::Transfer(command) => command.run(),
        #[cfg(feature = "studio")]
        Command::Studio(command) => command.run(),
        Command::Run(command) => command.run(),
        Command::Check(command) => command.run(),
        Command::Plan(command) => command.run(),
        Command::Prepare(command) => command.run(),
        Command::Merge(command) => command.run(),
        Command::Submit(command) => command.run(),
        Command::KeyPoints(command) => command.run(),
        Command::Markers(command) => command.run(),
        Command::List(command) => command.run(),
        Command::Show(command) => command.run(),
        Command::Schema(command) => command.run(),
        Command::Inspect(command) => command.run(),
        Command::Score(command) => command.run(),
        Command::Compare(command) => command.run(),
        Command::Render(command) => command.run(),
        Command::Cache(command) => command.run(),
        Command::New(command) => command.run(),
        Command::Completions(command) => command.run(Cli::command()),
    });
    match result {
        Ok(status) => status,
        Err(failure) => {
            terminal::report(&failure);
            failure.kind().into()
        }
    }
}

/// The status of a command that ends with `status`: what it could not print comes first, since nobody can know the result.
fn ended_with(status: Status) -> Status {
    match terminal::unprinted() {
        Some(diagnostic) => {
            terminal::report_one(&diagnostic);
            diagnostic.kind.into()
        }
        None => status,
    }
}

/// The exit status of a command, or the diagnostics that stopped it.
type CommandResult = diagnostic::Result<Status>;

/// The script of the 3D view that reports may have.
pub fn view_script() -> ViewScript {
    ViewScript { text: mimesh_web::report_viewer(), hint: mimesh_web::HOW_TO_BUILD.into() }
}
