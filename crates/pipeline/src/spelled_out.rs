//! A pipeline's file with every choice spelled out and explained.

use std::path::{Component, Path, PathBuf, absolute};

use mimesh_document::{Document, Step, path, paths};
use serde_json::{Map, Value, json};

use crate::{
    choices::{AUTO, Choice},
    input::Prepared,
    json::to_value,
    marker_source::CLICKS,
    parse::slots,
    schema::{FileSetting, SchemaNode, file_settings},
};

/// What each slot is for, in the words of a comment.
const MEANINGS: [(&str, &str); 8] = [
    ("source", "The mesh that gives its motion, and its poses."),
    ("target", "The mesh that takes the motion."),
    ("markers", "Pairs of corresponding points: a file, or a stage that finds them."),
    ("proximity", "How the components of the target lie to each other."),
    ("correspondence", "How triangles of source and target are paired."),
    ("transfer", "How the motion is carried over."),
    ("truth", "The known results to compare with."),
    ("output", "The files to write: with `{pose}` one for each pose."),
];

/// Keys that people add, as comments.
const MORE: &str = "\
# More keys, by example; the schema lists all of them:
# gates: { edge_stretch: 60 }               # exit status 3 if a pose is worse
# metrics: [ { type: self_intersections } ] # measured beside the default ones
# pictures: { up: z }                       # which way is up in the pictures
";

/// The file of the pipeline `prepared` for `place`: paths are relative to its folder, and what was chosen stands as if it had been
/// named. A run of it gives the same results.
pub fn spelled_out(prepared: &Prepared, place: &Path) -> String {
    let folder = place.parent().unwrap_or(Path::new(""));
    let mut values = values(prepared);
    for at in files(&prepared.document, &values) {
        rebase(&prepared.document, &mut values, &at, folder);
    }
    let mut text = String::new();
    for slot in slots() {
        let Some(value) = values.get(slot) else { continue };
        if !text.is_empty() {
            text.push('\n');
        }
        if let Some((_, meaning)) = MEANINGS.iter().find(|(key, _)| *key == slot) {
            text += &format!("# {meaning}\n");
        }
        for choice in prepared.choices.iter().filter(|choice| slot_of(choice) == slot) {
            text += &format!("# Chosen by the meshes: {}.\n", choice.why);
        }
        text += &match value {
            Value::Array(items) if items.len() > 1 => {
                items.iter().fold(format!("{slot}:\n"), |text, item| text + &format!("  - {}\n", flow(item)))
            }
            value => format!("{slot}: {}\n", flow(value)),
        };
    }
    text + "\n" + MORE
}

/// The slot that a choice is about.
fn slot_of(choice: &Choice) -> &str {
    choice.stage.split('.').next().unwrap_or_default()
}

/// The values of the document with those that were chosen.
fn values(prepared: &Prepared) -> Value {
    let mut values = prepared.document.value.clone();
    if let Some(map) = values.as_object_mut() {
        map.retain(|_, value| value.as_str() != Some(AUTO));
    }
    let typed = to_value(&prepared.pipeline);
    for choice in &prepared.choices {
        match choice.stage.as_str() {
            "source.poses" => {
                let mut poses = typed["source"]["poses"].clone();
                if let Some([clip]) = poses["clip"].as_array().map(Vec::as_slice) {
                    poses["clip"] = clip.clone();
                }
                values["source"]["poses"] = poses;
            }
            // Names are taken where nothing is said of markers.
            "markers" if typed["markers"].is_null() => {}
            // What was found out about files of points is found out again.
            stage if stage.starts_with("markers.") => {}
            stage => values[stage] = json!({ "type": choice.chosen }),
        }
    }
    values
}

/// The paths of all values that name files.
fn files(document: &Document, values: &Value) -> Vec<Vec<Step>> {
    let one = [
        path(["source", "rest"]),
        path(["source", "rest", "file"]),
        path(["source", "poses"]),
        path(["source", "poses", "file"]),
        path(["target", "rest"]),
        path(["target", "rest", "file"]),
        path(["markers"]),
        path(["markers", "source"]),
        path(["markers", "target"]),
        path(["markers", CLICKS]),
        path(["markers", CLICKS, "source"]),
        path(["markers", CLICKS, "target"]),
        path(["keep_correspondence"]),
        path(["truth"]),
        path(["output"]),
    ];
    let items = |at: Vec<Step>| {
        let count = document.get(&at).and_then(Value::as_array).map(Vec::len);
        match count {
            Some(count) => (0..count).map(|i| [&at[..], &[Step::Index(i)]].concat()).collect(),
            None => vec![at],
        }
    };
    let of_settings = file_settings(SchemaNode::pipeline(), values);
    one.into_iter().flat_map(items).chain(of_settings.into_iter().map(|FileSetting { path, .. }| path)).collect()
}

/// Makes the path at `at` relative to `folder`; those of settings are relative to the current folder already.
fn rebase(document: &Document, values: &mut Value, at: &[Step], folder: &Path) {
    let is_of_setting = file_settings(SchemaNode::pipeline(), values).iter().any(|setting| setting.path == at);
    let Some(value) = at.iter().try_fold(values, |value, step| step.get_mut(value)) else { return };
    let Some(text) = value.as_str().filter(|text| !text.is_empty()) else { return };
    let from = if is_of_setting { PathBuf::from(text) } else { paths::from_base(document.folder(at), Path::new(text)) };
    *value = relative(&from, folder).to_string_lossy().into();
}

/// `path` as a file in `folder` names it, both seen from the current folder; an absolute path stays.
fn relative(path: &Path, folder: &Path) -> PathBuf {
    if path.is_absolute() || folder.as_os_str().is_empty() {
        return path.into();
    }
    let (Ok(to), Ok(from)) = (absolute(path), absolute(folder)) else { return path.into() };
    let (to, from) = (paths::tidy(&to), paths::tidy(&from));
    let common = to.components().zip(from.components()).take_while(|(a, b)| a == b).count();
    let up = from.components().skip(common).map(|_| Component::ParentDir);
    up.chain(to.components().skip(common)).collect()
}

/// A value in the flow style of YAML.
fn flow(value: &Value) -> String {
    match value {
        Value::Null => "~".into(),
        Value::String(text) => scalar(text),
        Value::Array(items) => format!("[{}]", items.iter().map(flow).collect::<Vec<_>>().join(", ")),
        Value::Object(map) if map.is_empty() => "{}".into(),
        Value::Object(map) => format!("{{ {} }}", entries(map)),
        other => other.to_string(),
    }
}

fn entries(map: &Map<String, Value>) -> String {
    map.iter().map(|(key, value)| format!("{}: {}", scalar(key), flow(value))).collect::<Vec<_>>().join(", ")
}

/// A text without quotes where YAML reads it as the same text.
fn scalar(text: &str) -> String {
    const WORDS: [&str; 8] = ["true", "false", "null", "yes", "no", "on", "off", "auto"];
    let begins = text.starts_with(|c: char| c.is_ascii_alphabetic() || c == '/' || c == '_');
    let begins = begins || text.starts_with("./") || text.starts_with("../");
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "._-/+".contains(c);
    let is_word = WORDS.iter().any(|word| text.eq_ignore_ascii_case(word)) || text.parse::<f64>().is_ok();
    if begins && !is_word && text.chars().all(is_plain) { text.into() } else { json!(text).to_string() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_are_quoted_only_where_yaml_reads_them_otherwise() {
        for plain in ["horse.obj", "../a/b-1.glb", "/tmp/x", "Run"] {
            assert_eq!(scalar(plain), plain);
        }
        for quoted in ["no", "inf", "12", "a b", "{pose}.obj", "*.obj", "horse-??.obj", "", "é", ".5", "a: b", "#x"] {
            assert_eq!(scalar(quoted), json!(quoted).to_string());
        }
    }

    #[test]
    fn values_come_back_from_their_flow_style() {
        let value = json!({ "a": [1, 0.25, null, true], "b c": { "type": "x", "k": "1e3" }, "d": {}, "e": "no" });
        let document = Document::parse(Path::new("p.yaml"), &format!("v: {}\n", flow(&value))).unwrap();
        assert_eq!(document.value["v"], value);
    }

    #[test]
    fn paths_are_relative_to_the_folder_of_the_new_file() {
        assert_eq!(relative(Path::new("a/x.obj"), Path::new("a/b")), Path::new("../x.obj"));
        assert_eq!(relative(Path::new("../x.obj"), Path::new("")), Path::new("../x.obj"));
        assert_eq!(relative(Path::new("/a/x.obj"), Path::new("b")), Path::new("/a/x.obj"));
        assert_eq!(relative(Path::new("x-*.obj"), Path::new("out")), Path::new("../x-*.obj"));
    }
}
