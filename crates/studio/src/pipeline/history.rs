//! The history of the pipeline's text, for undo and redo.

use std::{
    collections::VecDeque,
    time::{Duration, Instant},
};

use mimesh_document::Step;
use serde_json::Value;

use super::{set, written::flow};
use crate::order;

/// How many steps are kept.
const MAX_STEPS: usize = 500;

/// Texts that are typed are one step if no more time than this lies between them.
const TYPING: Duration = Duration::from_secs(5);

/// The title of a step that replaced the text as a whole.
pub const TYPED: &str = "edit the text of the pipeline";

/// Steps that were done, and steps that were taken back.
#[derive(Debug, Default)]
pub struct TextHistory {
    steps: VecDeque<TextStep>,
    /// How many of the steps are done.
    done: usize,
}

/// A step: the texts before and after it.
#[derive(Clone, Debug)]
pub struct TextStep {
    /// What was done, e.g. `set transfer.type to gradient`.
    pub title: String,
    /// Where it stands among the steps of all histories.
    pub order: u64,
    before: String,
    after: String,
    at: Instant,
}

impl TextHistory {
    /// Adds a step; what was taken back before is forgotten.
    pub fn push(&mut self, title: String, before: String, after: String) {
        self.forget_redo();
        let now = Instant::now();
        match self.steps.back_mut() {
            Some(last) if title == TYPED && last.title == TYPED && last.after == before && now - last.at < TYPING => {
                (last.after, last.at) = (after, now);
            }
            _ => self.steps.push_back(TextStep { title, order: order::next(), before, after, at: now }),
        }
        if self.steps.len() > MAX_STEPS {
            self.steps.pop_front();
        }
        self.done = self.steps.len();
    }

    /// The step that undo takes back.
    pub fn last(&self) -> Option<&TextStep> {
        self.done.checked_sub(1).and_then(|i| self.steps.get(i))
    }

    /// The step that redo does again.
    pub fn next(&self) -> Option<&TextStep> {
        self.steps.get(self.done)
    }

    /// Goes back by a step, and gives the text before it.
    pub fn back(&mut self) -> Option<String> {
        let text = self.last()?.before.clone();
        self.done -= 1;
        Some(text)
    }

    /// Goes forward by a step, and gives the text after it.
    pub fn forward(&mut self) -> Option<String> {
        let text = self.next()?.after.clone();
        self.done += 1;
        Some(text)
    }

    /// Forgets what was taken back; whether there was any.
    pub fn forget_redo(&mut self) -> bool {
        let had = self.steps.len() > self.done;
        self.steps.truncate(self.done);
        had
    }

    /// Sets a value in all texts, which is no step: undo keeps it.
    pub fn set_everywhere(&mut self, path: &[Step], value: &Value) {
        for text in self.steps.iter_mut().flat_map(|step| [&mut step.before, &mut step.after]) {
            // A text that is no YAML stays as it was typed.
            if let Ok(changed) = set::set(text, path, Some(value)) {
                *text = changed;
            }
        }
    }
}

/// What setting the value at `path` does, in words for the user; `None` takes it away.
pub fn title(path: &[Step], value: Option<&Value>) -> String {
    const MAX_VALUE: usize = 40;
    let name = path.iter().map(ToString::to_string).collect::<Vec<_>>().join(".");
    let Some(value) = value else { return format!("leave {name} out") };
    let text = value.get("type").and_then(Value::as_str).map_or_else(|| flow(value), Into::into);
    if text.chars().count() > MAX_VALUE { format!("set {name}") } else { format!("set {name} to {text}") }
}

#[cfg(test)]
mod tests {
    use mimesh_document::path;
    use serde_json::json;

    use super::*;

    #[test]
    fn steps_are_taken_back_and_done_again_and_typing_is_one_step() {
        let mut history = TextHistory::default();
        history.push("set a to 1".into(), "a: 0\n".into(), "a: 1\n".into());
        history.push(TYPED.into(), "a: 1\n".into(), "a: 12\n".into());
        history.push(TYPED.into(), "a: 12\n".into(), "a: 123\n".into());
        assert_eq!(history.back().unwrap(), "a: 1\n");
        assert_eq!(history.back().unwrap(), "a: 0\n");
        assert!(history.back().is_none());
        assert_eq!((history.forward().unwrap(), history.forward().unwrap()), ("a: 1\n".into(), "a: 123\n".into()));
        history.back();
        assert!(history.forget_redo() && history.next().is_none() && !history.forget_redo());
    }

    #[test]
    fn what_the_server_sets_by_itself_outlives_undo() {
        let mut history = TextHistory::default();
        history.push("set a to 1".into(), "a: 0\n".into(), "a: 1\n".into());
        history.set_everywhere(&path(["m"]), &json!("x.yaml"));
        assert_eq!(history.back().unwrap(), "a: 0\nm: x.yaml\n");
    }

    #[test]
    fn titles_name_the_value() {
        assert_eq!(title(&path(["transfer", "k"]), Some(&json!(2))), "set transfer.k to 2");
        assert_eq!(
            title(&path(["transfer"]), Some(&json!({ "type": "gradient", "k": 1 }))),
            "set transfer to gradient"
        );
        assert_eq!(title(&path(["transfer"]), None), "leave transfer out");
    }
}
