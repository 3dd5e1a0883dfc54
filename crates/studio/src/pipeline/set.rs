//! Setting one value in a YAML text; comments and the order of all else stay.
//!
//! The smallest stretch of the text is changed with which the text comes to mean what it should: the value itself, a new line for its
//! key, or else the value around it. Each attempt is read back and compared, so that no attempt can change another value.

use mimesh_document::{
    Step,
    braces::{guarded, restored},
    yaml::yaml_value,
};
use saphyr::{LoadableYamlNode, MarkedYaml, Scalar, YamlData};
use serde_json::{Map, Value};

use super::written::{block, flow, scalar};

/// The text with `value` at `path`; without one, the key is taken away.
///
/// # Errors
///
/// A sentence if the text is no YAML, or if nothing on the path can hold the value.
pub fn set(text: &str, path: &[Step], value: Option<&Value>) -> Result<String, String> {
    if path.is_empty() || path.len() > 64 {
        return Err("expected a path of 1 to 64 steps".into());
    }
    let before = if text.trim().is_empty() { Value::Null } else { parse(text)? };
    let wanted = with(&before, path, value)?;
    if wanted == before {
        return Ok(text.into());
    }
    let guarded_text = guarded(text);
    let trees = MarkedYaml::load_from_str(&guarded_text).map_err(|error| format!("the text is no YAML: {error}"))?;
    let source = Source { text: guarded_text.chars().collect() };
    let attempts = (1..=path.len()).rev().flat_map(|depth| {
        let prefix = &path[..depth];
        let part = at(&wanted, prefix);
        let root = trees.first();
        [source.replaced(root, prefix, part), source.inserted(root, prefix, part), source.removed(root, prefix, part)]
    });
    let fits = |text: &String| parse(text).is_ok_and(|value| value == wanted);
    let whole = || Some(block(&wanted)).filter(|_| before.is_null());
    let found = attempts.flatten().map(|text| restored(&text)).find(fits).or_else(|| whole().filter(fits));
    found.ok_or_else(|| "the text is written in a way in which this value cannot be set alone".into())
}

fn parse(text: &str) -> Result<Value, String> {
    yaml_value(text).map_err(|error| format!("the text is no YAML: {}", error.without_snippet()))
}

/// `before` with `value` at `path`.
fn with(before: &Value, path: &[Step], value: Option<&Value>) -> Result<Value, String> {
    let Some((step, rest)) = path.split_first() else { return Ok(value.cloned().unwrap_or_default()) };
    let is_last = rest.is_empty();
    match step {
        Step::Key(key) => {
            let mut map = match before {
                Value::Object(map) => map.clone(),
                Value::Null => Map::new(),
                _ => return Err(format!("`{key}` cannot be set within a value that is no mapping")),
            };
            if is_last && value.is_none() {
                map.shift_remove(key);
            } else {
                let inner = with(map.get(key).unwrap_or(&Value::Null), rest, value)?;
                map.insert(key.clone(), inner);
            }
            Ok(Value::Object(map))
        }
        Step::Index(i) => {
            let mut list = match before {
                Value::Array(list) => list.clone(),
                Value::Null => vec![],
                _ => return Err(format!("item {i} cannot be set within a value that is no sequence")),
            };
            match i {
                i if *i > list.len() => return Err(format!("item {i} of a sequence of {}", list.len())),
                i if is_last && value.is_none() => _ = (*i < list.len()).then(|| list.remove(*i)),
                i if *i == list.len() => list.push(with(&Value::Null, rest, value)?),
                i => list[*i] = with(&list[*i], rest, value)?,
            }
            Ok(Value::Array(list))
        }
    }
}

fn at<'v>(value: &'v Value, path: &[Step]) -> Option<&'v Value> {
    path.iter().try_fold(value, |value, step| match step {
        Step::Key(key) => value.get(key),
        Step::Index(i) => value.get(i),
    })
}

/// The text, by characters.
struct Source {
    text: Vec<char>,
}

impl Source {
    /// The text with the value at `path` replaced.
    fn replaced(&self, root: Option<&MarkedYaml<'_>>, path: &[Step], value: Option<&Value>) -> Option<String> {
        let (key, node) = find(root?, path)?;
        let start = node.span.start.index();
        let end = self.end_of(node);
        match key {
            // A key without a value has no place but that after its colon.
            Some(key) if start >= end || self.slice(start, end).trim().is_empty() => {
                let colon = self.colon_after(key)?;
                Some(self.splice(colon + 1, colon + 1, &format!(" {}", flow(value?))))
            }
            _ => Some(self.splice(start, end, &flow(value?))),
        }
    }

    /// The text with a key more in the mapping that the last step of `path` belongs to.
    fn inserted(&self, root: Option<&MarkedYaml<'_>>, path: &[Step], value: Option<&Value>) -> Option<String> {
        let (Step::Key(key), parents) = path.split_last()? else { return None };
        let line = format!("{}: {}", scalar(key), flow(value?));
        let parent = if parents.is_empty() { root? } else { find(root?, parents)?.1 };
        let YamlData::Mapping(entries) = &parent.data else { return None };
        let (first, _) = entries.iter().next()?;
        let (last_key, last) = entries.iter().next_back()?;
        let end = self.end_of(last).max(self.colon_after(last_key)? + 1);
        let is_flow = self.text.get(parent.span.start.index()) == Some(&'{');
        if is_flow {
            return Some(self.splice(end, end, &format!(", {line}")));
        }
        // After what else stands in the line, such as a comment.
        let end = (end..self.text.len()).find(|i| self.text[*i] == '\n').unwrap_or(self.text.len());
        Some(self.splice(end, end, &format!("\n{}{line}", " ".repeat(first.span.start.col()))))
    }

    /// The text without the lines of the key at the end of `path`.
    fn removed(&self, root: Option<&MarkedYaml<'_>>, path: &[Step], value: Option<&Value>) -> Option<String> {
        if value.is_some() {
            return None;
        }
        let (key, node) = find(root?, path)?;
        let key = key?;
        let start = (0..key.span.start.index()).rev().find(|i| self.text[*i] == '\n').map_or(0, |i| i + 1);
        let end = self.end_of(node).max(self.colon_after(key)? + 1);
        let end = (end..self.text.len()).find(|i| self.text[*i] == '\n').map_or(self.text.len(), |i| i + 1);
        Some(self.splice(start, end, ""))
    }

    /// The end of a value without the blanks and comments after it.
    fn end_of(&self, node: &MarkedYaml<'_>) -> usize {
        let start = node.span.start.index();
        let mut end = node.span.end.index().min(self.text.len());
        // The end of a block lies where the next one begins.
        if let YamlData::Mapping(entries) = &node.data
            && self.text.get(start) != Some(&'{')
        {
            let ends = entries.iter().map(|(key, value)| self.end_of(value).max(key.span.end.index()));
            return ends.max().unwrap_or(end);
        }
        if let YamlData::Sequence(items) = &node.data
            && self.text.get(start) != Some(&'[')
        {
            return items.iter().map(|item| self.end_of(item)).max().unwrap_or(end);
        }
        // The span of a flow collection ends before its bracket.
        let closing = match self.text.get(start) {
            Some('[') => Some(']'),
            Some('{') => Some('}'),
            _ => None,
        };
        if closing.is_some() && self.text.get(end).copied() == closing {
            return end + 1;
        }
        while end > start && self.text[end - 1].is_whitespace() {
            end -= 1;
        }
        end
    }

    /// The colon after a key.
    fn colon_after(&self, key: &MarkedYaml<'_>) -> Option<usize> {
        (key.span.end.index()..self.text.len()).find(|i| self.text[*i] == ':')
    }

    fn slice(&self, start: usize, end: usize) -> String {
        self.text.get(start..end).unwrap_or_default().iter().collect()
    }

    fn splice(&self, start: usize, end: usize, new: &str) -> String {
        self.slice(0, start) + new + &self.slice(end, self.text.len())
    }
}

/// The value at `path` with its key, if it has one.
fn find<'t, 'i>(root: &'t MarkedYaml<'i>, path: &[Step]) -> Option<(Option<&'t MarkedYaml<'i>>, &'t MarkedYaml<'i>)> {
    let mut found = (None, root);
    for step in path {
        found = match (step, &found.1.data) {
            (Step::Key(name), YamlData::Mapping(entries)) => {
                let (key, value) = entries.iter().find(|(key, _)| is_key(key, name))?;
                (Some(key), value)
            }
            (Step::Index(i), YamlData::Sequence(items)) => (None, items.get(*i)?),
            _ => return None,
        };
    }
    Some(found)
}

fn is_key(key: &MarkedYaml<'_>, name: &str) -> bool {
    match &key.data {
        YamlData::Value(Scalar::String(text)) => restored(text) == name,
        YamlData::Value(Scalar::Integer(number)) => number.to_string() == name,
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use mimesh_document::path;
    use proptest::prelude::*;
    use serde_json::json;

    use super::*;

    const TEXT: &str = "# top\nsource:\n  rest: a.obj   # the horse\n  poses: [a-{pose}.obj, b]\ntarget: { rest: b.obj }\n\n# how\n\
        transfer:\n  type: gradient\n  # inner\n  k: 2\noutput: out/{pose}.obj # end\n";

    fn keys<'k>(keys: impl Iterator<Item = &'k str>) -> Vec<Step> {
        keys.map(|key| Step::Key(key.into())).collect()
    }

    fn done(at: &[&str], value: Option<Value>) -> String {
        set(TEXT, &keys(at.iter().copied()), value.as_ref()).unwrap()
    }

    #[test]
    fn only_the_value_changes() {
        let changed = done(&["transfer", "k"], Some(json!(0.5)));
        assert_eq!(changed, TEXT.replace("k: 2", "k: 0.5"));
        let changed = done(&["source", "rest"], Some(json!("c d.obj")));
        assert_eq!(changed, TEXT.replace("a.obj   #", "\"c d.obj\"   #"));
        let changed = done(&["target", "mirrored"], Some(json!("x")));
        assert_eq!(changed, TEXT.replace("{ rest: b.obj }", "{ rest: b.obj, mirrored: x }"));
        let changed = done(&["transfer", "weights", "type"], Some(json!("harmonic")));
        assert_eq!(changed, TEXT.replace("k: 2\n", "k: 2\n  weights: { type: harmonic }\n"));
        let changed = done(&["markers"], Some(json!("pairs.yaml")));
        assert_eq!(changed, TEXT.replace("# end\n", "# end\nmarkers: pairs.yaml\n"));
        assert_eq!(done(&["transfer", "k"], None), TEXT.replace("  k: 2\n", ""));
        assert_eq!(done(&["target", "rest"], None), TEXT.replace("{ rest: b.obj }", "{}"));
        assert_eq!(done(&["nothing"], None), TEXT);
    }

    #[test]
    fn an_empty_text_and_keys_without_values_take_values() {
        assert_eq!(set("", &path(["a", "b"]), Some(&json!(1))).unwrap(), "a: { b: 1 }\n");
        assert_eq!(set("a:\nb: 1\n", &path(["a"]), Some(&json!("x"))).unwrap(), "a: x\nb: 1\n");
        assert!(set("a: [", &path(["a"]), Some(&json!(1))).is_err());
        assert!(set("a: 1", &path(["a", "b"]), Some(&json!(1))).is_err());
    }

    fn value() -> impl Strategy<Value = Value> {
        let leaf = prop_oneof![
            Just(Value::Null),
            any::<bool>().prop_map(Value::from),
            any::<i32>().prop_map(Value::from),
            (-1e6..1e6f64).prop_map(Value::from),
            "[ -~]{0,8}".prop_map(Value::from),
        ];
        leaf.prop_recursive(3, 16, 4, |inner| {
            prop_oneof![
                prop::collection::vec(inner.clone(), 0..4).prop_map(Value::from),
                prop::collection::btree_map("[a-z]{1,5}", inner, 0..4)
                    .prop_map(|map| Value::Object(map.into_iter().collect())),
            ]
        })
    }

    proptest! {
        #[test]
        fn what_is_set_is_read_back_and_all_else_stays(
            value in value(), at in prop::sample::select(vec!["source.rest", "source.poses", "target", "target.new", "transfer", "transfer.k", "output", "new.inner"]),
        ) {
            let path = keys(at.split('.'));
            let text = set(TEXT, &path, Some(&value)).unwrap();
            prop_assert_eq!(parse(&text).unwrap(), with(&parse(TEXT).unwrap(), &path, Some(&value)).unwrap());
            prop_assert!(text.starts_with("# top\n"));
        }

        #[test]
        fn no_text_makes_it_panic(text in "[ -~\n]{0,60}", at in "[a-z]{1,3}") {
            let _ = set(&text, &[Step::Key(at)], Some(&json!({ "a": [1] })));
        }
    }
}
