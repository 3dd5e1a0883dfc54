//! Shapes on their way to results, and patterns of their names.

use std::collections::{BTreeMap, HashMap};

use mimesh_document::{At, Step, path, suggest::did_you_mean};

use super::findings::{Findings, Scope};
use crate::{input::PoseInput, shapes::ShapeEdit, text::some_of};

/// A pose on its way to a result.
pub(super) struct Shape {
    /// Its name in the source, or that of the other side's shape that it is made from, with left and right exchanged.
    pub shape: String,
    /// The pose, under the name of its result.
    pub pose: PoseInput,
    /// What becomes of it.
    pub edit: ShapeEdit,
}

/// Patterns of names of shapes, matched against the names of the source.
pub(super) struct Patterns<'a> {
    /// The document that they stand in.
    pub scope: Scope<'a>,
    /// The names of the source's shapes.
    pub names: &'a [String],
}

impl Patterns<'_> {
    /// Whether each name fits `pattern`, written at `at`; a pattern that fits none is a diagnostic.
    pub fn fits(&self, found: &mut Findings, at: &[Step], place: At, pattern: &str) -> Vec<bool> {
        let compiled = match glob::Pattern::new(pattern) {
            Ok(compiled) => compiled,
            Err(error) => {
                let message = format!("`{pattern}` is no pattern: {}", error.msg);
                found.wrong(self.scope, at, place, message, "e.g. `mouth*`");
                return vec![false; self.names.len()];
            }
        };
        let fits: Vec<bool> = self.names.iter().map(|name| name == pattern || compiled.matches(name)).collect();
        if !fits.contains(&true) && !self.names.is_empty() {
            let known = || format!("shapes: {}", some_of(self.names));
            let hint = did_you_mean(pattern, self.names).unwrap_or_else(known);
            found.wrong(self.scope, at, place, format!("no shape of the source is called `{pattern}`"), hint);
        }
        fits
    }

    /// The values of a mapping at `shapes.KEY` by the names that its keys fit, the first of several.
    pub fn by_shape<'v, T>(
        &self,
        found: &mut Findings,
        key: &str,
        values: &'v BTreeMap<String, T>,
    ) -> HashMap<String, &'v T> {
        let mut by_shape = HashMap::new();
        // Exact names go before patterns.
        let (exact, patterns): (Vec<_>, Vec<_>) = values.iter().partition(|(name, _)| self.names.contains(name));
        for (pattern, value) in exact.into_iter().chain(patterns) {
            let fits = self.fits(found, &path(["shapes", key, pattern]), At::Key, pattern);
            for (name, _) in self.names.iter().zip(fits).filter(|(_, fits)| *fits) {
                by_shape.entry(name.clone()).or_insert(value);
            }
        }
        by_shape
    }
}
