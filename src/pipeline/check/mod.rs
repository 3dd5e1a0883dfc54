//! Everything that can be found wrong with a pipeline before computing, all at once; what remains is ready to run.

mod markers;
mod meshes;
mod outputs;
mod shared;
mod source_only;
mod stages;
mod told;
mod truth;

use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

pub use markers::{Meshes, meshes};
pub use meshes::{PoseFrom, PoseInput, Side, in_file, nearby};
pub use outputs::{Output, Outputs};
pub use source_only::{PreparedSource, prepare_source};
pub use truth::Truth;

use serde_json::Value;

use self::{outputs::Out, shared::Shared, told::Told};
use super::{
    At, Document, Formats, Pipeline, Step, Variant,
    compose::{self, OneRun},
    gates::Gate,
    parse,
    report::{Clock, StageReport},
};
use crate::{
    core::{
        Figures, plugin,
        stage::{Marker, Metric},
    },
    diagnostic::Kind,
    diagnostic::{Diagnostic, Diagnostics, Location, Result},
};

/// What the command line adds to a pipeline's file.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// `slot.key=value`, in the order given.
    pub settings: Vec<String>,
    /// The folder for results, instead of those of the outputs.
    pub out: Option<PathBuf>,
}

/// A pipeline without diagnostics, its rest meshes read.
#[derive(Debug)]
pub struct Prepared {
    /// The pipeline's file.
    pub file: PathBuf,
    /// What tells it from the other runs of the file.
    pub variant: Variant,
    /// The settings, with those of the command line; paths of stages are relative to the current folder.
    pub pipeline: Pipeline,
    /// The formats, with the pipeline's settings.
    pub formats: Formats,
    /// What gives its motion; runs of one file share it.
    pub source: Arc<Side>,
    /// What takes it; combinations of one matrix share it.
    pub target: Arc<Side>,
    /// The poses of the source, at least one.
    pub poses: Vec<PoseInput>,
    /// Pairs of points of the two surfaces.
    pub markers: Vec<Marker>,
    /// The known results.
    pub truth: Truth,
    /// What is measured of every pose.
    pub metrics: Vec<Box<dyn Metric>>,
    /// The most that figures may be.
    pub gates: Vec<Gate>,
    /// What is written.
    pub outputs: Outputs,
    /// Every file that is read.
    pub inputs: Vec<Input>,
    /// Sentences about what looks wrong or was left out.
    pub warnings: Vec<String>,
    /// What reading and checking took.
    pub reading: StageReport,
}

/// A file that a run reads.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Input {
    /// What it is, e.g. `source rest`.
    pub role: &'static str,
    /// The file.
    pub path: PathBuf,
}

/// Reads and checks the pipeline in `file`, which declares a single run.
///
/// # Errors
///
/// All diagnostics that can be found without computing or reading poses, and that there are several runs.
pub fn prepare(file: &Path, options: &Options) -> Result<Prepared> {
    let mut all = prepare_all(file, options)?;
    match (all.pop(), all.len()) {
        (Some(one), 0) => Ok(one),
        (_, others) => {
            let message = format!("the pipeline declares {} runs, expected one", others + 1);
            let hint = "name one target, and set `matrix` to nothing: `--set matrix=`";
            Err(Diagnostic::new(Kind::BadPipeline, message).at(Location::File(file.into())).hint(hint).into())
        }
    }
}

/// Reads and checks the pipeline in `file`, for every target and every combination of its matrix; at least one run.
///
/// # Errors
///
/// All diagnostics of all runs that can be found without computing or reading poses, each once.
pub fn prepare_all(file: &Path, options: &Options) -> Result<Vec<Prepared>> {
    let mut clock = Clock::start();
    let compose::Runs { runs, included, diagnostics, left, warnings } = compose::compose(file, &options.settings)?;
    let several = runs.len() > 1;
    let mut told = Told::new(&runs, diagnostics, left);
    let mut shared = Shared::default();
    let mut prepared = Vec::new();
    for (i, run) in runs.into_iter().enumerate() {
        match one(file, &included, run, options, several, &mut shared) {
            Ok(one) => prepared.push(Prepared { reading: clock.stop("reading", "", Figures::default()), ..one }),
            Err(failure) => told.add(i, failure.diagnostics),
        }
        clock = Clock::start();
    }
    if told.is_empty() {
        told.add_all(outputs::apart(&mut prepared));
    }
    told.end(file)?;
    // Warnings of the file as a whole are those of its first run.
    if let Some(first) = prepared.first_mut() {
        first.warnings.splice(0..0, warnings);
    }
    Ok(prepared)
}

/// Checks one run.
fn one(
    file: &Path,
    included: &[PathBuf],
    run: OneRun,
    options: &Options,
    several: bool,
    shared: &mut Shared,
) -> Result<Prepared> {
    let clock = Clock::start();
    let OneRun { variant, document } = run;
    let (mut pipeline, diagnostics) = parse::parse(&document);
    let mut check = Check {
        document: &document,
        formats: Formats::new(std::mem::take(&mut pipeline.formats)),
        inputs: files(file, included),
        diagnostics,
        warnings: vec![],
    };
    check.registry();
    check.format_settings();
    let (source, poses) = shared.source(&mut check, &pipeline.source);
    let target = shared.target(&mut check, &pipeline.target);
    let (source, target) = (source.as_ref(), target.as_ref());
    check.inside_out(source.map(Arc::as_ref), target.map(Arc::as_ref));
    let markers = check.markers(pipeline.markers.as_ref(), source.map(Arc::as_ref), target.map(Arc::as_ref));
    let truth = check.truth(pipeline.truth.as_deref(), target.map(Arc::as_ref), &poses);
    let metrics = check.metrics(pipeline.metrics.take(), &truth);
    let gates = check.gates(&pipeline.gates, &metrics, &truth);
    if let (Some(source), Some(target), Some(markers)) = (source, target, &markers) {
        check.bound_metrics(&metrics, source, target, markers);
    }
    check.stages(&mut pipeline, source.map(Arc::as_ref), target.map(Arc::as_ref), markers.as_deref());
    let out = options
        .out
        .as_deref()
        .map(|typed| Out { typed, folder: if several { typed.join(&variant.name) } else { typed.into() } });
    let outputs = check.outputs(&pipeline, &poses, out.as_ref());
    if !check.diagnostics.is_empty() {
        return Err(Diagnostics { diagnostics: check.diagnostics });
    }
    let (Some(source), Some(target), Some(markers)) = (source, target, markers) else {
        return Err(Diagnostic::new(Kind::Internal, "a mesh was refused without a reason").into());
    };
    Ok(Prepared {
        file: file.into(),
        variant,
        formats: check.formats,
        inputs: check.inputs,
        warnings: check.warnings,
        reading: clock.stop("reading", "", Figures::default()),
        source: source.clone(),
        target: target.clone(),
        pipeline,
        poses,
        markers,
        truth,
        metrics,
        gates,
        outputs,
    })
}

/// The files that say what to run.
fn files(file: &Path, included: &[PathBuf]) -> Vec<Input> {
    let included = included.iter().map(|path| Input { role: "included pipeline", path: path.clone() });
    std::iter::once(Input { role: "pipeline", path: file.into() }).chain(included).collect()
}

/// A check on its way.
struct Check<'a> {
    document: &'a Document,
    formats: Formats,
    inputs: Vec<Input>,
    diagnostics: Vec<Diagnostic>,
    warnings: Vec<String>,
}

impl Check<'_> {
    /// All diagnostics in the order of the file, if there are any.
    fn end(&mut self, file: &Path) -> Result<()> {
        Told::of_one(std::mem::take(&mut self.diagnostics)).end(file)
    }

    /// The path at `at`, as seen from the current folder: it begins at the folder of the file that says it.
    fn path(&self, at: &[Step], path: &Path) -> PathBuf {
        super::resolve::from_base(self.document.folder(at), path)
    }

    /// Whether what a stage says of a setting has been said of its place already.
    fn has_told(&self, error: &crate::core::Error) -> bool {
        let error = error.to_string();
        let quoted = error.split_once(": ").map(|(setting, told)| format!("`{setting}`: {told}"));
        quoted.is_some_and(|quoted| self.diagnostics.iter().any(|diagnostic| diagnostic.message == quoted))
    }

    fn wrong(&mut self, path: &[Step], at: At, message: impl Into<String>, hint: impl Into<String>) {
        self.diagnostics.push(self.document.diagnostic(path, at, message).hint(hint));
    }

    fn missing(&mut self, path: &[Step], message: impl Into<String>, hint: impl Into<String>) {
        let diagnostic = self.document.diagnostic(path, At::Value, message).hint(hint);
        self.diagnostics.push(Diagnostic { kind: Kind::MissingInput, ..diagnostic });
    }

    /// Notes that `path` is read; false, and a diagnostic at `at`, if there is no such file.
    fn input(&mut self, role: &'static str, path: &Path, at: &[Step]) -> bool {
        if path.is_file() {
            self.inputs.push(Input { role, path: path.into() });
            return true;
        }
        if path.is_dir() {
            let hint = "name a file in it; `*.obj` in quotes stands for all of a kind";
            self.missing(at, format!("{} is a folder, expected a file", path.display()), hint);
        } else {
            let hint = super::resolve::similar_file(path)
                .unwrap_or_else(|| "paths are relative to the folder of the pipeline's file".into());
            self.missing(at, format!("no such file: {}", path.display()), hint);
        }
        false
    }

    /// Texts without contents where a path belongs: the value at `path`, or items of the list there.
    fn empty_texts(&mut self, path: &[Step]) {
        let Some(value) = path.iter().try_fold(&self.document.value, |value, step| step.get(value)) else { return };
        let mut empty = Vec::new();
        match value {
            Value::String(text) if text.is_empty() => empty.push(path.to_vec()),
            Value::Array(list) => {
                let items = list.iter().enumerate().filter(|(_, item)| item.as_str() == Some(""));
                empty.extend(items.map(|(i, _)| [path, &[Step::Index(i)]].concat()));
            }
            _ => {}
        }
        for path in empty {
            self.wrong(&path, At::Value, "expected a path, found an empty text", "name a file, or remove it");
        }
    }

    /// Two plug-ins of one stage and name, which no YAML can tell apart.
    fn registry(&mut self) {
        for pair in plugin::all().windows(2) {
            let (stage, name) = (pair[0].stage, (pair[0].name)());
            if stage == pair[1].stage && name == (pair[1].name)() {
                let message = format!("two plug-ins are linked that are both the {stage} `{name}`");
                let hint = "rename the type of one of them, or leave its crate out";
                self.diagnostics.push(Diagnostic::new(Kind::Internal, message).hint(hint));
            }
        }
    }

    /// Two entries of `formats` for one type.
    fn format_settings(&mut self) {
        let document = self.document;
        let list = document.value.get("formats").and_then(Value::as_array);
        let types: Vec<_> = list.into_iter().flatten().map(|format| format.get("type").cloned()).collect();
        for (i, name) in types.iter().enumerate() {
            if name.is_some() && types[..i].contains(name) {
                let path = super::document::path(["formats", &i.to_string(), "type"]);
                self.wrong(&path, At::Value, "a second entry for this format", "put all its settings into one entry");
            }
        }
    }
}
