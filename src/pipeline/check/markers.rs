use std::path::Path;

use super::{Check, Side};
use crate::{
    core::stage::Marker,
    markers::{self, MarkerFile},
    pipeline::{document::path, resolve},
};

impl Check<'_> {
    /// The markers, as far as they can be had; none are none.
    pub(super) fn markers(
        &mut self,
        file: Option<&Path>,
        source: Option<&Side>,
        target: Option<&Side>,
    ) -> Option<Vec<Marker>> {
        let Some(file) = file else {
            let (source, target) = (source?, target?);
            let landmarks = markers::from_landmarks(&source.sequence, &target.sequence);
            return self.resolve_markers(&landmarks, None, source, target);
        };
        let file = resolve::from_base(&self.base, file);
        if !self.input("markers", &file, &path(["markers"])) {
            return None;
        }
        match markers::read(&file) {
            Ok(markers) => self.resolve_markers(&markers, Some(&file), source?, target?),
            Err(failure) => {
                self.mistakes.extend(failure.mistakes);
                None
            }
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
            let of = markers::Side { name, mesh: &side.sequence.rest, surface: &side.surface };
            if let Some(file) = file {
                let reference = if name == "source" { &markers.source } else { &markers.target };
                let hashed = reference.as_ref().is_some_and(|reference| reference.blake3.is_some());
                let hash = side.path.as_ref().filter(|_| hashed).and_then(|path| super::super::hash_file(path).ok());
                self.warnings.extend(markers.stale(file, of, hash.as_deref()));
            }
            of
        });
        match markers.resolve(source, target) {
            Ok(markers) => Some(markers),
            Err(failure) => {
                self.mistakes.extend(failure.mistakes);
                None
            }
        }
    }
}
