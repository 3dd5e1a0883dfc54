use std::path::{Path, PathBuf};

use super::{Check, Options, PoseInput, Side};
use crate::{
    core::{plugin, stage::KeyPoints},
    diagnostic::Kind,
    diagnostic::{Diagnostic, Result},
    pipeline::{At, Formats, compose, parse},
};

/// The part of a pipeline that key points are chosen by: its source, without diagnostics.
#[derive(Debug)]
pub struct PreparedSource {
    /// What gives its motion.
    pub source: Side,
    /// Its poses, at least one.
    pub poses: Vec<PoseInput>,
    /// The formats, with the pipeline's settings.
    pub formats: Formats,
    /// How points are chosen.
    pub key_points: Box<dyn KeyPoints>,
    /// The pipeline's file of markers, as seen from the current folder.
    pub markers: Option<PathBuf>,
    /// The target's file, as the pipeline spells it.
    pub target: Option<PathBuf>,
}

/// Reads the source of the pipeline in `file`; of the rest only what concerns key points is looked at.
///
/// # Errors
///
/// All diagnostics that can be found in that part without computing or reading poses.
pub fn prepare_source(file: &Path, options: &Options) -> Result<PreparedSource> {
    let (document, included, targets) = compose::compose_source(file, &options.settings)?;
    let (mut pipeline, diagnostics) = parse::parse(&document);
    // A pipeline may still lack what only a run needs.
    let missing = |diagnostic: &Diagnostic| {
        ["target", "correspondence", "transfer", "output"]
            .iter()
            .any(|key| diagnostic.message == format!("missing key `{key}`"))
    };
    let mut check = Check {
        document: &document,
        formats: Formats::new(std::mem::take(&mut pipeline.formats)),
        inputs: super::files(file, &included),
        diagnostics: diagnostics.into_iter().filter(|diagnostic| !missing(diagnostic)).collect(),
        warnings: vec![],
    };
    check.registry();
    check.format_settings();
    let (source, poses) = check.source(&pipeline.source);
    check.end(file)?;
    let Some(source) = source else {
        return Err(Diagnostic::new(Kind::Internal, "a mesh was refused without a reason").into());
    };
    let Some(key_points) = pipeline.key_points.take() else {
        let names: Vec<_> = plugin::instances::<dyn KeyPoints>().iter().map(|(name, _)| *name).collect();
        let hint = format!("say how to choose them, e.g. `key_points: {{ type: {} }}`", names.join(" | "));
        return Err(document.diagnostic(&[], At::Value, "missing key `key_points`").hint(hint).into());
    };
    let markers = pipeline.markers.as_ref().and_then(|files| check.marker_files(files).one().cloned());
    Ok(PreparedSource {
        source,
        poses,
        formats: check.formats,
        key_points,
        markers,
        target: pipeline.target.rest.filter(|_| targets == 1),
    })
}
