//! Serde's messages in the words of someone who writes a pipeline.

use crate::core::plugin;

/// A message, its hint, and whether it is about a key rather than a value.
pub struct Told {
    /// What is wrong.
    pub message: String,
    /// The way out; may be empty.
    pub hint: String,
    /// Whether the key is wrong, not its value.
    pub about_key: bool,
}

/// Rephrases `error`, met at the key `key` (the last of its path) in a stage of kind `stage`, if the value is one;
/// `choices` are the words that the value may be, if it is one of several.
pub fn tell(error: &str, key: &str, stage: Option<&str>, choices: &[String]) -> Told {
    let mut quoted = error.split('`').skip(1).step_by(2);
    if let Some(rest) = error.strip_prefix("unknown field ") {
        let found = quoted.next().unwrap_or(rest);
        let known: Vec<_> = quoted.collect();
        let hint = if known.is_empty() {
            "it has no settings; remove the key".into()
        } else {
            did_you_mean(found, &known).unwrap_or_else(|| format!("known keys: {}", known.join(", ")))
        };
        return Told { message: format!("unknown key `{found}`"), hint, about_key: true };
    }
    if let Some(rest) = error.strip_prefix("unknown variant ") {
        let found = quoted.next().unwrap_or(rest).to_owned();
        let listed: Vec<_> = quoted.map(str::to_owned).collect();
        return match stage.or_else(|| kind_of(&listed)) {
            Some(stage) => Told { about_key: false, ..unknown_type(stage, &found) },
            None => {
                let hint = did_you_mean(&found, &listed);
                let hint = hint.unwrap_or_else(|| format!("known values: {}", listed.join(", ")));
                Told { message: format!("`{key}`: unknown value `{found}`"), hint, about_key: false }
            }
        };
    }
    if error.starts_with("missing field") {
        let missing = quoted.next().unwrap_or_default();
        let hint = match stage {
            Some(stage) if missing == "type" => format!("known types: {}", types(stage).join(", ")),
            Some(stage) => format!("`mimesh show {stage} TYPE` tells its settings"),
            None => String::new(),
        };
        return Told { message: format!("missing key `{missing}`"), hint, about_key: true };
    }
    let wrong = error.strip_prefix("invalid type: ").or_else(|| error.strip_prefix("invalid value: "));
    if let Some((found, expected)) = wrong.and_then(|wrong| wrong.rsplit_once(", expected ")) {
        let expected = match choices {
            [] => expectation(expected, stage),
            _ => format!("one of {}", choices.join(", ")),
        };
        let message = format!("`{key}`: expected {expected}, found {}", finding(found));
        return Told { message, hint: String::new(), about_key: false };
    }
    Told { message: format!("`{key}`: {error}"), hint: String::new(), about_key: false }
}

/// That there is no implementation `found` of `stage`.
pub fn unknown_type(stage: &str, found: &str) -> Told {
    let known = types(stage);
    let hint = if known.is_empty() {
        format!("no {stage} is linked into this program")
    } else {
        did_you_mean(found, &known).unwrap_or_else(|| format!("known types: {}", known.join(", ")))
    };
    Told { message: format!("unknown {stage} `{found}`"), hint, about_key: false }
}

/// A question for the most similar of `known`, if one is similar.
pub fn did_you_mean<S: AsRef<str>>(found: &str, known: &[S]) -> Option<String> {
    nearest(found, known).map(|best| format!("did you mean `{}`?", best.as_ref()))
}

/// The most similar of `known`, if one is similar.
pub fn nearest<'k, S: AsRef<str>>(found: &str, known: &'k [S]) -> Option<&'k S> {
    let similarity = |name: &S| strsim::jaro_winkler(&found.to_lowercase(), &name.as_ref().to_lowercase());
    let best = known.iter().max_by(|a, b| similarity(a).total_cmp(&similarity(b)))?;
    (similarity(best) >= 0.8).then_some(best)
}

/// The registered types of a stage.
pub fn types(stage: &str) -> Vec<&'static str> {
    plugin::all().into_iter().filter(|plugin| plugin.stage == stage).map(|plugin| (plugin.name)()).collect()
}

/// The stage whose types are all of `names`: what is nested in a stage may stand under a key of any name.
fn kind_of(names: &[String]) -> Option<&'static str> {
    let sorted = |mut names: Vec<&str>| {
        names.sort_unstable();
        names.into_iter().map(str::to_owned).collect::<Vec<_>>()
    };
    let names = sorted(names.iter().map(String::as_str).collect());
    let kinds: std::collections::BTreeSet<_> = plugin::all().into_iter().map(|plugin| plugin.stage).collect();
    kinds.into_iter().find(|kind| sorted(types(kind)) == names)
}

fn expectation(expected: &str, stage: Option<&str>) -> String {
    match expected {
        "f64" | "f32" => "a number".into(),
        "u8" | "u16" | "u32" | "u64" | "usize" | "u128" => "a whole number, 0 or more".into(),
        "i8" | "i16" | "i32" | "i64" | "isize" | "i128" => "a whole number".into(),
        "a string" | "path string" | "string" | "str" | "a borrowed string" => "a text".into(),
        "a boolean" => "true or false".into(),
        "a sequence" => "a list".into(),
        _ if expected.starts_with("a nonzero") => "a whole number, 1 or more".into(),
        _ if expected.starts_with("struct") && stage.is_none() => "a map of keys".into(),
        _ => match stage {
            Some(stage) => {
                format!("a map that begins with `type`, e.g. `{{ type: {} }}`", types(stage).first().unwrap_or(&"…"))
            }
            None => expected.into(),
        },
    }
}

fn finding(found: &str) -> String {
    match found {
        "map" => "a map".into(),
        "sequence" => "a list".into(),
        "null" | "unit value" | "Option value" => "nothing".into(),
        _ => {
            let (kind, value) = found.split_once(' ').unwrap_or(("", found));
            match kind {
                "string" => format!("the text {value}"),
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
    fn wrong_types_are_told_without_rust_words() {
        let message = |error: &str| tell(error, "k", None, &[]).message;
        assert_eq!(message("invalid type: string \"x\", expected f64"), "`k`: expected a number, found the text \"x\"");
        assert_eq!(
            message("invalid value: integer `-3`, expected u32"),
            "`k`: expected a whole number, 0 or more, found -3"
        );
        assert_eq!(message("invalid type: floating point `0.5`, expected usize").split("found ").last(), Some("0.5"));
        assert_eq!(message("invalid type: null, expected a boolean"), "`k`: expected true or false, found nothing");
    }

    #[test]
    fn unknown_keys_bring_the_nearest_known_one() {
        let told = tell("unknown field `sorce`, expected one of `source`, `target`", "sorce", None, &[]);
        assert_eq!((told.message.as_str(), told.hint.as_str()), ("unknown key `sorce`", "did you mean `source`?"));
        let far = tell("unknown field `zzz`, expected `source` or `target`", "zzz", None, &[]);
        assert_eq!(far.hint, "known keys: source, target");
    }
}
