//! The plan of a run: which stages run, which results are taken from the cache, and why.
//!
//! A plan is made once; a run executes it, and a program may show it.

use mimesh_core::stage::{Proposal, TriangleMap};
use serde::Serialize;

use crate::{
    cache::{Cache, CacheCodec, Change, LastRun, RunKeys, StageKey},
    cached_run::CachedRun,
    choices::Choice,
    input::Prepared,
    shard::{Extent, Merge, Part, PoseOrder},
};

/// The plan of a run.
#[derive(Clone, Debug, Serialize)]
pub struct Plan {
    /// The stages in their order; poses come last.
    pub steps: Vec<PlannedStep>,
    /// What was chosen where the pipeline leaves it open.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub choices: Vec<Choice>,
    /// What is worth knowing before the run.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<String>,
    /// What the cache holds of the run; `None` for a run without a cache.
    #[serde(skip)]
    pub cached: Option<CachedRun>,
    /// Whether all poses are computed, a part of them or none.
    #[serde(skip)]
    pub extent: Extent,
    /// The poses that have to be there in the end.
    #[serde(skip)]
    pub order: PoseOrder,
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
    /// How many of the poses run; 0 or 1 for stages.
    pub runs: usize,
    /// The number of poses; 1 for stages.
    pub of: usize,
    /// The reason.
    pub why: String,
}

/// What is done with a stage.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Action {
    /// It runs.
    Run,
    /// Its cached result is taken.
    Reuse,
    /// It is not needed, since all that depends on it is cached.
    Skip,
}

impl Plan {
    /// Plans a run of `prepared`; nothing is computed but hashes.
    pub fn new(prepared: &Prepared, cache: Option<&Cache>) -> Self {
        Self::of(prepared, cache, Extent::Whole)
    }

    /// Plans a run of some poses of `prepared`.
    pub fn of_part(prepared: &Prepared, cache: Option<&Cache>, part: Part) -> Self {
        Self::of(prepared, cache, Extent::Part(part))
    }

    /// Plans to write all files of `prepared`, whose poses are taken from `cache`; its missing poses say whether that can be done.
    pub fn of_merge(prepared: &Prepared, cache: &Cache, merge: Merge) -> Self {
        Self::of(prepared, Some(cache), Extent::Merge(merge))
    }

    /// The poses that have to run, or, for a merge, that no part has computed; all of them without a cache.
    pub fn missing(&self) -> &[usize] {
        self.cached.as_ref().map_or(self.order.poses(), |cached| &cached.missing)
    }

    /// Whether the results of all poses are cached.
    pub fn is_complete(&self) -> bool {
        self.cached.as_ref().is_some_and(|cached| cached.complete)
    }

    /// Whether a run of `prepared` needs the triangle map: to transfer, to measure unless all poses are `measured`, or to write it.
    pub fn needs_map(&self, prepared: &Prepared, measured: bool) -> bool {
        needs_map(prepared, &self.extent, self.is_complete(), measured)
    }

    fn of(prepared: &Prepared, cache: Option<&Cache>, extent: Extent) -> Self {
        match cache {
            Some(cache) => Self::with_cache(prepared, cache, extent),
            None => Self::without_cache(prepared, extent),
        }
    }

    fn without_cache(prepared: &Prepared, extent: Extent) -> Self {
        let reason = "the run does without the cache";
        let order = match &extent {
            Extent::Part(part) => match &prepared.pipeline.transfer {
                Some(transfer) if transfer.gives_motion() => {
                    PoseOrder::in_motion(part.poses.clone(), part.warm.unwrap_or(0))
                }
                _ => PoseOrder::alone(part.poses.clone()),
            },
            _ => PoseOrder::all(prepared.poses.len()),
        };
        let mut steps: Vec<_> =
            stages(prepared).into_iter().map(|(stage, name)| step(stage, name, Action::Run, reason)).collect();
        steps.push(PlannedStep { runs: order.len(), of: order.len(), ..step("poses", "", Action::Run, reason) });
        let (choices, warnings) = (prepared.choices.clone(), warnings(prepared));
        Self { steps, choices, warnings, cached: None, extent, order }
    }

    fn with_cache(prepared: &Prepared, cache: &Cache, extent: Extent) -> Self {
        let (cached, order) = CachedRun::new(prepared, cache, &extent);
        let last_run = LastRun::read(&cache.store, prepared);
        let mut steps: Vec<_> = stages(prepared)
            .into_iter()
            .map(|(stage, name)| planned(stage, name, prepared, cache, &cached, &extent, &last_run))
            .collect();
        steps.push(planned_poses(order.len(), &cached));
        let (choices, warnings) = (prepared.choices.clone(), warnings(prepared));
        Self { steps, choices, warnings, cached: Some(cached), extent, order }
    }
}

fn needs_map(prepared: &Prepared, extent: &Extent, complete: bool, measured: bool) -> bool {
    let measures = !measured && prepared.metrics.iter().any(|metric| !metric.needs_ground_truth());
    !complete || measures || (prepared.outputs.correspondence.is_some() && !extent.is_part())
}

/// The stages of a run with their types, in their order.
fn stages(prepared: &Prepared) -> Vec<(&'static str, &str)> {
    let pipeline = &prepared.pipeline;
    let types = [
        prepared.landmarks().map(|stage| stage.typetag_name()),
        pipeline.proximity.as_ref().map(|stage| stage.typetag_name()),
        pipeline.correspondence.as_ref().map(|stage| stage.typetag_name()),
        pipeline.transfer.as_ref().map(|stage| stage.typetag_name()),
    ];
    RunKeys::STAGES.into_iter().zip(types).filter_map(|(stage, name)| Some((stage, name?))).collect()
}

fn planned(
    stage: &'static str,
    name: &str,
    prepared: &Prepared,
    cache: &Cache,
    cached: &CachedRun,
    extent: &Extent,
    last_run: &LastRun,
) -> PlannedStep {
    let key = cached.keys.stages().into_iter().find(|(name, _)| *name == stage).and_then(|(_, key)| key);
    let (is_cached, needed) = match stage {
        "landmarks" => (key.is_some_and(|key| is_readable::<Proposal>(cache, stage, key)), true),
        "proximity" => {
            let reused = prepared.proximity.as_ref().is_some_and(|proximity| proximity.report.reused);
            (reused, !cached.complete)
        }
        "correspondence" => {
            let readable = key.is_some_and(|key| is_readable::<TriangleMap>(cache, stage, key));
            (readable, needs_map(prepared, extent, cached.complete, cached.measured))
        }
        _ => (cached.complete, !cached.complete),
    };
    let unchanged = key.is_some_and(|key| last_run.change(stage, key) == Change::Gone);
    match (is_cached, needed) {
        (true, _) => step(stage, name, Action::Reuse, "cached for these settings and inputs"),
        (false, false) => step(stage, name, Action::Skip, "all poses are cached"),
        (false, true)
            if stage == "transfer" && unchanged && (1..prepared.poses.len()).contains(&cached.missing.len()) =>
        {
            step(stage, name, Action::Run, "some poses are missing, and a bound transfer is not cached")
        }
        (false, true) => step(stage, name, Action::Run, &key.map_or(String::new(), |key| reason(last_run, stage, key))),
    }
}

fn planned_poses(all: usize, cached: &CachedRun) -> PlannedStep {
    let motion = cached.transfer.as_ref().is_some_and(|transfer| transfer.motion);
    let (action, reason) = match cached.missing.len() {
        0 => (Action::Reuse, "cached for this transfer and these poses".into()),
        missing if missing == all && motion => (Action::Run, "frames of one motion are used only all together".into()),
        missing if missing == all => (Action::Run, "none is cached for this transfer".into()),
        missing => (Action::Run, format!("{} of {all} are cached", all - missing)),
    };
    PlannedStep { runs: cached.missing.len(), of: all, ..step("poses", "", action, &reason) }
}

/// Whether the cache holds a result that can be read.
fn is_readable<T: CacheCodec>(cache: &Cache, stage: &str, key: &StageKey) -> bool {
    cache.get::<T>(stage, key.key).is_some()
}

fn step(stage: &'static str, name: &str, action: Action, why: &str) -> PlannedStep {
    let runs = usize::from(action == Action::Run);
    PlannedStep { stage, name: name.into(), action, runs, of: 1, why: why.into() }
}

/// Why `stage` has no result.
fn reason(last_run: &LastRun, stage: &str, key: &StageKey) -> String {
    match last_run.change(stage, key) {
        Change::New => "this pipeline has not been run with this stage".into(),
        Change::Gone => "its result is no longer cached".into(),
        Change::Changed(inputs) => format!("changed since the last run: {}", inputs.join("; ")),
    }
}

/// What is worth knowing before a run of `prepared`.
fn warnings(prepared: &Prepared) -> Vec<String> {
    prepared.warnings.iter().chain(&prepared.unfinished).cloned().collect()
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use crate::{cache::RunKeys, schema::SchemaNode};

    /// The kinds of stages in slots that no run uses.
    const UNUSED: [&str; 1] = ["key_points"];

    /// A stage that is neither would be left out of the keys, and results from before it was added or changed would be reused.
    #[test]
    fn every_slot_of_a_stage_is_planned() {
        let slots = SchemaNode::pipeline().properties(None).into_iter();
        let found: BTreeSet<_> = slots.filter_map(|(_, node)| node.stage()).collect();
        assert_eq!(found, RunKeys::STAGES.into_iter().chain(UNUSED).collect());
    }
}
