//! `mimesh studio`: the page in the browser.

use std::path::PathBuf;

use mimesh_document::diagnostic::{Diagnostic, Kind, Location};
use mimesh_pipeline::staging;
use mimesh_studio::{Server, Start, StudioOptions};

use crate::cli::{CommandResult, cache::CacheOptions, help_commands, roots::Roots, status::Status, terminal};

/// Opens a page in the browser: look at both meshes, correct a few points, and watch the target move.
///
/// Points are saved at every click, into a file that the pipeline then names. Two meshes become a pipeline beside the target. Without
/// files the page lists the current folder and those of --root. The command runs until it is interrupted.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  mimesh studio horse.glb camel.obj
  mimesh studio horse-to-camel.yaml
  mimesh studio --root ../data")]
pub struct StudioCommand {
    /// A pipeline's YAML file, or the source mesh and the target mesh
    #[arg(value_name = "PIPELINE | SOURCE TARGET", num_args = 0..=2)]
    files: Vec<PathBuf>,
    #[command(flatten)]
    roots: Roots,
    /// Listen on this port [default: any that is free]
    #[arg(long, value_name = "N", default_value_t = 0, hide_default_value = true)]
    port: u16,
    /// Listen on this address or name, which others may reach
    #[arg(long, value_name = "HOST", default_value = "127.0.0.1")]
    host: String,
    /// Print the URL, and open no browser
    #[arg(long)]
    no_open: bool,
    /// Let stages run programs that the pipeline names
    #[arg(long)]
    allow_commands: bool,
    #[command(flatten)]
    cache: CacheOptions,
}

impl StudioCommand {
    /// Runs the command.
    pub fn run(&self) -> CommandResult {
        if !mimesh_web::has_studio() {
            let message = "the page is not part of this program: it was not built before the program";
            return Err(Diagnostic::new(Kind::Usage, message).hint(mimesh_web::HOW_TO_BUILD).into());
        }
        let start = match &self.files[..] {
            [] => None,
            [pipeline] if is_yaml(pipeline) => Some(Start::Pipeline(pipeline.clone())),
            [mesh] => {
                let message = "expected a pipeline, or a source mesh and a target mesh";
                let at = Location::Argument(mesh.display().to_string());
                return Err(Diagnostic::new(Kind::Usage, message).at(at).hint("name the target too").into());
            }
            [source, target, ..] => Some(Start::Pair(source.clone(), target.clone())),
        };
        let server = Server::new(StudioOptions {
            start,
            folder: ".".into(),
            roots: self.roots.folders(),
            host: self.host.clone(),
            port: self.port,
            allow_commands: self.allow_commands,
            cache: self.cache.open()?,
            help: help_commands::of_pipeline,
        })?;
        if !server.is_local() {
            terminal::warn(
                "others can reach this server: who has the URL can read and write your files, and what is sent can be read on the way",
            );
        }
        let url = server.url();
        terminal::print(&format!("{url}\n"));
        if !self.no_open && open::that_detached(&url).is_err() {
            terminal::warn("no browser could be opened: open the URL yourself");
        }
        // Without a handler an interrupt would leave uploads, and files that are half written.
        let scratch = server.scratch().to_owned();
        let _ = ctrlc::set_handler(move || {
            let _ = std::fs::remove_dir_all(&scratch);
            staging::discard_all_and_exit(Status::Interrupted as u8)
        });
        server.run()?;
        Ok(Status::Done)
    }
}

fn is_yaml(file: &std::path::Path) -> bool {
    file.extension().is_some_and(|extension| ["yaml", "yml"].contains(&&*extension.to_string_lossy().to_lowercase()))
}
