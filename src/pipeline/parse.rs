//! From the values of a document to the typed [`Pipeline`], with all diagnostics at once.
//!
//! Each slot, and each stage of a list, is deserialised on its own. When that fails, the diagnostic is noted, the offending
//! value is taken out of a copy, and the rest is tried again, so that a second diagnostic in it is found as well.

use serde::de::DeserializeOwned;
use serde_json::Value;
use serde_path_to_error::Segment;

use super::{
    At, Document, Pipeline, Step,
    compose::KEYS,
    ranges,
    words::{did_you_mean, nearest, tell},
};
use crate::{
    core::{plugin, stage::Transfer},
    diagnostic::Diagnostic,
};

/// The keys of a pipeline, in the order of its documentation.
pub const SLOTS: [&str; 14] = [
    "source",
    "target",
    "key_points",
    "markers",
    "proximity",
    "correspondence",
    "keep_correspondence",
    "transfer",
    "truth",
    "metrics",
    "gates",
    "pictures",
    "formats",
    "output",
];

/// The pipeline that `document` declares, as far as it can be understood, and what is wrong with it.
pub fn parse(document: &Document) -> (Pipeline, Vec<Diagnostic>) {
    let mut slots = Slots { document, diagnostics: vec![], meant: vec![] };
    if !document.value.is_object() {
        let hint = "a pipeline begins with e.g. `source: { rest: horse.obj, poses: horse-??.obj }`";
        let message = "expected a map with the keys `source`, `target`, `correspondence`, `transfer` and `output`";
        return (Pipeline::default(), vec![document.diagnostic(&[], At::Value, message).hint(hint)]);
    }
    slots.unknown();
    let pipeline = Pipeline {
        source: slots.required("source").unwrap_or_default(),
        target: slots.required("target").unwrap_or_default(),
        key_points: slots.optional("key_points"),
        markers: slots.optional("markers"),
        proximity: slots.optional("proximity"),
        correspondence: if slots.does_without_correspondence() {
            slots.optional("correspondence")
        } else {
            slots.required("correspondence")
        },
        keep_correspondence: slots.optional("keep_correspondence"),
        transfer: slots.required("transfer"),
        truth: slots.optional("truth"),
        metrics: slots.list("metrics"),
        pictures: slots.optional("pictures").unwrap_or_default(),
        gates: slots.optional("gates").unwrap_or_default(),
        formats: slots.list("formats").unwrap_or_default(),
        output: slots.required("output").unwrap_or_default(),
    };
    (pipeline, slots.diagnostics)
}

/// Deserialises the value at `path` of `document`; every diagnostic is added to `diagnostics`.
///
/// The result is what could be understood; it is not to be used if there were diagnostics, other than to look for more.
pub fn value<T: DeserializeOwned>(document: &Document, path: &[Step], diagnostics: &mut Vec<Diagnostic>) -> Option<T> {
    let mut value = path.iter().try_fold(&document.value, |value, step| step.get(value))?.clone();
    if value.is_array() && describes_map::<T>() {
        // Serde would take a list for the fields of a struct in their order.
        diagnostics.push(diagnostic(document, path, "invalid type: sequence, expected struct"));
        return None;
    }
    let mut removed: Vec<Vec<Step>> = vec![];
    loop {
        let error = match serde_path_to_error::deserialize::<_, T>(&value) {
            Ok(parsed) => return Some(parsed),
            Err(error) => error,
        };
        let inner: Vec<Step> = error.path().iter().filter_map(step).collect();
        let text = error.inner().to_string();
        // Of what has been taken out only the reason is told, not that it is missing or that its stand-in is wrong.
        let follows = removed.iter().any(|gone| *gone == inner || gone[..gone.len() - 1] == inner[..]);
        if !follows {
            let whole: Vec<Step> = path.iter().chain(&inner).cloned().collect();
            diagnostics.push(diagnostic(document, &whole, &text));
        }
        let gone = take_out(&mut value, &inner, &removed)?;
        removed.push(gone);
    }
}

/// Whether `T` is read from a map: it can be read from an empty one, or misses a key in it.
fn describes_map<T: DeserializeOwned>() -> bool {
    match serde_json::from_value::<T>(Value::Object(serde_json::Map::new())) {
        Ok(_) => true,
        Err(error) => error.to_string().starts_with("missing field"),
    }
}

struct Slots<'a> {
    document: &'a Document,
    diagnostics: Vec<Diagnostic>,
    /// Slots that unknown keys may have meant, which are not told to be missing as well.
    meant: Vec<&'static str>,
}

impl Slots<'_> {
    /// Tells of unknown keys, and keeps what they may have meant.
    fn unknown(&mut self) {
        for key in self.document.value.as_object().into_iter().flat_map(|map| map.keys()) {
            if !SLOTS.contains(&key.as_str()) {
                let all: Vec<&str> = KEYS.into_iter().chain(SLOTS).collect();
                self.meant.extend(SLOTS.into_iter().filter(|slot| nearest(key, &all) == Some(slot)));
                let known = || format!("known keys: {}", all.join(", "));
                self.diagnostics.push(
                    self.document
                        .diagnostic(&[Step::Key(key.clone())], At::Key, format!("unknown key `{key}`"))
                        .hint(did_you_mean(key, &all).unwrap_or_else(known)),
                );
            }
        }
    }

    /// Whether the transfer is one that looks at no correspondence.
    fn does_without_correspondence(&self) -> bool {
        let transfer = self.document.value.get("transfer");
        let default = || plugin::instance::<dyn Transfer>(transfer?.get("type")?.as_str()?);
        // What is nested in it may say so; where its settings are wrong, the default of its type must do.
        let transfer = transfer.and_then(|settings| plugin::configured(settings.clone())).or_else(default);
        transfer.is_some_and(|transfer: Box<dyn Transfer>| !transfer.needs_correspondence())
    }

    fn optional<T: DeserializeOwned>(&mut self, key: &str) -> Option<T> {
        self.at(&[Step::Key(key.into())])
    }

    /// A list of stages, each read on its own; those with diagnostics are left out.
    fn list<T: DeserializeOwned>(&mut self, key: &str) -> Option<Vec<T>> {
        match self.document.value.get(key).and_then(Value::as_array).map(Vec::len) {
            Some(count) => Some((0..count).filter_map(|i| self.at(&[Step::Key(key.into()), Step::Index(i)])).collect()),
            None => self.optional(key),
        }
    }

    fn at<T: DeserializeOwned>(&mut self, path: &[Step]) -> Option<T> {
        let mut diagnostics = Vec::new();
        let value = value(self.document, path, &mut diagnostics);
        let out_of_range = ranges::check(self.document, path);
        // A number out of range may have the wrong type too; the range says more.
        diagnostics.retain(|diagnostic| !out_of_range.iter().any(|other| other.location == diagnostic.location));
        self.diagnostics.extend(diagnostics.into_iter().chain(out_of_range));
        value
    }

    fn required<T: DeserializeOwned>(&mut self, key: &str) -> Option<T> {
        if self.document.value.get(key).is_none() && !self.meant.contains(&key) {
            let hint = match key {
                "source" | "target" => format!("say which mesh, e.g. `{key}: {{ rest: mesh.obj }}`"),
                "output" => "say what to write, e.g. `output: out/{pose}.obj`".into(),
                stage => {
                    let types = super::words::types(stage);
                    format!("say how, e.g. `{stage}: {{ type: {} }}`; `mimesh list` shows the types", types.join(" | "))
                }
            };
            self.diagnostics.push(self.document.diagnostic(&[], At::Value, format!("missing key `{key}`")).hint(hint));
        }
        self.optional(key)
    }
}

/// A diagnostic at `path` from a message of serde.
fn diagnostic(document: &Document, path: &[Step], error: &str) -> Diagnostic {
    let stage = stage_at(path);
    let in_type = path.last() == Some(&Step::Key("type".into()));
    let key = path.iter().rev().find_map(|step| if let Step::Key(key) = step { Some(key.as_str()) } else { None });
    let of_stage = if in_type { stage_at(&path[..path.len() - 1]) } else { stage.clone() };
    let told = tell(error, key.unwrap_or("pipeline"), of_stage.as_deref(), &ranges::choices_at(document, path));
    let missing = error.starts_with("missing field");
    let settings = path.iter().try_fold(&document.value, |value, step| step.get(value));
    let name = settings.and_then(|settings| settings.get("type")).and_then(Value::as_str).unwrap_or("TYPE");
    let hint = told.hint.replace("TYPE", name);
    // A stage of unknown type fails as a whole; the word to point at is its type.
    let mut at = path.to_vec();
    if error.starts_with("unknown variant") && stage.is_some() && !in_type {
        at.push(Step::Key("type".into()));
    }
    document.diagnostic(&at, if told.about_key && !missing { At::Key } else { At::Value }, told.message).hint(hint)
}

/// The stage whose settings stand at `path` itself.
pub(super) fn stage_at(path: &[Step]) -> Option<String> {
    let keys: Vec<_> = path.iter().map(Step::to_string).collect();
    let keys: Vec<_> = keys.iter().map(String::as_str).collect();
    match keys[..] {
        ["source" | "target", "generator"] => Some("generator".into()),
        ["key_points" | "proximity" | "correspondence" | "transfer"] => Some(keys[0].into()),
        ["key_points" | "transfer", .., "ranking"] => Some("weights".into()),
        // Stages nested in stages are called as what they are.
        ["key_points" | "transfer", .., key] if plugin::all().iter().any(|plugin| plugin.stage == key) => {
            Some(key.into())
        }
        ["metrics", _] => Some("metric".into()),
        ["formats", _] => Some("format".into()),
        _ => None,
    }
}

fn step(segment: &Segment) -> Option<Step> {
    match segment {
        Segment::Seq { index } => Some(Step::Index(*index)),
        Segment::Map { key } => Some(Step::Key(key.clone())),
        Segment::Enum { variant } => Some(Step::Key(variant.clone())),
        Segment::Unknown => None,
    }
}

/// Takes the value at `path` out and gives its path, or that of the value around it which had to go as a whole; `None`
/// if nothing is left.
///
/// In a list an empty text takes its place, so that those behind it keep their numbers.
fn take_out(value: &mut Value, path: &[Step], removed: &[Vec<Step>]) -> Option<Vec<Step>> {
    for end in (1..=path.len()).rev() {
        let path = &path[..end];
        let (last, parents) = path.split_last()?;
        match (parents.iter().try_fold(&mut *value, |value, step| step.get_mut(value))?, last) {
            (Value::Object(map), Step::Key(key)) if map.contains_key(key) => {
                map.shift_remove(key);
                return Some(path.to_vec());
            }
            (Value::Array(list), Step::Index(index)) if !removed.iter().any(|gone| gone == path) => {
                *list.get_mut(*index)? = Value::String(String::new());
                return Some(path.to_vec());
            }
            _ => {}
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    fn diagnostics(text: &str) -> Vec<String> {
        let document = Document::parse(Path::new("p.yaml"), text).unwrap();
        let (_, diagnostics) = parse(&document);
        diagnostics.iter().map(|m| format!("{m}").lines().next().unwrap_or_default().to_owned()).collect()
    }

    const GOOD: &str = "source: { rest: a.obj, poses: b-*.obj }\ntarget: { rest: c.obj }\n\
        correspondence: { type: test_correspondence }\ntransfer: { type: test_transfer, strength: 2 }\noutput: out/{pose}.obj\n";

    #[test]
    fn a_good_pipeline_has_no_mistakes() {
        assert_eq!(diagnostics(GOOD), Vec::<String>::new());
    }

    #[test]
    fn the_keys_of_the_schema_are_those_that_are_read() {
        let schema = schemars::schema_for!(Pipeline);
        let properties: Vec<_> = schema.get("properties").unwrap().as_object().unwrap().keys().cloned().collect();
        assert_eq!(properties, SLOTS);
        let required = serde_json::json!(["source", "target", "transfer", "output"]);
        assert_eq!(schema.get("required"), Some(&required));
    }

    #[test]
    fn every_mistake_is_told_at_its_own_place() {
        let text = "sorce: {}\nsource:\n  rest: 7\n  pose: x\ntarget: [a]\ncorrespondence: { type: test_corespondence }\n\
            transfer:\n  type: test_transfer\n  strength: much\n  strenght: 1\noutput: { a: 1 }\n\
            metrics: [{ tipe: x }, { type: y }, { type: z }]\n";
        assert_eq!(
            diagnostics(text),
            [
                "p.yaml:1:1: unknown key `sorce`",
                "p.yaml:3:9: `rest`: expected a text, found 7",
                "p.yaml:4:3: unknown key `pose`",
                "p.yaml:5:9: `target`: expected a map of keys, found a list",
                "p.yaml:6:25: unknown correspondence `test_corespondence`",
                "p.yaml:9:13: `strength`: expected a number, found the text \"much\"",
                "p.yaml:10:3: unknown key `strenght`",
                "p.yaml:12:11: missing key `type`",
                "p.yaml:12:32: unknown metric `y`",
                "p.yaml:12:45: unknown metric `z`",
                "p.yaml:11:9: `output`: expected a text or a list of texts, found a map",
            ]
        );
    }

    #[test]
    fn every_wrong_item_of_a_list_is_told_at_its_own_place() {
        let text = GOOD.replace("out/{pose}.obj", "[1, a.obj, [b], c.obj, 2]").replace("b-*.obj", "[x, 3, 4]");
        assert_eq!(
            diagnostics(&text),
            [
                "p.yaml:1:35: `poses`: expected a text, found 3",
                "p.yaml:1:38: `poses`: expected a text, found 4",
                "p.yaml:5:10: `output`: expected a text, found 1",
                "p.yaml:5:20: `output`: expected a text, found a list",
                "p.yaml:5:32: `output`: expected a text, found 2",
            ]
        );
    }

    #[test]
    fn a_number_out_of_its_range_is_told_with_the_range() {
        let text = GOOD.replace("strength: 2", "strength: -1");
        assert_eq!(diagnostics(&text), ["p.yaml:4:44: `strength`: expected at least 0, found -1"]);
    }

    #[test]
    fn a_stage_given_as_a_word_is_told_how_to_write_it() {
        let text = GOOD.replace("{ type: test_correspondence }", "test_correspondence");
        assert!(
            diagnostics(&text)[0]
                .starts_with("p.yaml:3:17: `correspondence`: expected a map that begins with `type`, e.g. `{ type: ")
        );
    }

    #[test]
    fn missing_keys_are_told_together() {
        let all = diagnostics("markers: a.cons\n");
        let missing = ["source", "target", "correspondence", "transfer", "output"];
        assert_eq!(all, missing.map(|key| format!("p.yaml:1:1: missing key `{key}`")));
    }
}
