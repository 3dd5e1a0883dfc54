//! `mimesh plan`: the steps of a run, without running them.

use std::path::PathBuf;

use clap::value_parser;
use serde::Serialize;
use serde_json::json;
use {
    mimesh_pipeline as pipeline,
    mimesh_pipeline::{
        Options,
        choices::rows,
        plan::{Action, Plan, PlannedStep},
        shard::{ShardPlan, megabytes_of_poses, plan_shards},
        text::{bytes, pairs, seconds, table},
    },
};

use crate::cli::{
    CommandResult, cache::CacheOptions, check::warnings, overrides::Overrides, shard_options::RunNames, status::Status,
    terminal,
};

/// Shows what a run would do: which stages run, which results come from the cache, and why.
///
/// The command reads and checks the meshes as `check` does. It writes nothing, and computes nothing but the proximity
/// graph.
#[derive(Debug, clap::Args)]
#[command(
    name = "plan",
    after_help = "Examples:
  mimesh plan horse-to-camel.yaml --set transfer.deformer.lambda=5
  mimesh plan horse-to-camel.yaml --shards 4 --json"
)]
pub struct PlanCommand {
    /// The pipeline's YAML file
    pipeline: PathBuf,
    #[command(flatten)]
    overrides: Overrides,
    #[command(flatten)]
    runs: RunNames,
    /// Also show the run in N shards: the poses of each, how many are cached, and what it will take as far as that is known
    #[arg(long, value_name = "N", value_parser = value_parser!(u32).range(1..))]
    shards: Option<u32>,
    /// Frames of one motion: begin each shard N frames earlier, as `mimesh run --warm N` does
    #[arg(long, value_name = "N", requires = "shards")]
    warm: Option<usize>,
    #[command(flatten)]
    cache: CacheOptions,
    /// Print the plan as JSON
    #[arg(long)]
    json: bool,
}

impl PlanCommand {
    /// Runs the command.
    pub fn run(&self) -> CommandResult {
        let cache = self.cache.open()?;
        let options = Options { runs: self.runs.names.clone(), ..self.overrides.options() };
        let all = pipeline::prepare_all(&self.pipeline, &options, cache.as_ref())?;
        let mut plans = Vec::new();
        for prepared in &all {
            let plan = Plan::new(prepared, cache.as_ref());
            let shards = match self.shards {
                Some(shards) => Some(plan_shards(prepared, &plan, cache.as_ref(), shards as usize, self.warm)?),
                None => None,
            };
            plans.push(ShownPlan { plan, cache_limit: megabytes_of_poses([prepared]), shards });
        }
        if !self.json {
            warnings(&all).iter().for_each(|warning| terminal::warn(warning));
        }
        match (&plans[..], self.json) {
            ([plan], true) => terminal::print_json(plan),
            ([plan], false) => terminal::print(&text(plan)),
            (_, true) => {
                let named = all
                    .iter()
                    .zip(&plans)
                    .map(|(prepared, plan)| json!({ "run": prepared.variant.name, "plan": plan }));
                terminal::print_json(&named.collect::<Vec<_>>());
            }
            (_, false) => {
                let named =
                    all.iter().zip(&plans).map(|(prepared, plan)| format!("{}\n{}", prepared.variant.name, text(plan)));
                terminal::print(&named.collect::<Vec<_>>().join("\n"));
            }
        }
        Ok(Status::Done)
    }
}

/// A plan, with its shards if they are asked for.
#[derive(Serialize)]
struct ShownPlan {
    #[serde(flatten)]
    plan: Plan,
    /// The limit of the cache in megabytes within which all poses stay until a merge takes them.
    cache_limit: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    shards: Option<Vec<ShardPlan>>,
}

/// The plan as text, with one line for each step.
fn text(ShownPlan { plan, shards, .. }: &ShownPlan) -> String {
    let shards = shards.as_ref().map(|shards| format!("\n{}", table_of(shards))).unwrap_or_default();
    let steps = pairs(&plan.steps.iter().map(row).collect::<Vec<_>>());
    let steps =
        if plan.choices.is_empty() { steps } else { format!("{steps}chosen by the meshes\n{}", rows(&plan.choices)) };
    steps + &shards
}

/// The shards, one a line; columns of which nothing is known are left out.
fn table_of(shards: &[ShardPlan]) -> String {
    let knows_time = shards.iter().any(|shard| shard.seconds.is_some());
    let knows_memory = shards.iter().any(|shard| shard.memory_bytes.is_some());
    let mut headings = vec!["shard".to_owned(), "frames".into(), "poses".into(), "cached".into()];
    headings.extend(knows_time.then(|| "about".into()));
    headings.extend(knows_memory.then(|| "memory".into()));
    let row = |shard: &ShardPlan| {
        let frames = if shard.frames.is_empty() { "none".into() } else { shard.frames.clone() };
        let mut row = vec![shard.shard.clone(), frames, shard.poses.to_string(), shard.cached.to_string()];
        if knows_time {
            row.push(shard.seconds.map(seconds).unwrap_or_default());
        }
        if knows_memory {
            row.push(shard.memory_bytes.map(bytes).unwrap_or_default());
        }
        row
    };
    let rows: Vec<Vec<String>> = std::iter::once(headings).chain(shards.iter().map(row)).collect();
    format!("shards\n{}", table(&rows))
}

/// A step, and what is done with it.
fn row(step: &PlannedStep) -> (String, String) {
    let name = if step.name.is_empty() { step.stage.into() } else { format!("{} ({})", step.stage, step.name) };
    let action = match step.action {
        Action::Run if step.of > 1 => format!("run {} of {}", step.runs, step.of),
        Action::Run => "run".into(),
        Action::Reuse => "reuse".into(),
        Action::Skip => "skip".into(),
    };
    (name, format!("{action}: {}", step.why))
}
