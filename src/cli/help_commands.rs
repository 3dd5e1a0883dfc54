//! The commands that the page of a run names.

use std::path::Path;

use mimesh_pipeline::input::HelpCommands;

/// The commands for the pipeline in `file`.
pub fn of_pipeline(file: &Path) -> HelpCommands {
    let file = argument(file);
    HelpCommands {
        check_poses: Some(format!("mimesh check {file} --poses")),
        run_other_transfer: Some(format!("mimesh run {file} --set transfer.type=TYPE --out other")),
        ..of_markers(&format!("--pipeline {file}"))
    }
}

/// The commands for two meshes without a pipeline.
pub fn of_meshes(source: &Path, target: &Path) -> HelpCommands {
    of_markers(&format!("{} {}", argument(source), argument(target)))
}

/// The commands that look for points on `meshes`, and those that need no argument.
fn of_markers(meshes: &str) -> HelpCommands {
    HelpCommands {
        propose_landmarks: Some(format!("mimesh markers propose {meshes} --output clicks.yaml")),
        suggest_marker: Some(format!("mimesh markers suggest {meshes}")),
        list_transfers: Some("mimesh list transfer".into()),
        compare: Some("mimesh compare".into()),
        ..HelpCommands::default()
    }
}

/// A path as an argument in a shell.
pub fn argument(path: &Path) -> String {
    let text = path.display().to_string();
    if text.contains(char::is_whitespace) { format!("'{text}'") } else { text }
}

/// An argument of a shell, in quotes if the shell would change it.
pub fn quoted(argument: &str) -> String {
    let is_plain = |c: char| c.is_alphanumeric() || "._-=/,:…".contains(c);
    if !argument.is_empty() && argument.chars().all(is_plain) { argument.into() } else { in_quotes(argument) }
}

/// A word of a shell that stands for `text` and nothing else.
pub fn in_quotes(text: &str) -> String {
    format!("'{}'", text.replace('\'', r"'\''"))
}
