//! `mimesh list`: the stages and their implementations.

use mimesh_core::plugin;
use mimesh_pipeline::{schema::description, text::pairs};
use serde_json::{Value, json};

use crate::cli::{CommandResult, registry::check_stage, status::Status, terminal};

/// Lists the stages of a pipeline and their implementations.
#[derive(Debug, clap::Args)]
pub struct List {
    /// List the implementations of this stage only, e.g. metric
    stage: Option<String>,
    /// Print the list as JSON
    #[arg(long)]
    json: bool,
}

impl List {
    /// Runs the command.
    pub fn run(&self) -> CommandResult {
        let mut plugins = plugin::all();
        if let Some(stage) = &self.stage {
            check_stage(stage)?;
            plugins.retain(|plugin| plugin.stage == stage);
        }
        if self.json {
            let item = |plugin: &&mimesh_core::Plugin| {
                let description = first_sentence(&description(plugin));
                json!({ "stage": plugin.stage, "type": plugin.name(), "description": description })
            };
            terminal::print_json(&plugins.iter().map(item).collect::<Vec<Value>>());
            return Ok(Status::Done);
        }
        let mut text = String::new();
        for stage in plugins.chunk_by(|a, b| a.stage == b.stage) {
            text += &format!("{}{}\n", if text.is_empty() { "" } else { "\n" }, stage[0].stage);
            let rows = stage.iter().map(|plugin| (plugin.name().to_owned(), first_sentence(&description(plugin))));
            text += &pairs(&rows.collect::<Vec<_>>());
        }
        text += "\n`mimesh show STAGE TYPE` explains the settings of one.\n";
        terminal::print(&text);
        Ok(Status::Done)
    }
}

/// The first sentence of a description, on one line and without its full stop.
fn first_sentence(description: &str) -> String {
    let paragraph = description.split("\n\n").next().unwrap_or_default().replace('\n', " ");
    // A stop after an abbreviation (`et al. 2010`) is not followed by a capital.
    let mut ends = paragraph.match_indices(". ").map(|(i, _)| i);
    let end = ends.find(|i| paragraph[i + 2..].starts_with(|c: char| !c.is_lowercase() && !c.is_numeric()));
    paragraph[..end.unwrap_or(paragraph.len())].trim().trim_end_matches('.').to_owned()
}
