use super::{Ended, terminal};
use crate::{pipeline::compose, status::Status};

/// Prints the JSON Schema of a pipeline, with which editors complete and check YAML.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:
  mimesh schema > mimesh.schema.json
and as the first line of a pipeline
  # yaml-language-server: $schema=mimesh.schema.json")]
pub struct SchemaOf {}

impl SchemaOf {
    /// Runs the command.
    pub fn run(&self) -> Ended {
        terminal::print_json(&compose::schema());
        Ok(Status::Done)
    }
}
