//! Everything that can be found wrong with a pipeline before computing, all at once; what remains is ready to run.

mod markers;
mod meshes;
mod outputs;
mod source_only;
mod stages;
mod truth;

use std::path::{Path, PathBuf};

pub use meshes::{PoseFrom, PoseInput, Side, in_file, nearby};
pub use outputs::{Output, Outputs};
pub use source_only::{PreparedSource, prepare_source};
pub use truth::Truth;

use serde_json::Value;

use super::{
    At, Document, Formats, Pipeline, Step, overrides, parse,
    report::{Clock, StageReport},
};
use crate::{
    core::{
        Figures, plugin,
        stage::{Marker, Metric},
    },
    mistake::{Failure, Mistake, Place, Result},
    status::Status,
};

/// What the command line adds to a pipeline's file.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// `slot.key=value`, in the order given.
    pub settings: Vec<String>,
    /// The folder for results, instead of those of the outputs.
    pub out: Option<PathBuf>,
}

/// A pipeline without mistakes, its rest meshes read.
#[derive(Debug)]
pub struct Prepared {
    /// The pipeline's file.
    pub file: PathBuf,
    /// The settings, with those of the command line; paths of stages are relative to the current folder.
    pub pipeline: Pipeline,
    /// The formats, with the pipeline's settings.
    pub formats: Formats,
    /// What gives its motion.
    pub source: Side,
    /// What takes it.
    pub target: Side,
    /// The poses of the source, at least one.
    pub poses: Vec<PoseInput>,
    /// Pairs of points of the two surfaces.
    pub markers: Vec<Marker>,
    /// The known results.
    pub truth: Truth,
    /// What is measured where there is a truth.
    pub metrics: Vec<Box<dyn Metric>>,
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

/// Reads and checks the pipeline in `file`.
///
/// # Errors
///
/// All mistakes that can be found without computing or reading poses.
pub fn prepare(file: &Path, options: &Options) -> Result<Prepared> {
    let clock = Clock::start();
    let mut document = Document::read(file)?;
    overrides::apply(&mut document, &options.settings).map_err(|mistakes| Failure { mistakes })?;
    let (mut pipeline, mistakes) = parse::parse(&document);
    let mut check = Check {
        base: file.parent().unwrap_or(Path::new("")).into(),
        document: &document,
        formats: Formats::new(std::mem::take(&mut pipeline.formats)),
        inputs: vec![Input { role: "pipeline", path: file.into() }],
        mistakes,
        warnings: vec![],
    };
    check.registry();
    check.format_settings();
    let (source, poses) = check.source(&pipeline.source);
    let target = check.target(&pipeline.target);
    check.inside_out(source.as_ref(), target.as_ref());
    let markers = check.markers(pipeline.markers.as_deref(), source.as_ref(), target.as_ref());
    let truth = check.truth(pipeline.truth.as_deref(), target.as_ref(), &poses);
    let metrics = check.metrics(pipeline.metrics.take(), &truth);
    check.stages(&mut pipeline, source.as_ref(), target.as_ref(), markers.as_deref());
    let outputs = check.outputs(&pipeline, &poses, options.out.as_deref());
    check.end(file)?;
    let (Some(source), Some(target), Some(markers)) = (source, target, markers) else {
        return Err(Mistake::new(Status::Internal, "a mesh was refused without a reason").into());
    };
    Ok(Prepared {
        file: file.into(),
        formats: check.formats,
        inputs: check.inputs,
        warnings: check.warnings,
        reading: clock.stop("reading", "", Figures::default()),
        pipeline,
        source,
        target,
        poses,
        markers,
        truth,
        metrics,
        outputs,
    })
}

/// A check on its way.
struct Check<'a> {
    document: &'a Document,
    /// The folder of the pipeline's file.
    base: PathBuf,
    formats: Formats,
    inputs: Vec<Input>,
    mistakes: Vec<Mistake>,
    warnings: Vec<String>,
}

impl Check<'_> {
    /// All mistakes in the order of the file, if there are any.
    fn end(&mut self, file: &Path) -> Result<()> {
        if self.mistakes.is_empty() {
            return Ok(());
        }
        self.mistakes.sort_by_key(|mistake| match &mistake.place {
            Some(Place::Span { file: place, line, column, .. }) if place == file => (0, *line, *column),
            // Options have no place in the file, and what is wrong in other files comes after.
            Some(Place::Option(_)) => (1, 0, 0),
            _ => (2, 0, 0),
        });
        Err(Failure { mistakes: std::mem::take(&mut self.mistakes) })
    }

    fn wrong(&mut self, path: &[Step], at: At, message: impl Into<String>, hint: impl Into<String>) {
        self.mistakes.push(self.document.mistake(path, at, message).hint(hint));
    }

    fn missing(&mut self, path: &[Step], message: impl Into<String>, hint: impl Into<String>) {
        let mistake = self.document.mistake(path, At::Value, message).hint(hint);
        self.mistakes.push(Mistake { status: Status::MissingInput, ..mistake });
    }

    /// Notes that `path` is read; false, and a mistake at `at`, if there is no such file.
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
                self.mistakes.push(Mistake::new(Status::Internal, message).hint(hint));
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
