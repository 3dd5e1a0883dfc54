//! What a reader tells of a file beside what it reads.

use crate::names::quoted;

/// Sentences about what is untidy.
#[derive(Debug, Default)]
pub struct Told {
    pub sentences: Vec<String>,
}

impl Told {
    /// Adds a sentence about the things called `names`, if there are any.
    pub fn tell(&mut self, what: &str, names: Vec<String>) {
        if !names.is_empty() {
            self.sentences.push(format!("{what}: {}", quoted(&names)));
        }
    }
}
