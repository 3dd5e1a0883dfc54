//! Stages that run once, computed before parts of a run need them.

use mimesh_document::{Diagnostic, Kind, diagnostic::Result};
use tracing::info_span;

use super::{execute::in_pool, stages::Stages};
use crate::{
    cache::{Cache, Timing},
    input::Prepared,
    plan::Plan,
    progress::Progress,
    report::StageReport,
};

/// Computes the stages of `prepared` that run once and stores them in `cache`; what is there is not computed again. The transfer is bound
/// once, to find what is wrong with it. A bound transfer is no data, so that each part binds it again.
///
/// Each result is locked while it is computed.
///
/// # Errors
///
/// Those of the stages, and [`Kind::Busy`] if another process computes one of them now.
pub fn prepare_stages(
    prepared: &Prepared,
    threads: usize,
    cache: &Cache,
    progress: &dyn Progress,
) -> Result<Vec<StageReport>> {
    in_pool(threads, || {
        let _preparing = info_span!("prepare", "type" = &*prepared.variant.name).entered();
        let Some(transfer) = &prepared.pipeline.transfer else {
            return Err(Diagnostic::new(Kind::Internal, "a pipeline without a transfer was taken for checked").into());
        };
        let plan = Plan::new(prepared, Some(cache));
        let stages = Stages::new(prepared, &plan, transfer.as_ref(), Some(cache), progress).locked();
        stages.propose()?;
        stages.map()?;
        stages.bind_once()?;
        if let (Some(cached), Some(seconds)) = (&plan.cached, stages.seconds_of_binding()) {
            let key = cached.keys.transfer.key;
            let timing = Timing::read(cache, key).unwrap_or_default();
            let start_seconds = prepared.seconds() + seconds;
            Timing { threads: rayon::current_num_threads(), start_seconds, ..timing }.store(cache, key);
        }
        cache.store.clean_up();
        Ok(stages.into_reports())
    })
}
