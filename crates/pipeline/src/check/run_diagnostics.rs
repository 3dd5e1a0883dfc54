//! The diagnostics of several runs of one file, put together.

use std::path::Path;

use mimesh_document::{
    diagnostic::{Diagnostic, Diagnostics, Location, Result},
    source_tree::SpanTree,
};

use crate::compose::{Run, Variant};

/// The diagnostics of all runs of a file, each once.
#[derive(Debug)]
pub(super) struct RunDiagnostics {
    variants: Vec<Variant>,
    /// Where the values of each run were written.
    nodes: Vec<SpanTree>,
    /// Diagnostics of the file as a whole.
    whole: Diagnostics,
    /// Diagnostics of single runs, with the runs that have them.
    found: Vec<RunDiagnostic>,
    /// Places at which diagnostics follow from those of the file as a whole.
    suppressed: Vec<Location>,
}

#[derive(Debug)]
struct RunDiagnostic {
    diagnostic: Diagnostic,
    /// The message without what is the run's own.
    kind: String,
    runs: Vec<usize>,
}

impl RunDiagnostics {
    /// Begins with the diagnostics of the file as a whole.
    pub(super) fn new(runs: &[Run], whole: Diagnostics, suppressed: Vec<Location>) -> Self {
        let variants = runs.iter().map(|run| run.variant.clone()).collect();
        let nodes = runs.iter().map(|run| run.document.root.clone()).collect();
        Self { variants, nodes, whole, found: vec![], suppressed }
    }

    /// For a single run.
    pub(super) fn of_one(diagnostics: Diagnostics) -> Self {
        Self { variants: vec![], nodes: vec![], whole: diagnostics, found: vec![], suppressed: vec![] }
    }

    /// Whether there are no diagnostics.
    pub(super) fn is_empty(&self) -> bool {
        self.whole.is_empty() && self.found.is_empty()
    }

    /// Adds diagnostics of the file as a whole.
    pub(super) fn add_whole(&mut self, diagnostics: impl IntoIterator<Item = Diagnostic>) {
        self.whole.extend(diagnostics);
    }

    /// Adds diagnostics of one run.
    pub(super) fn add(&mut self, run: usize, diagnostics: Diagnostics) {
        let variant = &self.variants[run];
        for diagnostic in diagnostics {
            if diagnostic.location.as_ref().is_some_and(|location| self.suppressed.contains(location)) {
                continue;
            }
            let mut kind = diagnostic.message.clone();
            let own =
                [(&Some(variant.name.clone()), "{name}"), (&variant.target, "{target}"), (&variant.matrix, "{matrix}")];
            for (name, placeholder) in own {
                if let Some(name) = name.as_ref().filter(|name| !name.is_empty()) {
                    kind = kind.replace(name.as_str(), placeholder);
                }
            }
            let same = |found: &&mut RunDiagnostic| {
                found.diagnostic.location == diagnostic.location
                    && (found.diagnostic.message == diagnostic.message || found.kind == kind)
            };
            match self.found.iter_mut().find(same) {
                Some(found) if found.runs.last() != Some(&run) => found.runs.push(run),
                Some(_) => {}
                None => self.found.push(RunDiagnostic { diagnostic, kind, runs: vec![run] }),
            }
        }
    }

    /// All diagnostics in the order of the file, if there are any.
    pub(super) fn finish(self, file: &Path) -> Result<()> {
        if self.is_empty() {
            return Ok(());
        }
        let mut diagnostics = self.whole.list.clone();
        diagnostics.extend(self.found.iter().map(|found| Diagnostic {
            message: format!("{}{}", found.diagnostic.message, self.whose(found)),
            ..found.diagnostic.clone()
        }));
        diagnostics.sort_by_key(|diagnostic| match &diagnostic.location {
            Some(Location::Span { file: location, line, column, .. }) if location == file => (0, *line, *column),
            // Options have no place in the file, and what is wrong in other files comes after.
            Some(Location::Setting(_) | Location::OutputFolder(_)) => (1, 0, 0),
            _ => (2, 0, 0),
        });
        Err(Diagnostics { list: diagnostics })
    }

    /// Which runs, if not all of them and the place does not say it.
    fn whose(&self, RunDiagnostic { diagnostic, runs, .. }: &RunDiagnostic) -> String {
        let others: Vec<usize> = (0..self.variants.len()).filter(|run| !runs.contains(run)).collect();
        let elsewhere = |location: &Location| !others.iter().any(|run| self.nodes[*run].has(location));
        if others.is_empty() || diagnostic.location.as_ref().is_some_and(elsewhere) {
            return String::new();
        }
        let target = |run: &usize| self.variants[*run].target.as_deref();
        let mut targets: Vec<&str> = runs.iter().filter_map(target).collect();
        targets.dedup();
        if !targets.is_empty() && others.iter().filter_map(target).all(|other| !targets.contains(&other)) {
            return format!(" (of {})", listed(&targets));
        }
        let names: Vec<&str> = runs.iter().map(|run| self.variants[*run].name.as_str()).collect();
        format!(" (of {})", listed(&names))
    }
}

/// Some names, and how many more there are.
fn listed(names: &[&str]) -> String {
    const MAX_NAMES: usize = 3;
    let shown = names.iter().take(MAX_NAMES).map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
    if names.len() > MAX_NAMES { format!("{shown} and {} more", names.len() - MAX_NAMES) } else { shown }
}
