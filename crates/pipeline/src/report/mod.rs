//! What a run did: the contents of `run.json`, and tables of several runs.

mod process;
mod run_report;
mod stage;
mod statistics;
mod table;

pub use process::{Usage, usage};
pub use run_report::{InputReport, MeshFigures, MeshView, PartReport, PoseReport, ProposedMarker, Report, RunOf};
pub use stage::{Clock, StageReport};
pub use statistics::Statistics;
pub use table::{Results, Row, RunOutcome};
