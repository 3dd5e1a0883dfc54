//! From one file to the runs that it declares.
//!
//! In this order: what the file includes, values that are set beside it, a run for every target and every combination of the
//! matrix, variables, and names in paths.

mod matrix;
pub mod names;
mod placeholders;
mod targets;
mod variant;

use std::{
    collections::BTreeSet,
    path::{Path, PathBuf},
};

pub use variant::Variant;

use mimesh_document::{
    At, Document, Step,
    diagnostic::{Diagnostic, Diagnostics, Kind, Location, Result, SET_VALUE},
    include,
    limits::thousands,
    overrides, path,
    source_tree::SourceSpan,
    suggest::did_you_mean,
    variables::{self, Substituted},
    yaml::type_first,
};
use serde_json::Value;

use self::{
    matrix::{Axis, Combination, MAX_RUNS},
    placeholders::OutputPattern,
    targets::{MESH, OneTarget},
};
use crate::{
    parse::slots as pipeline_slots,
    schema::{PipelineShapes, is_of_whole_file, merge_slot_defaults},
};

/// A run, as a pipeline of its own.
#[derive(Debug)]
pub struct Run {
    /// Its target and varied settings, which tell it from other runs.
    pub variant: Variant,
    /// Its pipeline, without `include`, `variables`, `targets` and `matrix`.
    pub document: Document,
}

/// All runs of a file.
#[derive(Debug)]
pub struct Runs {
    /// At least one.
    pub runs: Vec<Run>,
    /// The files that are included, in the order in which they are laid over each other.
    pub included: Vec<PathBuf>,
    /// What is wrong with how they are put together, each once.
    pub diagnostics: Diagnostics,
    /// Places of values that stay as they are because of these diagnostics: what is wrong with them follows.
    pub suppressed: Vec<Location>,
    /// Sentences about what looks wrong.
    pub warnings: Vec<String>,
}

/// Reads `file` with what it includes and takes it apart into its runs; `settings` are values that are set beside it.
///
/// # Errors
///
/// If files cannot be read, are no YAML, or include each other in a circle, and settings that are not understood; what else is
/// wrong is in the result.
pub fn compose(file: &Path, settings: &[String]) -> Result<Runs> {
    let (whole, included) = include::read(file)?;
    compose_document(whole, included, settings)
}

/// The same for a document that was read, with the files that it includes.
///
/// # Errors
///
/// Settings that are not understood; what else is wrong is in the result.
pub fn compose_document(mut whole: Document, included: Vec<PathBuf>, settings: &[String]) -> Result<Runs> {
    let (of_whole, of_runs) = sort(settings);
    overrides::apply(&mut whole, &of_whole, &PipelineShapes)?;
    whole.long_texts().into_result()?;
    // A matrix set to nothing is an empty one.
    let at = [Step::Key("matrix".into())];
    if whole.get(&at).is_some_and(Value::is_null) && matches!(whole.span(&at, At::Value), SourceSpan::Setting(_)) {
        whole.value["matrix"] = Value::Object(serde_json::Map::new());
    }
    let mut diagnostics = Diagnostics::default();
    if let Some((_, part)) = whole.take("include") {
        let diagnostic = Diagnostic::new(Kind::Usage, "`include` cannot be set").at(part.key.location());
        diagnostics.push(diagnostic.hint("write a file that includes both: `include: [a.yaml, b.yaml]`"));
    }
    let axes = matrix::take(&mut whole, &mut diagnostics);
    let targets = targets::take(&mut whole, &mut diagnostics);
    diagnostics.extend(check_conflicts(&of_runs, axes.as_deref(), targets.as_deref()));
    let expansion = Expansion { whole, settings: &of_runs, axes: axes.as_deref(), targets: targets.as_deref() };
    expansion.runs(included, diagnostics)
}

/// Some slots of a pipeline, before it is taken apart into its runs.
#[derive(Debug)]
pub struct Part {
    /// The pipeline with these slots alone.
    pub document: Document,
    /// The files that are included.
    pub included: Vec<PathBuf>,
    /// The names of its targets. The only target is in the document; of several, none is.
    pub targets: Vec<String>,
}

/// The slots `read` of the pipeline in `file`; keys that no pipeline has stay, to be reported.
///
/// # Errors
///
/// As [`compose`], and what is wrong with variables in these slots.
pub fn compose_part(file: &Path, settings: &[String], read: &[&str]) -> Result<Part> {
    let (document, included) = include::read(file)?;
    compose_part_of(document, included, settings, read)
}

/// The same for a document that was read, with the files that it includes.
///
/// # Errors
///
/// Those of [`compose_part`], but for reading.
pub fn compose_part_of(
    mut document: Document,
    included: Vec<PathBuf>,
    settings: &[String],
    read: &[&str],
) -> Result<Part> {
    overrides::apply(&mut document, settings, &PipelineShapes)?;
    document.long_texts().into_result()?;
    let mut ignored = Diagnostics::default();
    matrix::take(&mut document, &mut ignored);
    let targets = targets::take(&mut document, &mut ignored).unwrap_or_default();
    if let [one] = &targets[..] {
        document = one.of(&document);
    }
    // Other slots may use variables that the matrix or a target defines.
    for slot in pipeline_slots().into_iter().filter(|slot| !read.contains(slot)) {
        document.take(slot);
    }
    variables::substitute(&mut document).diagnostics.into_result()?;
    document.long_texts().into_result()?;
    document.value = type_first(std::mem::take(&mut document.value));
    merge_slot_defaults(&mut document);
    Ok(Part { document, included, targets: targets.into_iter().map(|target| target.name).collect() })
}

/// Values of all runs of a file together, which are held at once.
const MAX_VALUES: usize = 1_000_000;

/// How many values there are in `value`, with itself.
fn count(value: &Value) -> usize {
    1 + match value {
        Value::Array(list) => list.iter().map(count).sum(),
        Value::Object(map) => map.values().map(count).sum(),
        _ => 0,
    }
}

struct Expansion<'a> {
    whole: Document,
    settings: &'a [String],
    axes: Option<&'a [Axis]>,
    targets: Option<&'a [OneTarget]>,
}

impl Expansion<'_> {
    fn runs(self, included: Vec<PathBuf>, mut diagnostics: Diagnostics) -> Result<Runs> {
        let axes = self.axes.unwrap_or_default();
        let combinations = matrix::combinations(axes);
        // A file whose targets are all wrong is looked at without one.
        let targets: Vec<Option<&OneTarget>> = match self.targets {
            Some([]) | None => vec![None],
            Some(targets) => targets.iter().map(Some).collect(),
        };
        self.check_size(targets.len().saturating_mul(combinations.len()))?;
        let declared = [self.targets.is_some(), self.axes.is_some()];
        let (mut runs, mut written, mut suppressed) = (Vec::new(), Vec::<OutputPattern>::new(), Vec::new());
        let mut variables = Variables::default();
        let mut not_set = Diagnostics::default();
        for target in targets {
            let of_target = target.map_or_else(|| self.whole.clone(), |target| target.of(&self.whole));
            let mut of_target = of_target;
            if let Err(wrong) = overrides::apply(&mut of_target, self.settings, &PipelineShapes) {
                not_set.extend(wrong);
                continue;
            }
            for combination in &combinations {
                let mut document = of_target.clone();
                diagnostics.extend(matrix::apply(&mut document, axes, combination));
                let found = variables::substitute(&mut document);
                // Nothing else is to be done with such texts.
                document.long_texts().into_result()?;
                let variant = self.variant(target, combination);
                written.extend(placeholders::fill(&mut document, &variant, runs.len(), declared, &mut diagnostics));
                document.value = type_first(std::mem::take(&mut document.value));
                merge_slot_defaults(&mut document);
                variables.add(found, &mut diagnostics, &mut suppressed);
                runs.push(Run { variant, document });
            }
        }
        if !not_set.is_empty() {
            not_set.deduplicate();
            return Err(not_set);
        }
        let variants: Vec<Variant> = runs.iter().map(|run| run.variant.clone()).collect();
        diagnostics.extend(placeholders::needed(&written, &variants));
        let mut warnings = Vec::new();
        variables.unused(&self.whole.file, axes, &mut diagnostics, &mut warnings);
        if self.targets.is_some_and(<[OneTarget]>::is_empty) {
            // That there is no target follows.
            suppressed.push(self.whole.location(&[Step::Key("target".into())], At::Value));
        }
        diagnostics.deduplicate();
        Ok(Runs { runs, included, diagnostics, suppressed, warnings })
    }

    /// Refuses more `runs`, or larger ones, than a file can be meant to have.
    fn check_size(&self, runs: usize) -> Result<()> {
        let values = count(&self.whole.value).saturating_mul(runs);
        let message = if runs > MAX_RUNS {
            format!("the file has {} runs, expected {} at most", thousands(runs), thousands(MAX_RUNS))
        } else if values > MAX_VALUES {
            let most = thousands(MAX_VALUES);
            format!(
                "the {} runs of the file have {} values, expected {most} at most",
                thousands(runs),
                thousands(values)
            )
        } else {
            return Ok(());
        };
        let diagnostic = Diagnostic::new(Kind::BadPipeline, message).at(Location::File(self.whole.file.clone()));
        Err(diagnostic.hint("name fewer targets, vary fewer keys at once, or fewer values").into())
    }

    fn variant(&self, target: Option<&OneTarget>, combination: &Combination) -> Variant {
        let target = target.map(|target| target.name.clone());
        let matrix = self.axes.map(|_| combination.name.clone()).filter(|name| !name.is_empty());
        let name = target.iter().chain(&matrix).cloned().collect::<Vec<_>>().join("-");
        Variant { name, target, matrix, values: combination.values.clone(), shown: combination.shown.clone() }
    }
}

/// The variables of all runs.
#[derive(Default)]
struct Variables {
    used: BTreeSet<String>,
    suggested: BTreeSet<String>,
    defined: Vec<(String, SourceSpan)>,
}

impl Variables {
    fn add(&mut self, found: Substituted, diagnostics: &mut Diagnostics, suppressed: &mut Vec<Location>) {
        diagnostics.extend(found.diagnostics);
        suppressed.extend(found.suppressed);
        self.used.extend(found.used);
        self.suggested.extend(found.suggested);
        for (name, span) in found.defined {
            if !self.defined.iter().any(|(other, at)| *other == name && at.location() == span.location()) {
                self.defined.push((name, span));
            }
        }
    }

    /// Tells of variables that are used nowhere. One that an option or the matrix sets is a diagnostic, since it was to change
    /// something; one of an included file is nothing, since other files may use it.
    fn unused(&self, file: &Path, axes: &[Axis], diagnostics: &mut Diagnostics, warnings: &mut Vec<String>) {
        let varies = |name: &String| {
            axes.iter().any(|axis| axis.path == [Step::Key("variables".into()), Step::Key(name.clone())])
        };
        let used: Vec<&String> = self.used.iter().collect();
        for (name, span) in &self.defined {
            if self.used.contains(name) || self.suggested.contains(name) {
                continue;
            }
            let hint = did_you_mean(name, &used).unwrap_or_else(|| format!("use it as `${{{name}}}`, or remove it"));
            let message = format!("the variable `{name}` is used nowhere");
            match span {
                _ if varies(name) || matches!(span, SourceSpan::Setting(_)) => {
                    diagnostics.push(Diagnostic::new(Kind::BadPipeline, message).at(span.location()).hint(hint));
                }
                SourceSpan::Text(text, _) if text.file != file => {}
                _ => warnings.push(format!("{}: {message}; {hint}", span.location())),
            }
        }
    }
}

/// The settings of the file as a whole, and those of each run.
fn sort(settings: &[String]) -> (Vec<String>, Vec<String>) {
    let of_whole = |setting: &&String| {
        let key = setting.trim_start().split(['.', '=']).next().unwrap_or_default();
        is_of_whole_file(key.trim())
    };
    settings.iter().cloned().partition(|setting| of_whole(&setting))
}

/// Values that replace each other: of settings, of keys of the matrix, and of targets.
fn check_conflicts(settings: &[String], axes: Option<&[Axis]>, targets: Option<&[OneTarget]>) -> Vec<Diagnostic> {
    let mut diagnostics = conflicts_of_axes(axes.unwrap_or_default(), targets.is_some());
    diagnostics.extend(conflicts_of_settings(settings, axes, targets));
    diagnostics
}

/// Keys of the matrix that lie within each other, or that give every target the same mesh.
fn conflicts_of_axes(axes: &[Axis], has_targets: bool) -> Vec<Diagnostic> {
    let mut diagnostics = Vec::new();
    for (i, axis) in axes.iter().enumerate() {
        let mut conflict = |message: String, hint: &str| {
            let diagnostic = Diagnostic::new(Kind::BadPipeline, message).hint(hint);
            diagnostics.push(Diagnostic { location: axis.location(), ..diagnostic });
        };
        if let Some(other) = axes[..i].iter().find(|other| other.overlaps(&axis.path)) {
            let message = format!("`{}` and `{}` replace each other's values", other.key, axis.key);
            conflict(message, "vary one of the two, with all settings in its values");
        }
        if has_targets && MESH.iter().any(|key| axis.overlaps(&path(["target", key]))) {
            let message = format!("`{}` beside `targets`, each of which has its own mesh", axis.key);
            conflict(message, "name the meshes as targets, or remove `targets`");
        }
    }
    diagnostics
}

/// Settings that what makes several runs would undo, or make the same for all.
fn conflicts_of_settings(settings: &[String], axes: Option<&[Axis]>, targets: Option<&[OneTarget]>) -> Vec<Diagnostic> {
    let mut diagnostics = Vec::new();
    for setting in settings {
        let Ok((path, _)) = overrides::read(setting) else { continue };
        let conflict = |message: String| Diagnostic::new(Kind::Usage, message).at(Location::Setting(setting.clone()));
        let keys = path.iter().map(Step::to_string).collect::<Vec<_>>();
        if let Some(axis) = axes.unwrap_or_default().iter().find(|axis| axis.overlaps(&path)) {
            let hint = format!("vary it otherwise, e.g. by `matrix.{}=[…]`", axis.key);
            let diagnostic = conflict(format!("`{}` is varied by `matrix`", axis.key)).hint(hint);
            diagnostics.push(diagnostic.remedy(SET_VALUE, "matrix=", "vary nothing"));
        }
        if let Some(targets) = targets
            && matches!(&keys[..], [first, ..] if first == "target")
            && (keys.len() == 1 || keys[1] == "rest")
        {
            let name = targets.first().map_or("NAME", |target| &target.name);
            let setting = format!("targets.{name}.rest=…");
            let words = format!("set `{setting}`");
            let diagnostic = conflict("there are several targets, each with its own mesh".into());
            diagnostics.push(diagnostic.remedy(SET_VALUE, setting, words));
        }
    }
    diagnostics
}
