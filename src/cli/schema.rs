//! `mimesh schema`: the JSON Schema of a pipeline.

use mimesh_pipeline::schema::file_schema;

use crate::cli::{CommandResult, status::Status, terminal};

/// Prints the JSON Schema of a pipeline, which lets editors complete and check YAML.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:
  mimesh schema > mimesh.schema.json
and as the first line of a pipeline
  # yaml-language-server: $schema=mimesh.schema.json")]
pub struct Schema {}

impl Schema {
    /// Runs the command.
    pub fn run(&self) -> CommandResult {
        terminal::print_json(&file_schema());
        Ok(Status::Done)
    }
}
