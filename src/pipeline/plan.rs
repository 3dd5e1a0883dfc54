//! What a run would do: which stages run, which results are taken from the cache, and why.

use rayon::prelude::*;
use serde::Serialize;

use super::{
    Prepared,
    cache::{Cache, Change, OfTransfer, Recipe, Record},
    shelf::Shelf,
};
use crate::core::stage::{ProximityGraph, TriangleMap};

/// What a run of a pipeline would do.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Plan {
    /// The stages in their order; poses come last.
    pub steps: Vec<PlannedStep>,
}

/// What becomes of a stage.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct PlannedStep {
    /// The stage, e.g. `correspondence`, or `poses`.
    pub stage: &'static str,
    /// Its type.
    #[serde(rename = "type")]
    pub name: String,
    /// What is done.
    pub action: Action,
    /// How many of the poses run; 0 and 1 for stages.
    pub runs: usize,
    /// Of how many.
    pub of: usize,
    /// Why.
    pub why: String,
}

/// What is done with a stage.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Action {
    /// It runs.
    Run,
    /// Its kept result is taken.
    Reuse,
    /// It is not needed, since all that depends on it is kept.
    Skip,
}

/// Plans a run of `prepared`; nothing is computed but hashes.
pub fn plan(prepared: &Prepared, cache: Option<&Cache>) -> Plan {
    let pipeline = &prepared.pipeline;
    let all = prepared.poses.len();
    let names = [
        ("proximity", pipeline.proximity.as_ref().map(|stage| stage.typetag_name())),
        ("correspondence", pipeline.correspondence.as_ref().map(|stage| stage.typetag_name())),
        ("transfer", pipeline.transfer.as_ref().map(|stage| stage.typetag_name())),
    ];
    let Some(cache) = cache else {
        let why = "results are not kept (`--no-cache`)";
        let stages = names.into_iter().filter_map(|(stage, name)| Some(step(stage, name?, Action::Run, why)));
        let poses = PlannedStep { runs: all, of: all, ..step("poses", "", Action::Run, why) };
        return Plan { steps: stages.chain([poses]).collect() };
    };
    let recipes = cache.recipes(prepared);
    let record = Record::read(&cache.store, prepared);
    let kept: Option<OfTransfer> = cache.get("transfer", recipes.transfer.key);
    let motion = kept.as_ref().is_some_and(|kept| kept.motion);
    let shelf = Shelf { cache, recipes: &recipes, motion };
    let mut missing = (0..all).into_par_iter().filter(|&i| shelf.get(i).is_none()).count();
    if motion && missing > 0 {
        missing = all;
    }
    let complete = missing == 0 && kept.is_some();
    let mut steps = Vec::new();
    for (stage, name) in names {
        let Some(name) = name else { continue };
        let (recipe, is_kept) = match stage {
            "proximity" => {
                let recipe = recipes.proximity.as_ref();
                (recipe, recipe.is_some_and(|recipe| cache.get::<ProximityGraph>(stage, recipe.key).is_some()))
            }
            "correspondence" => {
                let recipe = recipes.correspondence.as_ref();
                (recipe, recipe.is_some_and(|recipe| cache.get::<TriangleMap>(stage, recipe.key).is_some()))
            }
            _ => (Some(&recipes.transfer), complete),
        };
        let needed = !complete || (stage == "correspondence" && prepared.outputs.correspondence.is_some());
        let unchanged = recipe.is_some_and(|recipe| record.change(stage, recipe) == Change::Gone);
        steps.push(match (is_kept, needed) {
            (true, _) => step(stage, name, Action::Reuse, "kept for these settings and inputs"),
            (false, false) => step(stage, name, Action::Skip, "all poses are kept"),
            (false, true) if stage == "transfer" && unchanged && missing < all => {
                step(stage, name, Action::Run, "some poses are missing, and what it binds is not kept")
            }
            (false, true) => step(stage, name, Action::Run, &recipe.map_or(String::new(), |r| why(&record, stage, r))),
        });
    }
    let (action, reason) = match missing {
        0 if complete => (Action::Reuse, "kept for this transfer and these poses".into()),
        _ if missing == all && motion => (Action::Run, "frames of one motion are taken only all together".into()),
        _ if missing == all => (Action::Run, "none is kept for this transfer".into()),
        _ => (Action::Run, format!("{} of {all} are kept", all - missing)),
    };
    steps.push(PlannedStep { runs: missing, of: all, ..step("poses", "", action, &reason) });
    Plan { steps }
}

fn step(stage: &'static str, name: &str, action: Action, why: &str) -> PlannedStep {
    let runs = usize::from(action == Action::Run);
    PlannedStep { stage, name: name.into(), action, runs, of: 1, why: why.into() }
}

fn why(record: &Record, stage: &str, recipe: &Recipe) -> String {
    match record.change(stage, recipe) {
        Change::New => "this pipeline has not been run with this stage".into(),
        Change::Gone => "its result is no longer kept".into(),
        Change::Changed(what) => format!("changed since the last run: {}", what.join("; ")),
    }
}
