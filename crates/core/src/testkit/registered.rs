//! Contracts of stages by their names in YAML.

use serde::{Serialize, de::DeserializeOwned};

use super::contracts;
use crate::{
    plugin::{self, StageKind},
    stage::{
        Clusterer, Correspondence, Deformer, Format, Generator, KeyPoints, Metric, Proximity, Sampler, Transfer,
        Weights,
    },
};

/// Holds a registered stage to all that is asked of it: that it describes itself, that its settings come back from YAML, and the
/// contract of its stage; e.g. `keeps("sampler", "farthest_point")`.
///
/// A test of a plug-in names the crate first (`use my_stages as _;`), since a crate that is never named is not linked.
pub fn keeps(stage: &str, name: &str) {
    let registered = plugin::all().into_iter().find(|p| p.stage == stage && (p.name)() == name);
    let Some(registered) = registered else {
        let known: Vec<_> = plugin::all().into_iter().filter(|p| p.stage == stage).map(|p| (p.name)()).collect();
        panic!(
            "no {stage} `{name}` is registered; there are {known:?}. `register!` it, and name its crate in this test: \
             `use my_stages as _;`"
        );
    };
    contracts::described(registered);
    match stage {
        "clusterer" => contracts::clusterer(name, &*own::<dyn Clusterer>(name)),
        "correspondence" => contracts::correspondence(name, &*own::<dyn Correspondence>(name)),
        "deformer" => contracts::deformer(name, &*own::<dyn Deformer>(name)),
        "format" => contracts::format(name, &*own::<dyn Format>(name)),
        "key_points" => contracts::key_points(name, &*own::<dyn KeyPoints>(name)),
        "metric" => contracts::metric(name, &*own::<dyn Metric>(name)),
        "proximity" => contracts::proximity(name, &*own::<dyn Proximity>(name)),
        "generator" => contracts::generator(name, &*own::<dyn Generator>(name)),
        "sampler" => contracts::sampler(name, &*own::<dyn Sampler>(name)),
        "transfer" => contracts::transfer(name, &*own::<dyn Transfer>(name)),
        "weights" => contracts::weights(name, &*own::<dyn Weights>(name)),
        // A stage of a kind that is not ours has no contract that is known here.
        _ => {}
    }
}

/// The default of a registered stage, which comes back from YAML as it is.
fn own<S>(name: &str) -> Box<S>
where
    S: StageKind + ?Sized + Serialize,
    Box<S>: DeserializeOwned,
{
    let stage = plugin::instance::<S>(name).unwrap_or_else(|| panic!("{name} gives no instance"));
    contracts::round_trips(name, &*stage);
    stage
}
