//! Two mesh files on the command line, as a pipeline that leaves all else to the program.

use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

use mimesh_document::{
    Diagnostics, Document, Step,
    diagnostic::{Kind, Location, Result},
    overrides, path, paths,
    source_tree::{SourceSpan, SpanEntry, SpanTree},
};
use mimesh_pipeline::{
    GIVE_MARKERS, Options, Prepared, cache::Cache, check::NAME_POSES, prepare_document, schema::PipelineShapes,
};
use serde_json::{Value, json};

use crate::cli::{help_commands, out_file::OutFile, roots::Roots};

/// A source and a target, and what is known of them.
#[derive(Debug, clap::Args)]
pub struct MeshPair {
    /// The mesh that gives its motion: a file
    source: PathBuf,
    /// The mesh that takes the motion: a file
    target: PathBuf,
    /// The poses of the source: files, or globs in quotes [default: morph targets of SOURCE, else its clip]
    #[arg(long, value_name = "FILE", num_args = 1..)]
    poses: Vec<String>,
    /// A clip that gives the poses, by its name: of SOURCE, or of the file of --poses; "*" stands for all
    #[arg(long, value_name = "NAME")]
    clip: Vec<String>,
    /// A file of corresponding points [default: equal names, else found by shape]
    #[arg(long, value_name = "FILE")]
    markers: Option<PathBuf>,
    /// A file to write, e.g. camel.glb, camel-{pose}.obj or page.html; may be given several times [default: TARGET-from-SOURCE.glb and
    /// .html, beside TARGET]
    #[arg(long, short, value_name = "FILE")]
    output: Vec<String>,
    /// Set any other value of the pipeline, e.g. transfer.type=biharmonic or target.mirrored=x
    #[arg(long = "set", value_name = "KEY=VALUE")]
    settings: Vec<String>,
    /// Let stages run programs that --set names
    #[arg(long)]
    allow_commands: bool,
    #[command(flatten)]
    roots: Roots,
}

/// What reports call a pipeline that no file holds.
const NAME: &str = "transfer";

impl MeshPair {
    /// The pipeline of the two files, checked and with its choices made.
    ///
    /// # Errors
    ///
    /// All that can be found wrong without computing, at the arguments.
    pub fn prepare(&self, cache: Option<&Cache>) -> Result<Vec<Prepared>> {
        let document = self.document()?;
        let options = Options {
            settings: self.settings.clone(),
            runs: vec![],
            roots: self.roots.folders(),
            report: Some(self.report()),
            out: None,
            allow_commands: self.allow_commands,
            help: help_commands::of_meshes(&self.source, &self.target),
            view_script: super::view_script(),
        };
        prepare_document(document, &options, cache).map_err(in_arguments)
    }

    /// The name of the pipeline, for messages.
    pub fn name(&self) -> &'static Path {
        Path::new(NAME)
    }

    /// The names of target and source, `camel-from-horse`.
    pub fn stem(&self) -> String {
        format!("{}-from-{}", paths::stem(&self.target), paths::stem(&self.source))
    }

    /// Refuses to write files of `all` that are there already.
    ///
    /// # Errors
    ///
    /// A diagnostic for the first of them.
    pub fn check_is_new(&self, all: &[Prepared]) -> Result<()> {
        let files = all.iter().flat_map(|prepared| prepared.outputs.files());
        match files.into_iter().find(|file| file.exists()) {
            None => Ok(()),
            Some(file) => {
                let diagnostic = OutFile { option: "--output", file }.diagnostic(Kind::CannotWrite, "exists already");
                Err(diagnostic.hint("name another file with `-o FILE`, or overwrite this one: `--force`").into())
            }
        }
    }

    /// The files to write: those that are named, else one that holds all poses and a page, beside the target.
    fn outputs(&self) -> Vec<String> {
        if !self.output.is_empty() {
            return self.output.clone();
        }
        let extension = self.target.extension().unwrap_or_default().to_string_lossy().to_lowercase();
        let extension = if ["glb", "gltf", "vrm"].contains(&&*extension) { extension } else { "glb".into() };
        let beside = |extension: &str| self.target.with_file_name(format!("{}.{extension}", self.stem()));
        [&*extension, "html"].map(|extension| beside(extension).to_string_lossy().into_owned()).into()
    }

    /// The name of the report: like the first output, for a folder may hold several.
    fn report(&self) -> String {
        let first = self.outputs().into_iter().next().unwrap_or_default();
        match paths::stem(Path::new(&first)).replace("{pose}", "").trim_matches(['-', '_', '.']) {
            "" => "run.json".into(),
            stem => format!("{stem}.run.json"),
        }
    }

    /// The pipeline, each value at its argument.
    fn document(&self) -> Result<Document> {
        let mut document = Document::parse(Path::new(NAME), "{}")?;
        check_is_text("SOURCE", &self.source)?;
        check_is_text("TARGET", &self.target)?;
        self.markers.iter().try_for_each(|markers| check_is_text("--markers", markers))?;
        let file = |file: &Path| Value::from(file.to_string_lossy());
        put(&mut document, &path(["source", "rest"]), file(&self.source), format!("SOURCE {}", self.source.display()))?;
        put(&mut document, &path(["target", "rest"]), file(&self.target), format!("TARGET {}", self.target.display()))?;
        if let Some(poses) = self.poses()? {
            let argument = if self.clip.is_empty() { "--poses" } else { "--clip" };
            let given = if self.clip.is_empty() { &self.poses } else { &self.clip };
            put(&mut document, &path(["source", "poses"]), poses, format!("{argument} {}", given.join(" ")))?;
        }
        if let Some(markers) = &self.markers {
            put(&mut document, &path(["markers"]), file(markers), format!("--markers {}", markers.display()))?;
        }
        let argument = match &self.output[..] {
            [] => "--output".into(),
            given => format!("--output {}", given.join(" ")),
        };
        put(&mut document, &path(["output"]), json!(self.outputs()), argument)?;
        Ok(document)
    }

    /// The poses as a pipeline has them; `None` where they are left to the source.
    fn poses(&self) -> Result<Option<Value>> {
        Ok(match (&self.poses[..], &self.clip[..]) {
            ([], []) => None,
            ([file], []) => Some(json!(file)),
            (files, []) => Some(json!(files)),
            ([], [clip]) => Some(json!({ "clip": clip })),
            ([], clips) => Some(json!({ "clip": clips })),
            ([file], clips) => Some(json!({ "file": file, "clip": clips })),
            (files, _) => {
                let message = format!("{} files with `--clip`, expected one", files.len());
                let location = Location::Argument(format!("--poses {}", files.join(" ")));
                let diagnostic = mimesh_document::Diagnostic::new(Kind::Usage, message).at(location);
                return Err(diagnostic.hint("name the file that holds the clip").into());
            }
        })
    }
}

/// Checks that a path can stand in a pipeline, which is text.
fn check_is_text(argument: &str, path: &Path) -> Result<()> {
    if path.to_str().is_some() {
        return Ok(());
    }
    let message = "the path is no Unicode, and a pipeline is";
    let location = Location::Argument(format!("{argument} {}", path.display()));
    let diagnostic = mimesh_document::Diagnostic::new(Kind::Usage, message).at(location);
    Err(diagnostic.hint("rename the file and its folders, or go into its folder first").into())
}

/// Puts a value into the document, at the argument that gave it.
fn put(document: &mut Document, path: &[Step], value: Value, argument: String) -> Result<()> {
    let span = SourceSpan::Argument(Arc::from(argument));
    let node = SpanTree::leaf(span.clone(), document.root.folder.clone());
    let entry = SpanEntry { step: Step::Index(0), key: span, node };
    let put = overrides::put(document, path, value, entry, &PipelineShapes);
    put.map_err(|problem| mimesh_document::Diagnostic::new(Kind::Internal, problem.message).into())
}

/// The diagnostics of a pipeline with the ways out that the arguments are.
pub fn in_arguments(failure: Diagnostics) -> Diagnostics {
    let list = failure.list.into_iter().map(|mut diagnostic| {
        let words = match diagnostic.remedy.as_ref().map(|remedy| remedy.action) {
            Some(NAME_POSES) => {
                "name its poses: `--poses 'horse-??.obj'`, or a file with a clip: `--poses run.glb --clip Run`"
            }
            Some(GIVE_MARKERS) => "give a file of corresponding points: `--markers FILE`",
            _ => return diagnostic,
        };
        diagnostic.remedy = None;
        diagnostic.hint = Some(match diagnostic.hint {
            Some(hint) => format!("{hint}; {words}"),
            None => words.into(),
        });
        diagnostic
    });
    Diagnostics { list: list.collect() }
}
