//! `${name}`: a value of `variables`; `${env:NAME}`: a variable of the environment; `$${`: a `${` as it stands.

use std::{
    collections::{BTreeSet, HashMap},
    path::Path,
    sync::Arc,
};

use serde_json::Value;

use crate::{
    describe::describe,
    diagnostic::{Diagnostic, Diagnostics, Kind, Location},
    document::Document,
    limits::{MAX_EXPANDED, MAX_VARIABLE_DEPTH, thousands},
    source_tree::{SourceSpan, SpanTree},
    step::Step,
    suggest::{did_you_mean, nearest},
};

/// What came of putting variables in.
#[derive(Debug, Default)]
pub struct Substituted {
    /// Variables that are not there, and the like.
    pub diagnostics: Diagnostics,
    /// The values that stay as they were for that reason; diagnostics of those follow.
    pub suppressed: Vec<Location>,
    /// The variables that were used.
    pub used: BTreeSet<String>,
    /// The variables that were probably meant by names that are not there.
    pub suggested: BTreeSet<String>,
    /// The variables that there are, with the places of their names.
    pub defined: Vec<(String, SourceSpan)>,
}

/// Puts the values of `variables` where they are used, and takes the key out.
pub fn substitute(document: &mut Document) -> Substituted {
    let mut result = Substituted::default();
    let given = document.take("variables");
    let (values, node) = match given {
        None => (Value::Null, None),
        Some((values @ (Value::Object(_) | Value::Null), part)) => (values, Some(part.node)),
        Some((other, part)) => {
            let message = format!("`variables`: expected a mapping of names and values, found {}", describe(&other));
            let diagnostic = Diagnostic::new(Kind::BadPipeline, message).at(part.node.span.location());
            result.diagnostics.push(diagnostic.hint("e.g. `variables: { data: ../data }`"));
            (Value::Null, None)
        }
    };
    for name in values.as_object().into_iter().flat_map(|map| map.keys()) {
        let part = node.as_ref().and_then(|node| node.part(&Step::Key(name.clone())));
        let span = part.map(|part| &part.key).or(node.as_ref().map(|node| &node.span));
        let Some(span) = span else { continue };
        if !name.chars().all(|c| c.is_alphanumeric() || "_-.".contains(c)) || name.is_empty() {
            let message = format!("`{name}` cannot be the name of a variable");
            let hint = "names have letters, digits, `_`, `-` and `.`";
            result.diagnostics.push(Diagnostic::new(Kind::BadPipeline, message).at(span.location()).hint(hint));
        }
        result.defined.push((name.clone(), span.clone()));
    }
    let mut expander = Expander {
        values: &values,
        node: node.as_ref(),
        result: &mut result,
        within: vec![],
        known: HashMap::new(),
        size: 0,
        is_full: false,
    };
    expander.visit(&mut document.value, &mut document.root);
    result
}

struct Expander<'a> {
    values: &'a Value,
    node: Option<&'a SpanTree>,
    result: &'a mut Substituted,
    /// The variables whose values are being put in.
    within: Vec<String>,
    /// Variables whose values are known; `None` for those that have none.
    known: HashMap<String, Option<Arc<Expanded>>>,
    /// What was put in so far.
    size: usize,
    /// Whether that is more than may be put in: what follows needs no diagnostic.
    is_full: bool,
}

/// A value in which variables are put in, and its places.
struct Expanded {
    value: Value,
    node: SpanTree,
    size: usize,
}

/// How much room `value` takes: its values, and one for each hundred bytes of text.
fn size(value: &Value) -> usize {
    1 + match value {
        Value::String(text) => text.len() / 100,
        Value::Array(list) => list.iter().map(size).sum(),
        Value::Object(map) => map.iter().map(|(key, value)| key.len() / 100 + size(value)).sum(),
        _ => 0,
    }
}

/// A piece of a text.
enum Piece<'t> {
    Plain(&'t str),
    Variable(&'t str),
}

impl Expander<'_> {
    fn visit(&mut self, value: &mut Value, node: &mut SpanTree) {
        match value {
            Value::Object(map) => {
                for (key, value) in map {
                    self.visit(value, &mut node.part_mut(&Step::Key(key.clone())).node);
                }
            }
            Value::Array(list) => {
                for (i, value) in list.iter_mut().enumerate() {
                    self.visit(value, &mut node.part_mut(&Step::Index(i)).node);
                }
            }
            Value::String(text) if text.contains("${") => {
                let text = std::mem::take(text);
                *value = self.text(text, node);
            }
            _ => {}
        }
    }

    /// The value of a text with variables; the text itself if one of them has none.
    fn text(&mut self, text: String, node: &mut SpanTree) -> Value {
        let pieces = match pieces(&text) {
            Ok(pieces) => pieces,
            Err(open) => {
                let hint = "close it: `${name}`; a `${` that is none is written `$${`";
                self.wrong(node, open, "`${` without `}`".into(), hint.into());
                return Value::String(text);
            }
        };
        if let [Piece::Variable(name)] = pieces[..] {
            return match self.value(name, node) {
                Some((value, from)) => {
                    if let Some(from) = from {
                        node.folder = from.folder;
                        node.parts = from.parts;
                    }
                    value
                }
                None => Value::String(text),
            };
        }
        let mut result = String::new();
        let mut folder: Option<Arc<Path>> = None;
        let mut known = true;
        for (i, piece) in pieces.iter().enumerate() {
            match piece {
                Piece::Plain(plain) => result += plain,
                Piece::Variable(name) => match self.value(name, node) {
                    Some((Value::String(text), from)) => {
                        if i == 0 {
                            folder = from.map(|from| from.folder);
                        }
                        result += &text;
                    }
                    Some((value @ (Value::Number(_) | Value::Bool(_)), _)) => result += &value.to_string(),
                    Some((other, _)) => {
                        let message =
                            format!("variable `{name}` is {}, which cannot stand in a string", describe(&other));
                        self.wrong(node, &format!("${{{name}}}"), message, "let it be the whole value".into());
                        known = false;
                    }
                    None => known = false,
                },
            }
        }
        if let Some(folder) = folder {
            node.folder = folder;
        }
        Value::String(if known { result } else { text })
    }

    /// The value of a variable, in which others are put in, and its places.
    fn value(&mut self, name: &str, node: &SpanTree) -> Option<(Value, Option<SpanTree>)> {
        let written = format!("${{{name}}}");
        if let Some(name) = name.strip_prefix("env:") {
            return match std::env::var(name) {
                Ok(text) => Some((scalar(text), None)),
                Err(std::env::VarError::NotPresent) => {
                    let message = format!("there is no variable `{name}` in the environment");
                    self.wrong(node, &written, message, "set it before the program starts".into());
                    None
                }
                Err(std::env::VarError::NotUnicode(_)) => {
                    let message = format!("the variable `{name}` of the environment is no Unicode");
                    self.wrong(node, &written, message, "give it another value: a pipeline is text in UTF-8".into());
                    None
                }
            };
        }
        let Some(value) = self.values.get(name) else {
            let known: Vec<_> = self.values.as_object().into_iter().flat_map(|map| map.keys()).collect();
            self.result.suggested.extend(nearest(name, &known).map(|name| name.to_string()));
            let hint = did_you_mean(name, &known).unwrap_or_else(|| match &known[..] {
                [] => format!("define it: `variables: {{ {name}: … }}`"),
                known => format!("variables: {}", known.iter().map(|n| n.as_str()).collect::<Vec<_>>().join(", ")),
            });
            self.wrong(node, &written, format!("undefined variable `{name}`"), hint);
            return None;
        };
        self.result.used.insert(name.to_owned());
        if self.within.iter().any(|other| other == name) {
            let circle = self.within.iter().map(String::as_str).chain([name]).collect::<Vec<_>>().join(" uses ");
            let message = format!("variables use each other in a circle: {circle}");
            self.wrong(node, &written, message, "give one of them a value of its own".into());
            return None;
        }
        let value = self.expanded(name, value, node);
        let known = value.filter(|value| self.has_room(value.size, node, &written));
        match known {
            Some(value) => Some((value.value.clone(), Some(value.node.clone()))),
            None => {
                self.result.suppressed.push(node.span.location());
                None
            }
        }
    }

    /// The value of the variable `name`, in which others are put in once and for all; `node` uses it.
    fn expanded(&mut self, name: &str, value: &Value, node: &SpanTree) -> Option<Arc<Expanded>> {
        if let Some(known) = self.known.get(name) {
            return known.clone();
        }
        if self.within.len() >= MAX_VARIABLE_DEPTH {
            let message = format!("more than {MAX_VARIABLE_DEPTH} variables use each other in a row");
            self.wrong(node, &format!("${{{name}}}"), message, "give one of them a value of its own".into());
            return None;
        }
        let mut value = value.clone();
        let part = self.node.and_then(|node| node.part(&Step::Key(name.into())));
        let mut from = part.map_or_else(|| node.clone(), |part| part.node.clone());
        self.within.push(name.into());
        let before = self.result.diagnostics.len();
        self.visit(&mut value, &mut from);
        self.within.pop();
        let is_fine = self.result.diagnostics.len() == before && !self.is_full;
        let expanded = is_fine.then(|| Arc::new(Expanded { size: size(&value), value, node: from }));
        self.known.insert(name.into(), expanded.clone());
        expanded
    }

    /// Whether another `size` can be put in at `node`, where `written` stands; else there is one diagnostic.
    fn has_room(&mut self, size: usize, node: &SpanTree, written: &str) -> bool {
        if self.is_full {
            return false;
        }
        self.size = self.size.saturating_add(size);
        if self.size <= MAX_EXPANDED {
            return true;
        }
        let message = format!("variables make more than {} values of the file", thousands(MAX_EXPANDED));
        self.wrong(
            node,
            written,
            message,
            "let variables repeat each other less often, and write shorter texts".into(),
        );
        self.is_full = true;
        false
    }

    fn wrong(&mut self, node: &SpanTree, part: &str, message: String, hint: String) {
        let location = node.span.within(part).location();
        self.result.diagnostics.push(Diagnostic::new(Kind::BadPipeline, message).at(location).hint(hint));
        self.result.suppressed.push(node.span.location());
    }
}

/// What a text of the environment says: a number, true or false, else itself.
fn scalar(text: String) -> Value {
    match serde_json::from_str(&text) {
        Ok(value @ (Value::Number(_) | Value::Bool(_))) => value,
        _ => Value::String(text),
    }
}

/// The pieces of a text.
///
/// # Errors
///
/// What follows a `${` that is not closed.
fn pieces(text: &str) -> Result<Vec<Piece<'_>>, &str> {
    let mut pieces = Vec::new();
    let mut rest = text;
    while let Some(at) = rest.find("${") {
        if rest[..at].ends_with('$') {
            // The two signs before the brace are one.
            pieces.extend([Piece::Plain(&rest[..at]), Piece::Plain("{")]);
            rest = &rest[at + 2..];
            continue;
        }
        if at > 0 {
            pieces.push(Piece::Plain(&rest[..at]));
        }
        let (name, after) = rest[at + 2..].split_once('}').ok_or(&rest[at..])?;
        pieces.push(Piece::Variable(name));
        rest = after;
    }
    if !rest.is_empty() {
        pieces.push(Piece::Plain(rest));
    }
    Ok(pieces)
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn put_in(text: &str) -> (Value, Vec<String>) {
        let mut document = Document::parse(Path::new("p.yaml"), text).unwrap();
        let result = substitute(&mut document);
        let first = |diagnostic: &Diagnostic| diagnostic.to_string().lines().next().unwrap_or_default().to_owned();
        (document.value, result.diagnostics.list.iter().map(first).collect())
    }

    #[test]
    fn whole_values_keep_their_type_and_texts_take_numbers() {
        let text = "variables: { n: 0.5, d: ../data, all: [1, 2], m: { type: x, k: ${n} } }\n\
            a: ${n}\nb: '${d}/l-${n}.obj'\nc: ${all}\nd: ${m}\ne: $${n}\nf: [${n}, ${d}/x]\n";
        let expected = json!({
            "a": 0.5, "b": "../data/l-0.5.obj", "c": [1, 2], "d": { "type": "x", "k": 0.5 }, "e": "${n}",
            "f": [0.5, "../data/x"],
        });
        assert_eq!(put_in(text), (expected, vec![]));
    }

    #[test]
    fn what_is_not_there_is_told_at_its_own_place() {
        let text =
            "variables: { lambda: 1, m: {} }\na: x-${lamda}.obj\nb: '${m}/x'\nc: a${b\nd: ${env:MIMESH_NOT_SET}\n";
        assert_eq!(
            put_in(text).1,
            [
                "p.yaml:2:6: undefined variable `lamda`",
                "p.yaml:3:5: variable `m` is a mapping, which cannot stand in a string",
                "p.yaml:4:5: `${` without `}`",
                "p.yaml:5:4: there is no variable `MIMESH_NOT_SET` in the environment",
            ]
        );
    }

    #[test]
    fn variables_may_use_others_but_not_in_a_circle() {
        assert_eq!(put_in("variables: { a: x, b: ${a}/y }\nc: ${b}/z\n").0, json!({ "c": "x/y/z" }));
        let circle = put_in("variables: { a: ${b}, b: '1${a}' }\nc: ${a}\nd: ${b}\n").1;
        assert_eq!(circle, ["p.yaml:1:28: variables use each other in a circle: a uses b uses a"]);
    }

    /// Variables `v0` to `v9`, of which each uses the one before ten times, as `item` repeats it.
    fn bomb(item: impl Fn(&str) -> String) -> String {
        let line = |i: usize| match i {
            0 => "  v0: x\n".to_owned(),
            i => format!("  v{i}: {}\n", item(&format!("${{v{}}}", i - 1))),
        };
        let lines: String = (0..10).map(line).collect();
        format!("variables:\n{lines}a: ${{v9}}\nb: ${{v9}}\nc: ${{v1}}\n")
    }

    #[test]
    fn a_few_variables_cannot_ask_for_endless_work() {
        for text in [bomb(|one| format!("[{}]", [one; 10].join(", "))), bomb(|one| format!("'{}'", one.repeat(10)))] {
            let found = put_in(&text).1;
            assert_eq!(found.len(), 1, "{found:?}");
            assert!(found[0].ends_with("variables make more than 250,000 values of the file"), "{found:?}");
        }
        let chain: String = (1..6000).map(|i| format!("  v{i}: ${{v{}}}\n", i - 1)).collect();
        let found = put_in(&format!("variables:\n  v0: x\n{chain}a: ${{v5999}}\n")).1;
        assert_eq!(found.len(), 1, "{found:?}");
        assert!(found[0].ends_with("more than 64 variables use each other in a row"), "{found:?}");
    }

    #[test]
    fn variables_that_others_share_are_put_in_once_and_stand_everywhere() {
        let text = "variables: { a: x, b: ['${a}', '${a}'], c: [\"${b}\", '${b}'] }\nd: ${c}\ne: ${b}\n";
        let b = json!(["x", "x"]);
        assert_eq!(put_in(text).0, json!({ "d": [b, b], "e": b }));
    }
}
