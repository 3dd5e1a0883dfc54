use std::path::PathBuf;

use serde_json::json;

use super::{Ended, cache::CacheOptions, run::Overrides, terminal};
use crate::text::pairs;
use crate::{
    pipeline::{
        self,
        plan::{Action, Plan},
    },
    status::Status,
};

/// Tells what a run would do: which stages run, which results are kept from earlier runs, and why.
///
/// Meshes are read and checked as by `check`; nothing is computed or written.
#[derive(Debug, clap::Args)]
#[command(
    name = "plan",
    after_help = "Example:
  mimesh plan horse-to-camel.yaml --set transfer.deformer.lambda=5"
)]
pub struct PlanRun {
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

impl PlanRun {
    /// Runs the command.
    pub fn run(&self) -> Ended {
        let all = pipeline::prepare_all(&self.pipeline, &self.overrides.options())?;
        let cache = self.cache.open()?;
        let plans: Vec<_> = all.iter().map(|prepared| pipeline::plan::plan(prepared, cache.as_ref())).collect();
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
                let named = all.iter().zip(&plans).map(|(of, plan)| format!("{}\n{}", of.variant.name, text(plan)));
                terminal::print(&named.collect::<Vec<_>>().join("\n"));
            }
        }
        Ok(Status::Done)
    }
}

/// A line a stage.
fn text(plan: &Plan) -> String {
    let row = |step: &pipeline::plan::PlannedStep| {
        let what = if step.name.is_empty() { step.stage.into() } else { format!("{} ({})", step.stage, step.name) };
        let action = match step.action {
            Action::Run if step.of > 1 => format!("run {} of {}", step.runs, step.of),
            Action::Run => "run".into(),
            Action::Reuse => "reuse".into(),
            Action::Skip => "skip".into(),
        };
        (what, format!("{action}: {}", step.why))
    };
    pairs(&plan.steps.iter().map(row).collect::<Vec<_>>())
}
