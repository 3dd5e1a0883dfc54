use serde_json::{Value, json};

use super::{Ended, show::known_stage, terminal};
use crate::text::pairs;
use crate::{
    core::{Plugin, plugin},
    pipeline::settings_schema,
    status::Status,
};

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
    pub fn run(&self) -> Ended {
        let mut plugins = plugin::all();
        if let Some(stage) = &self.stage {
            known_stage(stage)?;
            plugins.retain(|plugin| plugin.stage == stage);
        }
        if self.json {
            let item = |plugin: &&Plugin| {
                let description = first_line(&description(plugin));
                json!({ "stage": plugin.stage, "type": (plugin.name)(), "description": description })
            };
            terminal::print_json(&plugins.iter().map(item).collect::<Vec<Value>>());
            return Ok(Status::Done);
        }
        let mut text = String::new();
        for stage in plugins.chunk_by(|a, b| a.stage == b.stage) {
            text += &format!("{}{}\n", if text.is_empty() { "" } else { "\n" }, stage[0].stage);
            let rows = stage.iter().map(|plugin| ((plugin.name)().to_owned(), first_line(&description(plugin))));
            text += &pairs(&rows.collect::<Vec<_>>());
        }
        text += "\n`mimesh show STAGE TYPE` tells the settings of one.\n";
        terminal::print(&text);
        Ok(Status::Done)
    }
}

/// The doc comment of an implementation.
pub fn description(plugin: &Plugin) -> String {
    settings_schema(plugin).get("description").and_then(Value::as_str).unwrap_or_default().to_owned()
}

/// The first sentence, on one line.
fn first_line(description: &str) -> String {
    let paragraph = description.split("\n\n").next().unwrap_or_default().replace('\n', " ");
    // A stop after an abbreviation (`et al. 2010`) is not followed by a capital.
    let ends = paragraph.match_indices(". ").map(|(i, _)| i);
    let end = ends.into_iter().find(|i| paragraph[i + 2..].starts_with(|c: char| !c.is_lowercase() && !c.is_numeric()));
    paragraph[..end.unwrap_or(paragraph.len())].trim().trim_end_matches('.').to_owned()
}
