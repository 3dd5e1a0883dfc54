//! What new crates begin with.

use super::{Name, Source};
use crate::diagnostic::{Diagnostic, Kind, Result};

/// The beginning of a crate for one kind of stage: what is written, with `my_stage` for its name.
pub struct Template {
    /// The kind.
    pub stage: &'static str,
    /// `src/lib.rs`: a stage that works.
    pub library: &'static str,
    /// `pipeline.yaml`.
    pipeline: &'static str,
    /// The subcommand that uses the stage.
    pub command: &'static str,
}

macro_rules! template {
    ($stage:literal, $command:literal) => {
        Template {
            stage: $stage,
            library: include_str!(concat!("../../../templates/plugin/stages/", $stage, ".rs")),
            pipeline: include_str!(concat!("../../../templates/plugin/pipelines/", $stage, ".yaml")),
            command: $command,
        }
    };
}

const TEMPLATES: [Template; 11] = [
    template!("clusterer", "run"),
    template!("correspondence", "run"),
    template!("deformer", "run"),
    template!("format", "run"),
    template!("key_points", "keypoints"),
    template!("metric", "run"),
    template!("proximity", "run"),
    template!("generator", "run"),
    template!("sampler", "keypoints"),
    template!("transfer", "run"),
    template!("weights", "run"),
];

/// Crates that stages may need besides mimesh's own; the first four are needed by nearly every one.
const DEPENDENCIES: [&str; 5] = ["nalgebra", "schemars", "serde", "typetag", "rayon"];

/// The kinds of stages that there is a template for.
pub fn stages() -> Vec<&'static str> {
    TEMPLATES.iter().map(|template| template.stage).collect()
}

/// The template for a kind of stage.
pub fn of(stage: &str) -> &'static Template {
    let found = TEMPLATES.iter().find(|template| template.stage == stage);
    found.expect("the command line takes only kinds that there is a template for")
}

impl Template {
    /// The crates that the stage needs besides mimesh's own.
    pub fn dependencies(&self) -> impl Iterator<Item = &'static str> {
        let is_needed = |k: usize| k < 4 || self.library.contains(&format!("{}::", DEPENDENCIES[k]));
        (0..DEPENDENCIES.len()).filter(move |&k| is_needed(k)).map(|k| DEPENDENCIES[k])
    }

    /// Every file of a new crate with its path and text.
    pub fn files(&self, name: &Name, mimesh: &Source) -> Result<Vec<(&'static str, String)>> {
        // Text in JSON is text in TOML.
        let quoted = |folder: std::path::PathBuf| serde_json::json!(folder.to_string_lossy()).to_string();
        let dependency = |name: &'static str| match mimesh.dependency(name) {
            Some(version) => Ok(format!("{name} = {version}")),
            None => {
                Err(Diagnostic::new(Kind::BadData, format!("mimesh's Cargo.toml does not say which {name} it takes"))
                    .hint("give the folder of mimesh's source with `--mimesh DIR`"))
            }
        };
        let dependencies = self.dependencies().map(dependency).collect::<std::result::Result<Vec<_>, _>>()?;
        let (folder, core) = (quoted(mimesh.folder.clone()), quoted(mimesh.folder.join("crates/core")));
        let text = |text: &str| {
            fill(
                text,
                &[
                    ("my_dependencies", &dependencies.join("\n")),
                    ("my_core", &core),
                    ("my_mimesh", &folder),
                    ("my_command", self.command),
                    ("my_kind", self.stage),
                    ("my_stage", &name.snake),
                    ("my-stage", &name.kebab),
                    ("MyStage", &name.camel),
                ],
            )
        };
        let mut files = vec![
            ("Cargo.toml", text(include_str!("../../../templates/plugin/Cargo.toml.txt"))),
            ("README.md", text(include_str!("../../../templates/plugin/README.md"))),
            (".gitignore", "/target\n/out\n".into()),
            ("src/lib.rs", text(self.library)),
            ("src/main.rs", text(include_str!("../../../templates/plugin/main.rs"))),
            ("tests/contracts.rs", text(include_str!("../../../templates/plugin/contracts.rs"))),
            ("pipeline.yaml", text(self.pipeline)),
        ];
        files.extend(mimesh.lock.clone().map(|lock| ("Cargo.lock", lock)));
        Ok(files)
    }
}

/// `text` with each marker replaced by what it stands for, which is not looked through again.
fn fill(text: &str, markers: &[(&str, &str)]) -> String {
    let mut result = String::new();
    let mut rest = text;
    loop {
        let found = markers.iter().filter_map(|(marker, value)| Some((rest.find(marker)?, *marker, *value)));
        let Some((at, marker, value)) = found.min_by_key(|(at, _, _)| *at) else { return result + rest };
        result += &rest[..at];
        result += value;
        rest = &rest[at + marker.len()..];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_filled_in_is_not_looked_through_again() {
        assert_eq!(fill("a b a", &[("a", "b"), ("b", "a")]), "b a b");
    }

    #[test]
    fn every_template_uses_its_stage_and_nothing_is_left_to_fill_in() {
        let mimesh = Source::find(None).unwrap();
        for template in &TEMPLATES {
            let name = Name::new("quite-new").unwrap().check(template).unwrap();
            for (file, text) in template.files(&name, &mimesh).unwrap() {
                let markers = ["my_", "my-", "MyStage"];
                assert!(file == "Cargo.lock" || !markers.iter().any(|m| text.contains(m)), "{file}: {text}");
            }
            assert!(template.pipeline.contains("type: my_stage"), "{}", template.stage);
        }
    }
}
