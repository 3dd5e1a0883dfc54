use std::{
    collections::{HashMap, HashSet},
    path::{Path, PathBuf},
};

use super::{Check, PoseInput};
use crate::{
    mistake::Mistake,
    pipeline::{At, Pipeline, Step, Writes, document::path, resolve},
    status::Status,
};

/// What a run writes.
#[derive(Clone, Debug, Default)]
pub struct Outputs {
    /// The results, in the order of the pipeline.
    pub meshes: Vec<Output>,
    /// Where the correspondence is kept, if it is.
    pub correspondence: Option<PathBuf>,
    /// The report of the run, beside the first result.
    pub report: PathBuf,
}

/// Results of one pattern.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Output {
    /// A file a pose, in the order of poses.
    Poses(Vec<PathBuf>),
    /// One file for rest and poses.
    Sequence(PathBuf),
}

impl Check<'_> {
    pub(super) fn outputs(&mut self, pipeline: &Pipeline, poses: &[PoseInput], out: Option<&Path>) -> Outputs {
        let place = |path: &Path| match (out, path.file_name()) {
            (Some(out), Some(name)) => out.join(name),
            _ => resolve::from_base(&self.base, path),
        };
        let patterns: Vec<PathBuf> = pipeline.output.items.iter().map(|pattern| place(Path::new(pattern))).collect();
        let correspondence = pipeline.keep_correspondence.as_deref().map(place);
        let mut outputs = Outputs { meshes: vec![], correspondence, report: PathBuf::new() };
        let read = self.inputs.iter().map(|input| (resolve::identity(&input.path), input.role));
        let mut places = Places { read: read.collect(), written: HashSet::new() };
        if patterns.is_empty() && self.document.value.get("output").is_some_and(|output| output.is_array()) {
            self.wrong(&path(["output"]), At::Value, "the list of outputs is empty", "e.g. `output: out/{pose}.obj`");
        }
        for (i, pattern) in patterns.iter().enumerate() {
            let mut at = path(["output"]);
            if pipeline.output.listed {
                at.push(Step::Index(i));
            }
            if let Some(output) = self.output(pattern, poses, &at) {
                // One file tells what is wrong with all of a pattern.
                let _ = output.files().iter().all(|file| self.writable(file, &at, &mut places));
                outputs.meshes.push(output);
            }
        }
        if let Some(file) = &outputs.correspondence {
            let at = path(["keep_correspondence"]);
            if file.extension().is_none_or(|extension| !extension.eq_ignore_ascii_case("json")) {
                self.wrong(
                    &at,
                    At::Value,
                    "a correspondence is kept as .json",
                    "e.g. `keep_correspondence: pairs.json`",
                );
            }
            self.writable(file, &at, &mut places);
        }
        if let Some(folder) = patterns.first().and_then(|first| first.parent()) {
            outputs.report = folder.join("run.json");
            self.writable(&outputs.report, &path(["output"]), &mut places);
        }
        outputs
    }

    fn output(&mut self, pattern: &Path, poses: &[PoseInput], at: &[Step]) -> Option<Output> {
        let text = pattern.to_string_lossy();
        let name = pattern.file_name().unwrap_or_default().to_string_lossy();
        if let Some(other) = resolve::placeholders(&name).into_iter().find(|name| *name != "pose") {
            self.wrong(
                at,
                At::Value,
                format!("unknown placeholder `{{{other}}}`"),
                "`{pose}` stands for the pose's name",
            );
            return None;
        }
        let writes = match self.formats.writer(pattern) {
            Ok((_, writes)) => writes,
            Err(unknown) => {
                self.wrong(at, At::Value, unknown.message, unknown.hint);
                return None;
            }
        };
        match (writes, text.contains("{pose}")) {
            (Writes::Pose, true) => {
                let file = |pose: &PoseInput| PathBuf::from(resolve::with_pose(&text, &pose.name));
                Some(Output::Poses(poses.iter().map(file).collect()))
            }
            (Writes::Sequence, false) => Some(Output::Sequence(pattern.into())),
            (Writes::Pose, false) => {
                let extension = pattern.extension().unwrap_or_default().to_string_lossy();
                let stem = resolve::stem(pattern);
                let message = format!("a .{extension} file holds one pose, so its name needs `{{pose}}`");
                self.wrong(at, At::Value, message, format!("e.g. `{stem}-{{pose}}.{extension}`"));
                None
            }
            (Writes::Sequence, true) => {
                let extension = pattern.extension().unwrap_or_default().to_string_lossy();
                let message = format!("a .{extension} file holds all poses, so its name cannot have `{{pose}}`");
                self.wrong(at, At::Value, message, "remove `{pose}`");
                None
            }
        }
    }

    /// Checks that `file` can be written without harm: it is no input, no folder, and nothing else is written there.
    fn writable(&mut self, file: &Path, at: &[Step], places: &mut Places) -> bool {
        let identity = resolve::identity(file);
        let blocked = |message: String| Mistake {
            status: Status::CannotWrite,
            ..self.document.mistake(at, At::Value, message).hint("choose another folder or name")
        };
        let mistake = if let Some(role) = places.read.get(&identity) {
            let message = format!("{} would overwrite an input ({role})", file.display());
            Some(self.document.mistake(at, At::Value, message).hint("write into another folder, e.g. `out/{pose}.obj`"))
        } else if file.is_dir() {
            Some(blocked(format!("cannot write {}: there is a folder of that name", file.display())))
        } else if let Some(ancestor) = file.ancestors().skip(1).find(|a| a.exists()).filter(|a| !a.is_dir()) {
            Some(blocked(format!("cannot write {}: {} is not a folder", file.display(), ancestor.display())))
        } else if !places.written.insert(identity) {
            let hint = "give each output its own name; poses are told apart by `{pose}`";
            Some(self.document.mistake(at, At::Value, format!("{} would be written twice", file.display())).hint(hint))
        } else {
            None
        };
        let fine = mistake.is_none();
        self.mistakes.extend(mistake);
        fine
    }
}

/// Files by what the system takes them for.
struct Places {
    /// Inputs, and what they are.
    read: HashMap<PathBuf, &'static str>,
    /// Outputs so far.
    written: HashSet<PathBuf>,
}

impl Output {
    /// The files.
    pub fn files(&self) -> &[PathBuf] {
        match self {
            Self::Poses(files) => files,
            Self::Sequence(file) => std::slice::from_ref(file),
        }
    }
}
