//! Stages from their settings.

use std::{
    any::Any,
    panic::{AssertUnwindSafe, catch_unwind},
    path::Path,
};

use mimesh_core::{
    plugin::{self, StageKind},
    stage::{
        Clusterer, Correspondence, Deformer, Format, Generator, KeyPoints, Landmarks, Metric, Proximity, Sampler,
        Transfer, Weights,
    },
    testkit::contracts,
};
use mimesh_document::{Diagnostic, Document, Kind};
use mimesh_pipeline::parse::parse_stage;
use pyo3::prelude::*;
use schemars::JsonSchema;
use serde::de::DeserializeOwned;

use crate::{
    error::{Outcome, exception, misuse},
    work,
};

/// The stage that `settings`, with their `type`, describe.
///
/// # Errors
///
/// All that is wrong with them, without a place: they stand in no file.
pub fn stage<S: StageKind + JsonSchema + ?Sized>(settings: &str) -> Outcome<Box<S>>
where
    Box<S>: DeserializeOwned,
{
    let read = Document::parse(Path::new(S::NAME), settings).and_then(|document| parse_stage::<S>(&document));
    read.map_err(|mut wrong| {
        for diagnostic in &mut wrong.list {
            *diagnostic = Diagnostic { kind: Kind::Usage, location: None, ..diagnostic.clone() };
        }
        wrong
    })
}

/// Does `$act` with the kind of stage that is called `$kind`.
macro_rules! of_kind {
    ($kind:expr, $act:ident($($argument:expr),*), $other:expr) => {
        match $kind {
            "clusterer" => $act::<dyn Clusterer>($($argument),*),
            "correspondence" => $act::<dyn Correspondence>($($argument),*),
            "deformer" => $act::<dyn Deformer>($($argument),*),
            "format" => $act::<dyn Format>($($argument),*),
            "generator" => $act::<dyn Generator>($($argument),*),
            "key_points" => $act::<dyn KeyPoints>($($argument),*),
            "landmarks" => $act::<dyn Landmarks>($($argument),*),
            "metric" => $act::<dyn Metric>($($argument),*),
            "proximity" => $act::<dyn Proximity>($($argument),*),
            "sampler" => $act::<dyn Sampler>($($argument),*),
            "transfer" => $act::<dyn Transfer>($($argument),*),
            "weights" => $act::<dyn Weights>($($argument),*),
            _ => $other,
        }
    };
}

/// Checks the settings of a stage, with their `type`.
#[pyfunction]
pub fn check_stage(py: Python<'_>, kind: &str, settings: &str) -> PyResult<()> {
    let checked = of_kind!(kind, check(settings), return Err(misuse(py, format!("unknown stage `{kind}`"), "")));
    checked.map_err(|wrong| exception(py, &wrong))
}

fn check<S: StageKind + JsonSchema + ?Sized>(settings: &str) -> Outcome<()>
where
    Box<S>: DeserializeOwned,
{
    stage::<S>(settings).map(drop)
}

/// Holds a stage to the contract of its kind; what it breaks is the message of an `AssertionError`.
#[pyfunction]
pub fn check_contract(py: Python<'_>, kind: &str, name: &str, settings: &str) -> PyResult<()> {
    let (kind, name, settings) = (kind.to_owned(), name.to_owned(), settings.to_owned());
    let kept = work::run(py, None, move |_| {
        let described = plugin::all().into_iter().find(|plugin| plugin.stage == kind && plugin.name() == name);
        let held = catch_unwind(AssertUnwindSafe(|| {
            described.iter().for_each(|plugin| contracts::described(plugin));
            keeps(&kind, &name, &settings)
        }));
        held.map_err(|cause| words(cause.as_ref()))
    })?;
    match kept {
        Ok(outcome) => outcome.map_err(|wrong| exception(py, &wrong)),
        Err(broken) => Err(pyo3::exceptions::PyAssertionError::new_err(broken)),
    }
}

fn keeps(kind: &str, name: &str, settings: &str) -> Outcome<()> {
    match kind {
        "clusterer" => contracts::clusterer(name, &*stage::<dyn Clusterer>(settings)?),
        "correspondence" => contracts::correspondence(name, &*stage::<dyn Correspondence>(settings)?),
        "deformer" => contracts::deformer(name, &*stage::<dyn Deformer>(settings)?),
        "format" => contracts::format(name, &*stage::<dyn Format>(settings)?),
        "generator" => contracts::generator(name, &*stage::<dyn Generator>(settings)?),
        "key_points" => contracts::key_points(name, &*stage::<dyn KeyPoints>(settings)?),
        "landmarks" => contracts::landmarks(name, &*stage::<dyn Landmarks>(settings)?),
        "metric" => contracts::metric(name, &*stage::<dyn Metric>(settings)?),
        "proximity" => contracts::proximity(name, &*stage::<dyn Proximity>(settings)?),
        "sampler" => contracts::sampler(name, &*stage::<dyn Sampler>(settings)?),
        "transfer" => contracts::transfer(name, &*stage::<dyn Transfer>(settings)?),
        "weights" => contracts::weights(name, &*stage::<dyn Weights>(settings)?),
        _ => return Err(Diagnostic::new(Kind::Usage, format!("unknown stage `{kind}`")).into()),
    }
    Ok(())
}

fn words(cause: &(dyn Any + Send)) -> String {
    let words = cause.downcast_ref::<&str>().map(|words| (*words).to_owned());
    words.or_else(|| cause.downcast_ref::<String>().cloned()).unwrap_or_default()
}
