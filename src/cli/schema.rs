use schemars::generate::SchemaSettings;

use super::{Ended, terminal};
use crate::{pipeline::Pipeline, status::Status};

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
        let schema = SchemaSettings::draft2020_12().into_generator().into_root_schema_for::<Pipeline>();
        terminal::print_json(&schema);
        Ok(Status::Done)
    }
}
