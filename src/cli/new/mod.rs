use std::{
    fs,
    path::{Path, PathBuf, absolute},
};

use clap::builder::PossibleValuesParser;

use super::{Ended, terminal};
use crate::text::pairs;
use crate::{
    core::plugin,
    diagnostic::{Diagnostic, Kind, Location, Result, io_message, read_text},
    status::Status,
};

mod name;
mod template;

use name::Name;

/// Writes the beginning of something of your own.
#[derive(Debug, clap::Args)]
pub struct New {
    #[command(subcommand)]
    what: What,
}

#[derive(Debug, clap::Subcommand)]
enum What {
    Plugin(NewPlugin),
}

/// Writes a crate with a stage of your own: one that works, its contract test, a pipeline that uses it, and a program that has
/// everything `mimesh` has and the stage.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  mimesh new plugin my-sampler --stage sampler")]
struct NewPlugin {
    /// Name of the crate, and of the stage; words in lower case with - or _ between them
    name: String,
    /// The kind of stage
    #[arg(long, default_value = "transfer", value_parser = PossibleValuesParser::new(template::stages()))]
    stage: String,
    /// Where to write the crate; a folder of its name if left out
    #[arg(long, value_name = "DIR")]
    path: Option<PathBuf>,
    /// The folder of mimesh's source, which the crate is to depend on; the one this program was built from if left out
    #[arg(long, value_name = "DIR")]
    mimesh: Option<PathBuf>,
}

impl New {
    /// Runs the command.
    pub fn run(&self) -> Ended {
        match &self.what {
            What::Plugin(plugin) => plugin.run(),
        }
    }
}

impl NewPlugin {
    fn run(&self) -> Ended {
        let template = template::of(&self.stage);
        let name = Name::new(&self.name).and_then(|name| name.check(template))?;
        let taken = plugin::all().into_iter().any(|p| p.stage == self.stage && (p.name)() == name.snake);
        if taken {
            let message = format!("there is a {} `{}` already", self.stage, name.snake);
            return Err(wrong_name(message, "take another name; `mimesh list` shows those that are taken").into());
        }
        let mimesh = Source::find(self.mimesh.as_deref())?;
        let folder = self.path.clone().unwrap_or_else(|| PathBuf::from(&name.kebab));
        let is_free = fs::read_dir(&folder).map_or(!folder.exists(), |mut entries| entries.next().is_none());
        if !is_free {
            let hint = "nothing is overwritten; give another folder with `--path DIR`";
            return Err(Diagnostic::new(Kind::CannotWrite, "exists already")
                .at(Location::File(folder))
                .hint(hint)
                .into());
        }
        for (file, text) in template.files(&name, &mimesh)? {
            write(&folder.join(file), &text)?;
        }
        let shown = folder.display();
        terminal::print(&format!(
            "wrote {shown}: a crate with the {} `{}`, and a program that has it beside all that mimesh brings\n\n{}",
            self.stage,
            name.snake,
            pairs(&[
                (format!("cd {shown}"), String::new()),
                ("cargo test --release".into(), "holds the stage to its contract".into()),
                (format!("cargo run --release -- show {} {}", self.stage, name.snake), "what it does".into()),
                (format!("cargo run --release -- {} pipeline.yaml", template.command), "uses it".into()),
            ])
        ));
        Ok(Status::Done)
    }
}

/// The folder of mimesh's source.
struct Source {
    folder: PathBuf,
    /// The text of its `Cargo.toml`.
    manifest: String,
    /// The text of its `Cargo.lock`, if there is one: with it a new crate gets the versions that mimesh is tested with.
    lock: Option<String>,
}

impl Source {
    /// Looks in the folder `given`, else in the one that this program was built from.
    fn find(given: Option<&Path>) -> Result<Self> {
        let folder = given.unwrap_or(Path::new(env!("CARGO_MANIFEST_DIR")));
        if !folder.join("crates/core/Cargo.toml").is_file() || !folder.join("src/cli").is_dir() {
            let diagnostic = match given {
                Some(folder) => Diagnostic::new(
                    Kind::MissingInput,
                    "is not the source of mimesh: expected Cargo.toml, crates/core/ and src/",
                )
                .at(Location::File(folder.into()))
                .hint("give the folder that mimesh was cloned into"),
                None => Diagnostic::new(
                    Kind::MissingInput,
                    "the source that this program was built from is not there any more",
                )
                .hint("a new crate depends on it: clone mimesh, and give its folder with `--mimesh DIR`"),
            };
            return Err(diagnostic.into());
        }
        let manifest = read_text(&folder.join("Cargo.toml"))?;
        let lock = fs::read_to_string(folder.join("Cargo.lock")).ok();
        // Relative to where the new crate is written this would be another folder.
        let folder = absolute(folder).unwrap_or_else(|_| folder.into());
        Ok(Self { folder, manifest, lock })
    }

    /// What mimesh asks of a dependency, as the right side of `name = …` in `Cargo.toml`.
    fn dependency(&self, name: &str) -> Option<&str> {
        let table = self.manifest.split("[workspace.dependencies]").nth(1)?;
        table.lines().find_map(|line| line.strip_prefix(name)?.trim_start().strip_prefix('=').map(str::trim))
    }
}

fn wrong_name(message: impl Into<String>, hint: impl Into<String>) -> Diagnostic {
    Diagnostic::new(Kind::Usage, message).at(Location::Option("NAME".into())).hint(hint)
}

fn write(path: &Path, text: &str) -> Result<()> {
    let written = path.parent().map_or(Ok(()), fs::create_dir_all).and_then(|()| fs::write(path, text));
    written.map_err(|error| {
        let diagnostic =
            Diagnostic::new(Kind::CannotWrite, io_message("write", &error)).at(Location::File(path.into()));
        diagnostic.hint("write elsewhere with `--path DIR`").into()
    })
}
