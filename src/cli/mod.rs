//! The command line: one file a subcommand. What is computed goes to stdout, everything else to stderr.

mod bench_quality;
mod cache;
mod check;
mod compare;
mod completions;
mod components;
mod inspect;
mod keypoints;
mod list;
mod markers;
mod new;
mod plan;
mod progress;
mod render;
mod run;
mod schema;
mod score;
mod show;
mod summary;
mod terminal;

use std::process::ExitCode;

use clap::{CommandFactory, Parser, Subcommand};

use crate::{diagnostic, status::Status};

/// Deformation transfer between triangle meshes: a target takes the poses of a source, as a YAML pipeline declares.
#[derive(Debug, Parser)]
#[command(
    name = "mimesh",
    version,
    max_term_width = 100,
    after_help = "Examples:
  mimesh run pipelines/gallop.yaml        made animals, nothing to download
  mimesh check horse-to-camel.yaml        find diagnostics without computing
  mimesh show transfer gradient           settings of a stage

Exit status: 0 done, 1 internal error, 2 usage, 3 a quality gate failed, 4 partly done, 65 bad data,
66 input missing, 73 cannot write, 78 bad pipeline, 130 interrupted."
)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Run(run::Run),
    Check(check::Check),
    Plan(plan::PlanRun),
    #[command(name = "keypoints")]
    KeyPoints(keypoints::KeyPoints),
    Markers(markers::Markers),
    List(list::List),
    Show(show::Show),
    Schema(schema::SchemaOf),
    Inspect(inspect::Inspect),
    Score(score::Score),
    Compare(compare::Compare),
    Render(render::Render),
    BenchQuality(bench_quality::BenchQuality),
    Cache(cache::ShowCache),
    New(new::New),
    Completions(completions::Completions),
}

/// Runs the command line of this process and gives its exit status.
///
/// A program with its own stages calls this too; it has every command, and its own stages beside those that are
/// bundled.
pub fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => {
            let _ = error.print();
            return if error.use_stderr() { Status::Usage } else { Status::Done }.into();
        }
    };
    let result = match cli.command {
        Command::Run(command) => command.run(),
        Command::Check(command) => command.run(),
        Command::Plan(command) => command.run(),
        Command::KeyPoints(command) => command.run(),
        Command::Markers(command) => command.run(),
        Command::List(command) => command.run(),
        Command::Show(command) => command.run(),
        Command::Schema(command) => command.run(),
        Command::Inspect(command) => command.run(),
        Command::Score(command) => command.run(),
        Command::Compare(command) => command.run(),
        Command::Render(command) => command.run(),
        Command::BenchQuality(command) => command.run(),
        Command::Cache(command) => command.run(),
        Command::New(command) => command.run(),
        Command::Completions(command) => command.run(Cli::command()),
    };
    match result {
        Ok(status) => status.into(),
        Err(failure) => {
            terminal::tell(&failure);
            Status::from(failure.kind()).into()
        }
    }
}

/// What a command ends with.
type Ended = diagnostic::Result<Status>;
