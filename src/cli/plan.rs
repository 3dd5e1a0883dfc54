//! `mimesh plan`: the steps of a run, without running them.

use std::path::PathBuf;

use serde_json::json;
use {
    mimesh_pipeline as pipeline,
    mimesh_pipeline::{
        choices::rows,
        plan::{Action, Plan, PlannedStep},
        text::pairs,
    },
};

use crate::cli::{CommandResult, cache::CacheOptions, check::warnings, run::Overrides, status::Status, terminal};

/// Shows what a run would do: which stages run, which results come from the cache, and why.
///
/// The command reads and checks the meshes as `check` does. It writes nothing, and computes nothing but the proximity
/// graph.
#[derive(Debug, clap::Args)]
#[command(
    name = "plan",
    after_help = "Example:
  mimesh plan horse-to-camel.yaml --set transfer.deformer.lambda=5"
)]
pub struct PlanCommand {
    /// The pipeline's YAML file
    pipeline: PathBuf,
    #[command(flatten)]
    overrides: Overrides,
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
        let all = pipeline::prepare_all(&self.pipeline, &self.overrides.options(), cache.as_ref())?;
        let plans: Vec<_> = all.iter().map(|prepared| Plan::new(prepared, cache.as_ref())).collect();
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

/// The plan as text, with one line for each step.
fn text(plan: &Plan) -> String {
    let steps = pairs(&plan.steps.iter().map(row).collect::<Vec<_>>());
    if plan.choices.is_empty() { steps } else { format!("{steps}chosen by the meshes\n{}", rows(&plan.choices)) }
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
