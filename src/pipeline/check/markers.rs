use std::path::Path;

use super::{Check, Options, Side};
use crate::{
    core::stage::Marker,
    diagnostic::Kind,
    diagnostic::{Diagnostic, Result},
    markers::{self, MarkerFile, MarkerFiles, given},
    pipeline::{Formats, Step, compose, document::path, parse},
};

/// The part of a pipeline that markers lie on: its two meshes at rest, without diagnostics.
#[derive(Debug)]
pub struct Meshes {
    /// What gives its motion.
    pub source: Side,
    /// What takes it.
    pub target: Side,
    /// The pipeline's files of markers, as seen from the current folder.
    pub markers: Option<MarkerFiles>,
}

/// Reads the meshes of the pipeline in `file`; of the rest nothing is looked at but the names of its markers.
///
/// # Errors
///
/// All diagnostics in that part.
pub fn meshes(file: &Path, options: &Options) -> Result<Meshes> {
    let (document, included, _) = compose::compose_source(file, &options.settings)?;
    let (mut pipeline, diagnostics) = parse::parse(&document);
    // A pipeline may still lack what only a run needs.
    let missing = |diagnostic: &Diagnostic| {
        let needed = ["source", "target"].map(|key| format!("missing key `{key}`"));
        diagnostic.message.starts_with("missing key") && !needed.contains(&diagnostic.message)
    };
    let mut check = Check {
        document: &document,
        formats: Formats::new(std::mem::take(&mut pipeline.formats)),
        inputs: super::files(file, &included),
        diagnostics: diagnostics.into_iter().filter(|diagnostic| !missing(diagnostic)).collect(),
        warnings: vec![],
    };
    let source = check.side("source", pipeline.source.rest.as_deref(), pipeline.source.generator.as_deref());
    let target = check.target(&pipeline.target);
    check.end(file)?;
    let (Some(source), Some(target)) = (source, target) else {
        return Err(Diagnostic::new(Kind::Internal, "a mesh was refused without a reason").into());
    };
    let markers = pipeline.markers.map(|files| check.marker_files(&files));
    Ok(Meshes { source, target, markers })
}

impl Side {
    /// What markers see of it.
    pub fn for_markers(&self, name: &'static str) -> markers::Side<'_> {
        markers::Side { name, mesh: &self.sequence.rest, surface: &self.surface }
    }
}

impl Check<'_> {
    /// The markers, as far as they can be had; none are none.
    pub(super) fn markers(
        &mut self,
        files: Option<&MarkerFiles>,
        source: Option<&Side>,
        target: Option<&Side>,
    ) -> Option<Vec<Marker>> {
        let Some(files) = files else {
            let (source, target) = (source?, target?);
            let landmarks = markers::from_landmarks(&source.sequence, &target.sequence);
            return self.resolve_markers(&landmarks, None, source, target);
        };
        let files = self.marker_files(files);
        let before = self.diagnostics.len();
        for (key, file) in files.named() {
            let at: Vec<Step> = path(["markers"]).into_iter().chain(key.map(|key| Step::Key(key.into()))).collect();
            let role = match key {
                Some("source") => "source markers",
                Some(_) => "target markers",
                None => "markers",
            };
            self.input(role, file, &at);
        }
        if self.diagnostics.len() > before {
            return None;
        }
        let given = match given::read(&files) {
            Ok(given) => given,
            Err(failure) => {
                self.diagnostics.extend(failure.diagnostics);
                return None;
            }
        };
        let (source, target) = (source?, target?);
        match given.on(source.for_markers("source"), target.for_markers("target"), false) {
            Ok(found) => {
                self.warnings.extend(found.doubts());
                self.warnings.extend(found.warnings);
                self.resolve_markers(&found.markers, files.one().map(|file| file.as_path()), source, target)
            }
            Err(failure) => {
                self.diagnostics.extend(failure.diagnostics);
                None
            }
        }
    }

    /// The files as seen from the current folder.
    pub(super) fn marker_files(&self, files: &MarkerFiles) -> MarkerFiles {
        match files {
            MarkerFiles::One(file) => MarkerFiles::One(self.path(&path(["markers"]), file)),
            MarkerFiles::Pair { source, target } => MarkerFiles::Pair {
                source: self.path(&path(["markers", "source"]), source),
                target: self.path(&path(["markers", "target"]), target),
            },
        }
    }

    fn resolve_markers(
        &mut self,
        markers: &MarkerFile,
        file: Option<&Path>,
        source: &Side,
        target: &Side,
    ) -> Option<Vec<Marker>> {
        let [source, target] = [("source", source), ("target", target)].map(|(name, side)| {
            let of = side.for_markers(name);
            if let Some(file) = file {
                let hashed = markers.reference(name).is_some_and(|reference| reference.blake3.is_some());
                let hash = side.path.as_ref().filter(|_| hashed).and_then(|path| super::super::hash_file(path).ok());
                self.warnings.extend(markers.stale(file, of, hash.as_deref()));
            }
            of
        });
        match markers.resolve(source, target) {
            Ok(markers) => Some(markers),
            Err(failure) => {
                self.diagnostics.extend(failure.diagnostics);
                None
            }
        }
    }
}
