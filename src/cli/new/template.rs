//! The templates of new crates: files of mimesh's source under `templates/plugin`.
//!
//! A kind of stage has a template if `stages/KIND.rs` is there; its pipeline is `pipelines/KIND.yaml`. No code lists the kinds.

use std::{fs, path::Path};

use mimesh_document::{
    diagnostic::{Diagnostic, Kind, Result},
    files::read_text,
};

use crate::cli::new::{Name, source::Source};

/// The files that a new crate of one kind of stage begins with; the stage is called `my_stage` in them.
pub struct Template {
    /// The kind of stage.
    pub stage: String,
    /// The text of `src/lib.rs`: a stage that works.
    library: String,
    /// The crates that the stage needs besides mimesh's own, sorted.
    pub dependencies: Vec<String>,
    /// The text of `pipeline.yaml`.
    pipeline: String,
    /// The files that all kinds have in common, with their paths in the new crate.
    common: Vec<(&'static str, String)>,
}

/// The folder of the templates in mimesh's source.
const FOLDER: &str = "templates/plugin";

/// The files that all kinds have in common: the path in the new crate, and the file in [`FOLDER`].
const COMMON: [(&str, &str); 4] = [
    ("Cargo.toml", "Cargo.toml.txt"),
    ("README.md", "README.md"),
    ("src/main.rs", "main.rs"),
    ("tests/contracts.rs", "contracts.rs"),
];

/// The kinds of stages that have a template in mimesh's source in `folder`, sorted; none if there is no source.
pub fn kinds(folder: &Path) -> Vec<String> {
    let files = fs::read_dir(folder.join(FOLDER).join("stages")).into_iter().flatten().flatten();
    let mut kinds: Vec<String> = files.filter_map(|file| kind_of_file(&file.path())).collect();
    kinds.sort();
    kinds
}

fn kind_of_file(file: &Path) -> Option<String> {
    let is_rust = file.extension().is_some_and(|extension| extension == "rs");
    file.file_stem().filter(|_| is_rust).map(|stem| stem.to_string_lossy().into_owned())
}

impl Template {
    /// Reads the template for a kind of stage.
    ///
    /// # Errors
    ///
    /// A diagnostic if there is none, or if a file cannot be read.
    pub fn read(stage: &str, mimesh: &Source) -> Result<Self> {
        let kinds = kinds(&mimesh.folder);
        if !kinds.iter().any(|kind| kind == stage) {
            let message = format!("mimesh has no template for a stage of kind `{stage}`");
            let hint = match kinds.is_empty() {
                true => format!("give the folder of a mimesh source that has `{FOLDER}` with `--mimesh DIR`"),
                false => format!("kinds with a template: {}", kinds.join(", ")),
            };
            return Err(Diagnostic::new(Kind::Usage, message).hint(hint).into());
        }
        let library = read_file(mimesh, &format!("stages/{stage}.rs"))?;
        Ok(Self {
            stage: stage.into(),
            dependencies: dependencies(&library, mimesh),
            library,
            pipeline: read_file(mimesh, &format!("pipelines/{stage}.yaml"))?,
            common: COMMON.iter().map(|(path, file)| Ok((*path, read_file(mimesh, file)?))).collect::<Result<_>>()?,
        })
    }

    /// The subcommand that uses the stage in the template's pipeline.
    pub fn command(&self) -> &'static str {
        if self.pipeline.lines().any(|line| line.starts_with("key_points:")) { "keypoints" } else { "run" }
    }

    /// Whether `word` has a meaning in the code of the stage.
    pub fn uses(&self, word: &str) -> bool {
        let code = self.library.lines().filter(|line| !line.trim_start().starts_with("//"));
        code.flat_map(|line| line.split(|c: char| !c.is_alphanumeric() && c != '_')).any(|used| used == word)
    }

    /// Every file of a new crate with its path and text.
    ///
    /// # Errors
    ///
    /// A diagnostic if mimesh's `Cargo.toml` does not name the version of a dependency.
    pub fn files(&self, name: &Name, mimesh: &Source) -> Result<Vec<(&'static str, String)>> {
        let dependencies =
            self.dependencies.iter().map(|name| dependency_line(name, mimesh)).collect::<Result<Vec<_>>>()?;
        let values = [
            ("my_dependencies", dependencies.join("\n")),
            ("my_core", toml_string(&mimesh.folder.join("crates/core"))),
            ("my_mimesh", toml_string(&mimesh.folder)),
            ("my_command", self.command().into()),
            ("my_kind", self.stage.clone()),
            ("my_stage", name.snake.clone()),
            ("my-stage", name.kebab.clone()),
            ("MyStage", name.camel.clone()),
        ];
        let mut files: Vec<_> = self.common.iter().map(|(path, text)| (*path, fill(text, &values))).collect();
        files.extend([
            (".gitignore", "/target\n/out\n".into()),
            ("src/lib.rs", fill(&self.library, &values)),
            ("pipeline.yaml", fill(&self.pipeline, &values)),
        ]);
        files.extend(mimesh.lock.clone().map(|lock| ("Cargo.lock", lock)));
        Ok(files)
    }
}

/// The crates that `library` names in `use` and in attributes, as far as mimesh depends on them; nearly every stage needs
/// `nalgebra`.
fn dependencies(library: &str, mimesh: &Source) -> Vec<String> {
    let named = library.lines().filter_map(|line| {
        let line = line.trim_start();
        line.strip_prefix("use ").or_else(|| line.strip_prefix("#[").filter(|_| line.contains("::")))
    });
    let segments = named.filter_map(|path| path.split(|c: char| !c.is_alphanumeric() && c != '_').next());
    let foreign = segments.filter(|segment| !segment.starts_with("mimesh"));
    // In a manifest the name of a crate may have hyphens.
    let spellings = foreign.flat_map(|segment| [segment.to_owned(), segment.replace('_', "-")]);
    let mut known: Vec<String> = spellings.filter(|name| mimesh.dependency(name).is_some()).collect();
    known.push("nalgebra".into());
    known.sort();
    known.dedup();
    known
}

/// Reads a file of the templates.
fn read_file(mimesh: &Source, file: &str) -> Result<String> {
    Ok(read_text(&mimesh.folder.join(FOLDER).join(file))?)
}

/// The line of `Cargo.toml` for a dependency, with the version that mimesh asks for.
fn dependency_line(name: &str, mimesh: &Source) -> Result<String> {
    match mimesh.dependency(name) {
        Some(version) => Ok(format!("{name} = {version}")),
        None => {
            let message = format!("mimesh's Cargo.toml does not name the version of {name}");
            let diagnostic = Diagnostic::new(Kind::BadData, message);
            Err(diagnostic.hint("give the folder of mimesh's source with `--mimesh DIR`").into())
        }
    }
}

/// A path as a string of TOML, which has the form of a string of JSON.
fn toml_string(path: &Path) -> String {
    serde_json::json!(path.to_string_lossy()).to_string()
}

/// Replaces each marker in `text` by its value. Markers within values stay.
fn fill(text: &str, values: &[(&str, String)]) -> String {
    let mut result = String::new();
    let mut rest = text;
    loop {
        let found = values.iter().filter_map(|(marker, value)| Some((rest.find(marker)?, *marker, value)));
        let Some((start, marker, value)) = found.min_by_key(|(start, _, _)| *start) else { return result + rest };
        result += &rest[..start];
        result += value;
        rest = &rest[start + marker.len()..];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn markers_within_values_stay() {
        assert_eq!(fill("a b a", &[("a", "b".into()), ("b", "a".into())]), "b a b");
    }

    #[test]
    fn every_template_uses_its_stage_and_leaves_no_marker() {
        let mimesh = Source::find(None).unwrap();
        let kinds = kinds(&mimesh.folder);
        assert!(kinds.iter().any(|kind| kind == "transfer"), "{kinds:?}");
        for kind in kinds {
            let template = Template::read(&kind, &mimesh).unwrap();
            let name = Name::new("quite-new").unwrap().check(&template).unwrap();
            for (file, text) in template.files(&name, &mimesh).unwrap() {
                // The folder of mimesh's source may be called anything.
                let text = text.replace(toml_string(&mimesh.folder).trim_matches('"'), "");
                let markers = ["my_", "my-", "MyStage"];
                assert!(file == "Cargo.lock" || !markers.iter().any(|m| text.contains(m)), "{file}: {text}");
            }
            assert!(template.pipeline.contains("type: my_stage"), "{kind}");
        }
    }

    #[test]
    fn the_crates_that_a_stage_names_are_its_dependencies() {
        let mimesh = Source::find(None).unwrap();
        let library = "use std::fmt;\nuse mimesh_core::register;\nuse petgraph::graph::Graph;\nuse nalgebra_sparse::CscMatrix;\n\
            #[derive(Clone)]\n#[typetag::serde(name = \"my_stage\")]\n// use kiddo::KdTree;\n";
        assert_eq!(dependencies(library, &mimesh), ["nalgebra", "nalgebra-sparse", "petgraph", "typetag"]);
    }

    #[test]
    fn a_kind_without_a_template_is_refused_with_the_kinds_that_have_one() {
        let failure = Template::read("renderer", &Source::find(None).unwrap()).err().expect("no such template");
        let [diagnostic] = &failure.list[..] else { panic!("{failure}") };
        assert_eq!(diagnostic.message, "mimesh has no template for a stage of kind `renderer`");
        assert!(diagnostic.hint.as_ref().is_some_and(|hint| hint.contains("sampler")), "{failure}");
    }
}
