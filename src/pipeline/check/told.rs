use std::path::Path;

use crate::{
    diagnostic::{Diagnostic, Diagnostics, Location, Result},
    pipeline::{Variant, compose::OneRun, places::Node},
};

/// The diagnostics of all runs of a file, each told once.
#[derive(Debug)]
pub(super) struct Told {
    variants: Vec<Variant>,
    /// Where the values of each run were written.
    nodes: Vec<Node>,
    /// What concerns the file as a whole.
    whole: Vec<Diagnostic>,
    /// What is wrong with runs, and with which.
    found: Vec<Found>,
    /// Places at which whatever is wrong follows from `whole`.
    left: Vec<Location>,
}

#[derive(Debug)]
struct Found {
    diagnostic: Diagnostic,
    /// The message without what is the run's own.
    kind: String,
    runs: Vec<usize>,
}

impl Told {
    /// Begins with what is wrong with the file as a whole.
    pub(super) fn new(runs: &[OneRun], whole: Vec<Diagnostic>, left: Vec<Location>) -> Self {
        let variants = runs.iter().map(|run| run.variant.clone()).collect();
        let nodes = runs.iter().map(|run| run.document.root.clone()).collect();
        Self { variants, nodes, whole, found: vec![], left }
    }

    /// For a single run.
    pub(super) fn of_one(diagnostics: Vec<Diagnostic>) -> Self {
        Self { variants: vec![], nodes: vec![], whole: diagnostics, found: vec![], left: vec![] }
    }

    /// Whether there is nothing to tell.
    pub(super) fn is_empty(&self) -> bool {
        self.whole.is_empty() && self.found.is_empty()
    }

    /// Adds what concerns no run more than another.
    pub(super) fn add_all(&mut self, diagnostics: Vec<Diagnostic>) {
        self.whole.extend(diagnostics);
    }

    /// Adds what is wrong with a run.
    pub(super) fn add(&mut self, run: usize, diagnostics: Vec<Diagnostic>) {
        let variant = &self.variants[run];
        for diagnostic in diagnostics {
            if diagnostic.location.as_ref().is_some_and(|location| self.left.contains(location)) {
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
            let same = |found: &&mut Found| {
                found.diagnostic.location == diagnostic.location
                    && (found.diagnostic.message == diagnostic.message || found.kind == kind)
            };
            match self.found.iter_mut().find(same) {
                Some(found) if found.runs.last() != Some(&run) => found.runs.push(run),
                Some(_) => {}
                None => self.found.push(Found { diagnostic, kind, runs: vec![run] }),
            }
        }
    }

    /// All diagnostics in the order of the file, if there are any.
    pub(super) fn end(self, file: &Path) -> Result<()> {
        if self.is_empty() {
            return Ok(());
        }
        let mut diagnostics = self.whole.clone();
        diagnostics.extend(self.found.iter().map(|found| Diagnostic {
            message: format!("{}{}", found.diagnostic.message, self.whose(found)),
            ..found.diagnostic.clone()
        }));
        diagnostics.sort_by_key(|diagnostic| match &diagnostic.location {
            Some(Location::Span { file: location, line, column, .. }) if location == file => (0, *line, *column),
            // Options have no place in the file, and what is wrong in other files comes after.
            Some(Location::Option(_)) => (1, 0, 0),
            _ => (2, 0, 0),
        });
        Err(Diagnostics { diagnostics })
    }

    /// Which runs, if not all of them and the place does not say it.
    fn whose(&self, Found { diagnostic, runs, .. }: &Found) -> String {
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
    const MOST: usize = 3;
    let shown = names.iter().take(MOST).map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
    if names.len() > MOST { format!("{shown} and {} more", names.len() - MOST) } else { shown }
}
