//! Names of new crates and stages.

use super::{template::Template, wrong_name};
use crate::diagnostic::Diagnostic;

/// Words that Rust, or cargo, keeps to itself.
const KEPT: &str = "abstract alloc as async await become box break build const continue core crate deps do dyn else enum \
    examples extern false final fn for gen if impl in incremental let loop macro match mimesh mimesh_core mod \
    move mut override priv proc_macro pub ref return self static std struct super test trait true try type \
    typeof union unsafe unsized use virtual where while";

/// The name of a crate and its stage.
#[derive(Debug, PartialEq)]
pub struct Name {
    /// As the user wrote it: the crate's.
    pub kebab: String,
    /// The crate's in Rust, and the stage's in YAML.
    pub snake: String,
    /// The type's.
    pub camel: String,
}

impl Name {
    /// Reads a name: words of lower-case letters and digits, each beginning with a letter, with `-` or `_` between them.
    pub fn new(given: &str) -> Result<Self, Diagnostic> {
        Self::read(given).ok_or_else(|| {
            let proposed = proposed(given).unwrap_or_else(|| "my-sampler".into());
            let message =
                format!("`{given}` cannot name a crate: expected words in lower case with - or _ between them");
            wrong_name(message, format!("e.g. `{proposed}`"))
        })
    }

    fn read(given: &str) -> Option<Self> {
        let letter = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit();
        let is_word = |word: &str| word.starts_with(|c: char| c.is_ascii_lowercase()) && word.chars().all(letter);
        if !given.split(['-', '_']).all(is_word) {
            return None;
        }
        let snake = given.replace('-', "_");
        let capital = |word: &str| word[..1].to_ascii_uppercase() + &word[1..];
        let camel = snake.split('_').map(capital).collect();
        Some(Self { kebab: given.into(), snake, camel })
    }

    /// Checks that the name means nothing else in what is written.
    pub fn check(self, template: &Template) -> Result<Self, Diagnostic> {
        let code = template.library.lines().filter(|line| !line.trim_start().starts_with("//"));
        let mut words = code.flat_map(|line| line.split(|c: char| !c.is_alphanumeric() && c != '_'));
        let is_kept =
            KEPT.split(' ').any(|word| word == self.snake) || template.dependencies().any(|name| name == self.snake);
        let is_used = words.any(|word| word == self.camel) || ["Some", "Self"].contains(&&*self.camel);
        if is_kept || is_used {
            let message = format!("`{}` has a meaning of its own in Rust or in mimesh", self.kebab);
            return Err(wrong_name(message, format!("add a word, e.g. `my-{}`", self.kebab)));
        }
        Ok(self)
    }
}

/// What was probably meant.
fn proposed(given: &str) -> Option<String> {
    let mut result = String::new();
    for c in given.chars() {
        if c.is_ascii_uppercase() && result.ends_with(|last: char| last.is_ascii_lowercase()) {
            result.push('-');
        }
        match c {
            _ if c.is_ascii_alphanumeric() => result.push(c.to_ascii_lowercase()),
            _ if !result.is_empty() && !result.ends_with('-') => result.push('-'),
            _ => {}
        }
    }
    let result = result.trim_end_matches('-');
    Name::read(result).map(|name| name.kebab)
}

#[cfg(test)]
mod tests {
    use super::{super::templates, *};

    #[test]
    fn names_come_in_three_spellings() {
        let name = Name::new("my-2nd_ridge").unwrap_err();
        assert!(name.message.contains("my-2nd_ridge"), "words begin with a letter");
        let name = Name::new("my-ridge_v2").unwrap();
        assert_eq!([name.kebab, name.snake, name.camel], ["my-ridge_v2", "my_ridge_v2", "MyRidgeV2"]);
    }

    #[test]
    fn what_is_no_name_is_told_with_one_that_is() {
        let hint = |given: &str| Name::new(given).unwrap_err().hint.unwrap();
        assert_eq!(hint("RidgePoints"), "e.g. `ridge-points`");
        assert_eq!(hint("ridge points!"), "e.g. `ridge-points`");
        assert_eq!(hint("../ridge"), "e.g. `ridge`");
        assert_eq!([hint(""), hint("4"), hint("é")], ["e.g. `my-sampler`"; 3]);
    }

    #[test]
    fn names_with_another_meaning_are_refused() {
        let template = templates::of("sampler");
        for given in ["match", "std", "serde", "mimesh-core", "surface", "sampler", "result", "some"] {
            assert!(Name::new(given).unwrap().check(template).is_err(), "{given}");
        }
        assert!(Name::new("ridges").unwrap().check(template).is_ok());
    }
}
