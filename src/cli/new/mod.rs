//! `mimesh new`: a crate with a stage of your own, or a pipeline for two meshes, to begin with.

use std::{
    fs,
    path::{Path, PathBuf},
};

use mimesh_core::plugin;
use mimesh_document::{
    diagnostic::{Diagnostic, Kind, Location, Result},
    files::io_message,
};
use mimesh_pipeline::text::pairs;

use crate::cli::{CommandResult, status::Status, terminal};

mod kind;
mod name;
mod pipeline;
mod source;
mod template;

use kind::KindParser;
use name::Name;
use source::Source;
use template::Template;

/// Writes a crate with a stage of your own, or a pipeline for two meshes, to begin with.
#[derive(Debug, clap::Args)]
pub struct New {
    #[command(subcommand)]
    item: Item,
}

#[derive(Debug, clap::Subcommand)]
enum Item {
    Plugin(NewPlugin),
    Pipeline(pipeline::NewPipeline),
}

/// Writes a crate with a stage of your own.
///
/// The crate has a stage that works, its contract test and a pipeline that uses it. Its program has everything that
/// `mimesh` has, and the stage.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  mimesh new plugin my-sampler --stage sampler")]
struct NewPlugin {
    /// The name of the crate and of the stage: words in lower case with - or _ between them
    name: String,
    /// The kind of stage
    #[arg(long, default_value = "transfer", value_parser = KindParser)]
    stage: String,
    /// Write the crate into this folder [default: a folder of its name]
    #[arg(long, value_name = "DIR")]
    path: Option<PathBuf>,
    /// Depend on the source of mimesh in this folder [default: the source that this program was built from]
    #[arg(long, value_name = "DIR")]
    mimesh: Option<PathBuf>,
}

impl New {
    /// Runs the command.
    pub fn run(&self) -> CommandResult {
        match &self.item {
            Item::Plugin(plugin) => plugin.run(),
            Item::Pipeline(pipeline) => pipeline.run(),
        }
    }
}

impl NewPlugin {
    fn run(&self) -> CommandResult {
        let name = Name::new(&self.name)?;
        let mimesh = Source::find(self.mimesh.as_deref())?;
        let template = Template::read(&self.stage, &mimesh)?;
        let name = name.check(&template)?;
        let is_taken = |plugin: &plugin::Plugin| plugin.stage == self.stage && plugin.name() == name.snake;
        if plugin::all().into_iter().any(is_taken) {
            let message = format!("there is a {} `{}` already", self.stage, name.snake);
            return Err(wrong_name(message, "choose another name; `mimesh list` shows those in use").into());
        }
        let folder = self.path.clone().unwrap_or_else(|| PathBuf::from(&name.kebab));
        check_is_free(&folder)?;
        for (file, text) in template.files(&name, &mimesh)? {
            write(&folder.join(file), &text)?;
        }
        let shown = folder.display();
        terminal::print(&format!(
            "wrote {shown}: a crate with the {} `{}`, and a program that has the stage and everything of mimesh\n\n{}",
            self.stage,
            name.snake,
            pairs(&[
                (format!("cd {shown}"), String::new()),
                ("cargo test --release".into(), "tests the contract of the stage".into()),
                (format!("cargo run --release -- show {} {}", self.stage, name.snake), "shows its settings".into()),
                (format!("cargo run --release -- {} pipeline.yaml", template.command()), "uses it".into()),
            ])
        ));
        Ok(Status::Done)
    }
}

/// Checks that `folder` does not exist, or is empty.
fn check_is_free(folder: &Path) -> Result<()> {
    let is_free = fs::read_dir(folder).map_or(!folder.exists(), |mut entries| entries.next().is_none());
    if is_free {
        return Ok(());
    }
    let diagnostic = Diagnostic::new(Kind::CannotWrite, "exists already").at(Location::File(folder.into()));
    Err(diagnostic.hint("nothing is overwritten; give another folder with `--path DIR`").into())
}

fn wrong_name(message: impl Into<String>, hint: impl Into<String>) -> Diagnostic {
    Diagnostic::new(Kind::Usage, message).at(Location::Argument("NAME".into())).hint(hint)
}

fn write(path: &Path, text: &str) -> Result<()> {
    let written = path.parent().map_or(Ok(()), fs::create_dir_all).and_then(|()| fs::write(path, text));
    written.map_err(|error| {
        let message = io_message("write", &error);
        let diagnostic = Diagnostic::new(Kind::CannotWrite, message).at(Location::File(path.into()));
        diagnostic.hint("write elsewhere with `--path DIR`").into()
    })
}
