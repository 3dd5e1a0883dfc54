//! Contracts of stages by their names in YAML.

use schemars::generate::SchemaSettings;
use serde::{Serialize, de::DeserializeOwned};
use serde_json::Value;

use super::{
    clusterer::clusterer, correspondence::correspondence, deformer::deformer, format::format, generator::generator,
    key_points::key_points, landmarks::landmarks, metric::metric, proximity::proximity, sampler::sampler,
    transfer::transfer, weights::weights,
};
use crate::{
    Plugin,
    plugin::{self, StageKind, ranges::check_values},
    stage::{
        Clusterer, Correspondence, Deformer, Format, Generator, KeyPoints, Landmarks, Metric, Proximity, Sampler,
        Transfer, Weights,
    },
};

/// Holds a registered stage to all that is asked of it: that it describes itself, that its settings come back from YAML, and the
/// contract of its stage; e.g. `keeps("sampler", "farthest_point")`.
///
/// A test of a plug-in names the crate first (`use my_stages as _;`), since a crate that is never named is not linked.
///
/// # Panics
///
/// If the stage breaks its contract, is not registered, or is of a kind whose contract is not in this list.
pub fn keeps(stage: &str, name: &str) {
    let registered = plugin::all().into_iter().find(|p| p.stage == stage && p.name() == name);
    let Some(registered) = registered else {
        let known: Vec<_> = plugin::all().into_iter().filter(|p| p.stage == stage).map(|p| p.name()).collect();
        panic!(
            "no {stage} `{name}` is registered; there are {known:?}. `register!` it, and name its crate in this test: \
             `use my_stages as _;`"
        );
    };
    described(registered);
    match stage {
        "clusterer" => clusterer(name, &*own::<dyn Clusterer>(name)),
        "correspondence" => correspondence(name, &*own::<dyn Correspondence>(name)),
        "deformer" => deformer(name, &*own::<dyn Deformer>(name)),
        "format" => format(name, &*own::<dyn Format>(name)),
        "key_points" => key_points(name, &*own::<dyn KeyPoints>(name)),
        "landmarks" => landmarks(name, &*own::<dyn Landmarks>(name)),
        "metric" => metric(name, &*own::<dyn Metric>(name)),
        "proximity" => proximity(name, &*own::<dyn Proximity>(name)),
        "generator" => generator(name, &*own::<dyn Generator>(name)),
        "sampler" => sampler(name, &*own::<dyn Sampler>(name)),
        "transfer" => transfer(name, &*own::<dyn Transfer>(name)),
        "weights" => weights(name, &*own::<dyn Weights>(name)),
        kind => panic!("{kind} {name}: the contract of this kind of stage is not known here"),
    }
}

/// The default of a registered stage, which comes back from YAML as it is.
fn own<S>(name: &str) -> Box<S>
where
    S: StageKind + ?Sized + Serialize,
    Box<S>: DeserializeOwned,
{
    let stage = plugin::instance::<S>(name).unwrap_or_else(|| panic!("{name} gives no instance"));
    round_trips(name, &*stage);
    stage
}

/// The contract of every registered implementation: it and each of its settings are documented, and defaults lie in their ranges.
pub fn described(plugin: &Plugin) {
    let name = plugin.name();
    let inlining = SchemaSettings::draft2020_12().with(|settings| settings.inline_subschemas = true);
    let schema = plugin.schema(&mut inlining.into_generator());
    let documented = |schema: &Value| schema.get("description").and_then(Value::as_str).is_some_and(|d| !d.is_empty());
    assert!(documented(schema.as_value()), "{name} has no doc comment");
    for (key, setting) in schema.get("properties").and_then(Value::as_object).into_iter().flatten() {
        assert!(documented(setting), "{name}.{key} has no doc comment");
    }
    let defaults = plugin.settings();
    assert!(defaults.is_object(), "{name}: settings are not a mapping");
    check_values(schema.as_value(), &defaults)
        .unwrap_or_else(|error| panic!("{name}: a default is out of range: {error}"));
}

/// Settings written out and read again are the same settings.
pub fn round_trips<S>(name: &str, stage: &S)
where
    S: StageKind + ?Sized + serde::Serialize,
    Box<S>: serde::de::DeserializeOwned,
{
    let written = serde_json::to_value(stage).unwrap_or_else(|error| panic!("{name} does not serialise: {error}"));
    assert_eq!(written["type"], name, "{name} is tagged by its own name");
    let read: Box<S> =
        serde_json::from_value(written.clone()).unwrap_or_else(|error| panic!("{name} does not read back: {error}"));
    let again = serde_json::to_value(&*read).unwrap_or_else(|error| panic!("{name} does not serialise: {error}"));
    assert_eq!(written, again, "{name} changes when written and read");
}
