//! Serde's messages in the words of someone who writes YAML.

use crate::{shapes::Variants, suggest::did_you_mean};

/// A message, its hint, and whether it is about a key rather than a value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Rephrased {
    /// What is wrong.
    pub message: String,
    /// The way out; may be empty.
    pub hint: String,
    /// Whether the key is wrong, not its value.
    pub about_key: bool,
    /// Whether the message is that a key is missing.
    pub missing: bool,
}

impl Rephrased {
    fn of_value(message: String, hint: String) -> Self {
        Self { message, hint, about_key: false, missing: false }
    }
}

/// Rephrases `error`, met at the key `key` (the last of its path).
///
/// `variants` are the settings that belong there, if the value is told apart by `type`; `choices` are the words that the value
/// may be, if it is one of several.
pub fn rephrase(error: &str, key: &str, variants: Option<&Variants>, choices: &[String]) -> Rephrased {
    let mut quoted = error.split('`').skip(1).step_by(2);
    if let Some(rest) = error.strip_prefix("unknown field ") {
        let found = quoted.next().unwrap_or(rest);
        let known: Vec<_> = quoted.collect();
        let hint = if known.is_empty() {
            "it has no settings; remove the key".into()
        } else {
            did_you_mean(found, &known).unwrap_or_else(|| format!("known keys: {}", known.join(", ")))
        };
        return Rephrased { message: format!("unknown key `{found}`"), hint, about_key: true, missing: false };
    }
    if let Some(rest) = error.strip_prefix("unknown variant ") {
        let found = quoted.next().unwrap_or(rest).to_owned();
        if let Some(variants) = variants {
            return unknown_type(variants, &found);
        }
        let listed: Vec<_> = quoted.map(str::to_owned).collect();
        let hint = did_you_mean(&found, &listed);
        let hint = hint.unwrap_or_else(|| format!("known values: {}", listed.join(", ")));
        return Rephrased::of_value(format!("`{key}`: unknown value `{found}`"), hint);
    }
    if error.starts_with("missing field") {
        let missing = quoted.next().unwrap_or_default();
        let hint = match variants {
            Some(variants) if missing == "type" => format!("known types: {}", variants.types.join(", ")),
            _ => String::new(),
        };
        return Rephrased { message: format!("missing key `{missing}`"), hint, about_key: true, missing: true };
    }
    let wrong = error.strip_prefix("invalid type: ").or_else(|| error.strip_prefix("invalid value: "));
    if let Some((found, expected)) = wrong.and_then(|wrong| wrong.rsplit_once(", expected ")) {
        let expected = match choices {
            [] => expectation(key, expected, variants),
            _ => format!("one of {}", choices.join(", ")),
        };
        return Rephrased::of_value(format!("`{key}`: expected {expected}, found {}", finding(found)), String::new());
    }
    Rephrased::of_value(format!("`{key}`: {error}"), String::new())
}

/// The message that `found` is no type of `variants`.
pub fn unknown_type(variants: &Variants, found: &str) -> Rephrased {
    let Variants { kind, types } = variants;
    let hint = if types.is_empty() {
        format!("no {kind} is linked into this program")
    } else {
        did_you_mean(found, types).unwrap_or_else(|| format!("known types: {}", types.join(", ")))
    };
    Rephrased::of_value(format!("unknown {kind} `{found}`"), hint)
}

fn expectation(key: &str, expected: &str, variants: Option<&Variants>) -> String {
    match expected {
        "f64" | "f32" => "a number".into(),
        "u8" | "u16" | "u32" | "u64" | "usize" | "u128" => "a whole number, 0 or more".into(),
        "i8" | "i16" | "i32" | "i64" | "isize" | "i128" => "a whole number".into(),
        "a string" | "path string" | "string" | "str" | "a borrowed string" => "a string".into(),
        "a boolean" => "true or false".into(),
        "a sequence" => "a sequence".into(),
        "a map" => "a mapping".into(),
        // The word that tells settings apart.
        _ if key == "type" && variants.is_some() => match variants.and_then(|variants| variants.types.first()) {
            Some(example) => format!("the name of a type, e.g. `{example}`"),
            None => "the name of a type".into(),
        },
        // The words of a reader of ours, for a slot that takes more than stages.
        _ if expected.starts_with("a path") => expected.into(),
        _ if expected.starts_with("a nonzero") => "a whole number, 1 or more".into(),
        _ => match variants {
            Some(variants) => {
                let example = variants.types.first().map_or("…", String::as_str);
                format!("a mapping that begins with `type`, e.g. `{{ type: {example} }}`")
            }
            None if expected.starts_with("struct") => "a mapping of keys".into(),
            None => expected.into(),
        },
    }
}

fn finding(found: &str) -> String {
    match found {
        "map" => "a mapping".into(),
        "sequence" => "a sequence".into(),
        "null" | "unit value" | "Option value" => "nothing".into(),
        _ => {
            let (kind, value) = found.split_once(' ').unwrap_or(("", found));
            match kind {
                "string" => format!("the string {value}"),
                "integer" | "boolean" => value.trim_matches('`').into(),
                "floating" => value.trim_start_matches("point ").trim_matches('`').into(),
                _ => found.into(),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wrong_types_are_explained_without_rust_words() {
        let message = |error: &str| rephrase(error, "k", None, &[]).message;
        assert_eq!(
            message("invalid type: string \"x\", expected f64"),
            "`k`: expected a number, found the string \"x\""
        );
        assert_eq!(
            message("invalid value: integer `-3`, expected u32"),
            "`k`: expected a whole number, 0 or more, found -3"
        );
        assert_eq!(message("invalid type: floating point `0.5`, expected usize").split("found ").last(), Some("0.5"));
        assert_eq!(message("invalid type: null, expected a boolean"), "`k`: expected true or false, found nothing");
    }

    #[test]
    fn unknown_keys_bring_the_nearest_known_one() {
        let near = rephrase("unknown field `sorce`, expected one of `source`, `target`", "sorce", None, &[]);
        assert_eq!((near.message.as_str(), near.hint.as_str()), ("unknown key `sorce`", "did you mean `source`?"));
        let far = rephrase("unknown field `zzz`, expected `source` or `target`", "zzz", None, &[]);
        assert_eq!(far.hint, "known keys: source, target");
    }
}
