//! From the values of a document to the typed [`Pipeline`], with all that is wrong at once.
//!
//! Each slot, and each stage of a sequence, is deserialised on its own, so that a mistake in one does not hide those in others.

use mimesh_core::{plugin::StageKind, stage::Transfer};
use mimesh_document::{
    At, Diagnostics, Document, Step, deserialize,
    diagnostic::Result,
    path,
    suggest::{did_you_mean, nearest},
};
use schemars::JsonSchema;
use serde::de::DeserializeOwned;
use serde_json::Value;

use crate::{
    choices::{Open, is_open},
    marker_source::{CLICKS, MarkerSource, ProposedMarkers},
    schema::{COMPOSITION_KEYS, SchemaNode, SchemaShapes, check_aliases, check_ranges, expand_aliases},
    spec::Pipeline,
};

/// Unknown keys that are told one by one.
const MAX_UNKNOWN: usize = 100;

/// Remedy: list the types of all stages.
pub const LIST_TYPES: &str = "list_types";

/// The slots that a command cannot do without.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Required {
    /// Those of a run.
    Run,
    /// The source alone.
    Source,
    /// Both meshes.
    Meshes,
}

impl Required {
    fn needs(self, key: &str) -> bool {
        match self {
            Self::Run => true,
            Self::Source => key == "source",
            Self::Meshes => ["source", "target"].contains(&key),
        }
    }
}

/// A pipeline as far as it could be understood.
#[derive(Debug, Default)]
pub struct Parsed {
    /// The pipeline, without the values that could not be read.
    pub pipeline: Pipeline,
    /// The paths of the slots that have diagnostics.
    pub rejected: Vec<Vec<Step>>,
    /// The slots that are left to the program.
    pub open: Open,
}

/// The keys of a pipeline, in the order of its documentation.
pub fn slots() -> Vec<&'static str> {
    SchemaNode::pipeline().properties(None).into_iter().map(|(key, _)| key).collect()
}

/// The pipeline that `document` declares, as far as it can be understood; what is wrong with it is added to `diagnostics`.
///
/// Of the slots that are missing, only those are reported that `required` names.
pub fn parse(document: &Document, required: Required, diagnostics: &mut Diagnostics) -> Parsed {
    if !document.value.is_object() {
        let hint = "a pipeline begins with e.g. `source: { rest: horse.obj, poses: horse-??.obj }`";
        let message = "expected a mapping with the keys `source`, `target`, `correspondence`, `transfer` and `output`";
        diagnostics.push(document.diagnostic(&[], At::Value, message).hint(hint));
        return Parsed::default();
    }
    let mut slots = Slots { document, required, diagnostics, suggested: vec![], rejected: vec![] };
    slots.check_unknown();
    let pipeline = Pipeline {
        source: slots.required("source").unwrap_or_default(),
        target: slots.required("target").unwrap_or_default(),
        shapes: slots.optional("shapes"),
        key_points: slots.optional("key_points"),
        markers: slots.markers(),
        proximity: slots.stage("proximity"),
        correspondence: slots.stage("correspondence"),
        keep_correspondence: slots.optional("keep_correspondence"),
        transfer: slots.transfer(),
        truth: slots.optional("truth"),
        metrics: slots.list("metrics"),
        pictures: slots.optional("pictures").unwrap_or_default(),
        gates: slots.optional("gates").unwrap_or_default(),
        formats: slots.list("formats").unwrap_or_default(),
        output: slots.required("output").unwrap_or_default(),
        output_unit: slots.optional("output_unit"),
        output_up: slots.optional("output_up"),
    };
    let open = Open::of(document, &slots.suggested);
    Parsed { pipeline, rejected: slots.rejected, open }
}

/// The slots of a pipeline, read one after the other.
struct Slots<'a> {
    document: &'a Document,
    required: Required,
    diagnostics: &'a mut Diagnostics,
    /// Slots that unknown keys were probably meant for; they are not reported as missing as well.
    suggested: Vec<&'static str>,
    /// The paths of slots that have diagnostics.
    rejected: Vec<Vec<Step>>,
}

impl Slots<'_> {
    /// Reports unknown keys, and remembers the slots that they were probably meant for.
    fn check_unknown(&mut self) {
        let slots = slots();
        let known: Vec<&'static str> = COMPOSITION_KEYS.into_iter().chain(slots.iter().copied()).collect();
        let keys = self.document.value.as_object().into_iter().flat_map(|map| map.keys());
        let unknown: Vec<&String> = keys.filter(|key| !slots.contains(&key.as_str())).collect();
        for (i, key) in unknown.iter().enumerate() {
            if i == MAX_UNKNOWN {
                let at = [Step::Key(key.to_string())];
                let message = format!("{} more unknown keys begin here", unknown.len() - i);
                self.diagnostics.push(self.document.diagnostic(&at, At::Key, message).hint("is it a pipeline?"));
                break;
            }
            let meant = nearest(key, &known).filter(|meant| slots.contains(meant));
            self.suggested.extend(meant);
            let hint = did_you_mean(key, &known).unwrap_or_else(|| format!("known keys: {}", known.join(", ")));
            let at = [Step::Key(key.to_string())];
            let message = format!("unknown key `{key}`");
            self.diagnostics.push(self.document.diagnostic(&at, At::Key, message).hint(hint));
        }
    }

    fn optional<T: DeserializeOwned>(&mut self, key: &str) -> Option<T> {
        self.value(&path([key]))
    }

    /// A stage, unless it is left to the program.
    fn stage<T: DeserializeOwned>(&mut self, key: &str) -> Option<T> {
        let value = self.document.value.get(key);
        if is_open(value) || value.is_some_and(Value::is_null) { None } else { self.optional(key) }
    }

    /// The transfer, which a run cannot do without.
    fn transfer(&mut self) -> Option<Box<dyn Transfer>> {
        let at = path(["transfer"]);
        if self.required == Required::Run && self.document.get(&at).is_some_and(Value::is_null) {
            let message = "a run needs a transfer, found none";
            let hint = "leave `transfer` out, and it is chosen by the meshes; or name its type";
            let diagnostic = self.document.diagnostic(&at, At::Value, message).hint(hint);
            self.diagnostics.push(diagnostic.remedy(LIST_TYPES, "", "list the types"));
            self.rejected.push(at);
            return None;
        }
        self.stage("transfer")
    }

    /// The files of markers, or the stage that proposes them, which is a mapping with `type`.
    fn markers(&mut self) -> Option<MarkerSource> {
        let value = self.document.value.get("markers")?;
        if is_open(Some(value)) || value.is_null() {
            return None;
        }
        if value.get("type").is_some() {
            return self.proposed_markers().map(MarkerSource::Stage);
        }
        self.optional("markers").map(MarkerSource::Files)
    }

    /// A stage that proposes markers; the clicks among its settings are no setting of its own.
    fn proposed_markers(&mut self) -> Option<ProposedMarkers> {
        let at = path(["markers", CLICKS]);
        let clicks = match self.document.get(&at) {
            Some(_) => Some(self.value(&at)?),
            None => None,
        };
        let mut alone = self.document.clone();
        if let Some(settings) = alone.get_mut(&path(["markers"])).and_then(Value::as_object_mut) {
            settings.remove(CLICKS);
        }
        let mut slots =
            Slots { document: &alone, diagnostics: self.diagnostics, suggested: vec![], rejected: vec![], ..*self };
        let stage = slots.optional("markers");
        let rejected = slots.rejected;
        self.rejected.extend(rejected);
        Some(ProposedMarkers { stage: stage?, clicks })
    }

    /// A sequence of stages, each read on its own; those that cannot be read are left out.
    fn list<T: DeserializeOwned>(&mut self, key: &str) -> Option<Vec<T>> {
        match self.document.value.get(key).and_then(Value::as_array).map(Vec::len) {
            Some(count) => {
                Some((0..count).filter_map(|i| self.value(&[Step::Key(key.into()), Step::Index(i)])).collect())
            }
            None => self.optional(key),
        }
    }

    fn value<T: DeserializeOwned>(&mut self, path: &[Step]) -> Option<T> {
        let (value, wrong) = checked_value(SchemaNode::pipeline(), self.document, path);
        if !wrong.is_empty() {
            self.rejected.push(path.to_vec());
        }
        self.diagnostics.extend(wrong);
        value
    }

    fn required<T: DeserializeOwned>(&mut self, key: &str) -> Option<T> {
        let missing = self.document.value.get(key).is_none() && self.required.needs(key);
        if missing && !self.suggested.contains(&key) {
            let diagnostic = self.document.diagnostic(&[], At::Value, format!("missing key `{key}`"));
            self.diagnostics.push(match key {
                "source" | "target" => diagnostic.hint(format!("name the mesh, e.g. `{key}: {{ rest: mesh.obj }}`")),
                _ => diagnostic.hint("name the files to write, e.g. `output: out/{pose}.obj`"),
            });
        }
        self.optional(key)
    }
}

/// The value at `path`, and what is wrong with it; `root` is the schema of the whole document.
fn checked_value<T: DeserializeOwned>(
    root: SchemaNode<'static>,
    document: &Document,
    path: &[Step],
) -> (Option<T>, Diagnostics) {
    let mut wrong = Diagnostics::default();
    check_aliases(root, document, path, &mut wrong);
    let value = deserialize(&expand_aliases(root, document, path), path, &SchemaShapes(root), &mut wrong);
    let mut out_of_range = Diagnostics::default();
    check_ranges(root, document, path, &mut out_of_range);
    // A number out of range may have the wrong type too; its range says more.
    wrong.list.retain(|one| !out_of_range.list.iter().any(|other| other.location == one.location));
    wrong.extend(out_of_range);
    (value, wrong)
}

/// The stage of the kind `S` that `document`, its settings alone, describes; they are checked as in a pipeline.
///
/// # Errors
///
/// All that is wrong with them.
pub fn parse_stage<S: StageKind + JsonSchema + ?Sized>(document: &Document) -> Result<Box<S>>
where
    Box<S>: DeserializeOwned,
{
    let (stage, wrong) = checked_value(SchemaNode::of_kind::<S>(), document, &[]);
    wrong.into_result()?;
    stage.ok_or_else(|| document.diagnostic(&[], At::Value, "no settings of a stage").into())
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    fn diagnostics(text: &str) -> Vec<String> {
        let document = Document::parse(Path::new("p.yaml"), text).unwrap();
        let mut diagnostics = Diagnostics::default();
        parse(&document, Required::Run, &mut diagnostics);
        diagnostics.list.iter().map(|m| format!("{m}").lines().next().unwrap_or_default().to_owned()).collect()
    }

    const GOOD: &str = "source: { rest: a.obj, poses: b-*.obj }\ntarget: { rest: c.obj }\n\
        correspondence: { type: test_correspondence }\ntransfer: { type: test_transfer, strength: 2 }\noutput: out/{pose}.obj\n";

    #[test]
    fn a_good_pipeline_has_no_mistakes() {
        assert_eq!(diagnostics(GOOD), Vec::<String>::new());
    }

    #[test]
    fn every_key_of_the_schema_is_read() {
        // No slot takes a sequence of sequences.
        for key in slots() {
            let found = diagnostics(&format!("{key}: [[[]]]\n"));
            assert!(
                found.iter().any(|one| one.starts_with("p.yaml:1:") && !one.contains("missing")),
                "{key}: {found:?}"
            );
        }
        let schema = schemars::schema_for!(Pipeline);
        let required = serde_json::json!(["source", "target", "output"]);
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
                "p.yaml:3:9: `rest`: expected a path, or a mapping `{ file: …, meshes: […] }`, found 7",
                "p.yaml:4:3: unknown key `pose`",
                "p.yaml:5:9: `target`: expected a mapping of keys, found a sequence",
                "p.yaml:6:25: unknown correspondence `test_corespondence`",
                "p.yaml:9:13: `strength`: expected a number, found the string \"much\"",
                "p.yaml:10:3: unknown key `strenght`",
                "p.yaml:12:11: missing key `type`",
                "p.yaml:12:32: unknown metric `y`",
                "p.yaml:12:45: unknown metric `z`",
                "p.yaml:11:9: `output`: expected a string or a sequence of strings, found a mapping",
            ]
        );
    }

    #[test]
    fn every_wrong_item_of_a_list_is_told_at_its_own_place() {
        let text = GOOD.replace("out/{pose}.obj", "[1, a.obj, [b], c.obj, 2]").replace("b-*.obj", "[x, 3, 4]");
        assert_eq!(
            diagnostics(&text),
            [
                "p.yaml:1:35: `poses`: expected a string, found 3",
                "p.yaml:1:38: `poses`: expected a string, found 4",
                "p.yaml:5:10: `output`: expected a string, found 1",
                "p.yaml:5:20: `output`: expected a string, found a sequence",
                "p.yaml:5:32: `output`: expected a string, found 2",
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
            diagnostics(&text)[0].starts_with(
                "p.yaml:3:17: `correspondence`: expected a mapping that begins with `type`, e.g. `{ type: "
            )
        );
    }

    #[test]
    fn a_stage_alone_is_checked_as_in_a_pipeline() {
        let read = |text: &str| {
            let document = Document::parse(Path::new("stage"), text).unwrap();
            parse_stage::<dyn Transfer>(&document).map_err(|wrong| wrong.list[0].message.clone())
        };
        assert_eq!(read("{ type: test_transfer, strength: 2 }").unwrap().typetag_name(), "test_transfer");
        let refused = |text: &str| read(text).unwrap_err();
        let message = refused("{ type: test_transfer, strength: -1 }");
        assert_eq!(message, "`strength`: expected at least 0, found -1");
        assert_eq!(refused("{ type: test_transfer, strenght: 1 }"), "unknown key `strenght`");
        assert_eq!(refused("{ type: test_transfre }"), "unknown transfer `test_transfre`");
    }

    #[test]
    fn missing_keys_are_told_together() {
        let all = diagnostics("markers: a.cons\n");
        let missing = ["source", "target", "output"];
        assert_eq!(all, missing.map(|key| format!("p.yaml:1:1: missing key `{key}`")));
    }
}
