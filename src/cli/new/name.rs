//! The names of a new crate and its stage.

use mimesh_document::diagnostic::Result;

use crate::cli::new::{template::Template, wrong_name};

/// Words that Rust or cargo reserves.
const RESERVED: &str = "abstract alloc as async await become box break build const continue core crate deps do dyn \
    else enum examples extern false final fn for gen if impl in incremental let loop macro match mimesh mimesh_core mod \
    move mut override priv proc_macro pub ref return self static std struct super test trait true try type \
    typeof union unsafe unsized use virtual where while";

/// The name of a crate and its stage.
#[derive(Debug, PartialEq)]
pub struct Name {
    /// The name of the crate, as the user wrote it.
    pub kebab: String,
    /// The name of the crate in Rust, and of the stage in YAML.
    pub snake: String,
    /// The name of the stage's type.
    pub camel: String,
}

impl Name {
    /// Reads a name: words of lower-case letters and digits, with `-` or `_` between them. Words begin with a letter.
    ///
    /// # Errors
    ///
    /// A diagnostic if `given` is not such a name; its hint proposes one.
    pub fn new(given: &str) -> Result<Self> {
        Self::read(given).ok_or_else(|| {
            let proposed = proposed(given).unwrap_or_else(|| "my-sampler".into());
            let expected = "words of lower-case letters and digits that begin with a letter, with - or _ between them";
            let message = format!("`{given}` cannot name a crate: expected {expected}");
            wrong_name(message, format!("e.g. `{proposed}`")).into()
        })
    }

    fn read(given: &str) -> Option<Self> {
        if !given.split(['-', '_']).all(is_word) {
            return None;
        }
        let snake = given.replace('-', "_");
        let camel = snake.split('_').map(capitalized).collect();
        Some(Self { kebab: given.into(), snake, camel })
    }

    /// Checks that the name has no other meaning in the files of the new crate.
    ///
    /// # Errors
    ///
    /// A diagnostic if it has; its hint proposes another name.
    pub fn check(self, template: &Template) -> Result<Self> {
        let is_reserved = RESERVED.split(' ').any(|word| word == self.snake)
            || template.dependencies.iter().any(|name| name.replace('-', "_") == self.snake);
        let is_used = template.uses(&self.camel) || ["Some", "Self"].contains(&&*self.camel);
        if is_reserved || is_used {
            let message = format!("`{}` has a meaning of its own in Rust or in mimesh", self.kebab);
            return Err(wrong_name(message, format!("add a word, e.g. `my-{}`", self.kebab)).into());
        }
        Ok(self)
    }
}

fn is_word(text: &str) -> bool {
    text.starts_with(|c: char| c.is_ascii_lowercase())
        && text.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit())
}

fn capitalized(word: &str) -> String {
    word[..1].to_ascii_uppercase() + &word[1..]
}

/// The valid name that is closest to `given`, if it has any letters.
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
    use super::*;
    use crate::cli::new::source::Source;

    #[test]
    fn names_come_in_three_spellings() {
        let failure = Name::new("my-2nd_ridge").unwrap_err();
        assert!(failure.list[0].message.contains("my-2nd_ridge"), "words begin with a letter");
        let name = Name::new("my-ridge_v2").unwrap();
        assert_eq!([name.kebab, name.snake, name.camel], ["my-ridge_v2", "my_ridge_v2", "MyRidgeV2"]);
    }

    #[test]
    fn an_invalid_name_gives_a_hint_with_a_valid_one() {
        let hint = |given: &str| Name::new(given).unwrap_err().list[0].hint.clone().unwrap();
        assert_eq!(hint("RidgePoints"), "e.g. `ridge-points`");
        assert_eq!(hint("ridge points!"), "e.g. `ridge-points`");
        assert_eq!(hint("../ridge"), "e.g. `ridge`");
        assert_eq!([hint(""), hint("4"), hint("é")], ["e.g. `my-sampler`"; 3]);
    }

    #[test]
    fn names_with_another_meaning_are_refused() {
        let template = Template::read("sampler", &Source::find(None).unwrap()).unwrap();
        for given in ["match", "std", "serde", "mimesh-core", "surface", "sampler", "result", "some"] {
            assert!(Name::new(given).unwrap().check(&template).is_err(), "{given}");
        }
        assert!(Name::new("ridges").unwrap().check(&template).is_ok());
    }
}
