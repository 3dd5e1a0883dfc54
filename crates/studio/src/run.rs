//! Running the pipeline in full.

use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

use mimesh_document::diagnostic::Diagnostics;
use mimesh_pipeline::{Finished, Plan, Prepared, Report, metrics::Level, prepare_all, run};
use serde_json::{Value, json};

use crate::{
    error::{ApiError, Code, Result},
    job::{Job, JobKind, JobView, Outcome},
    project::Project,
    studio::Studio,
    summary::Summary,
    worst::Worst,
};

impl Studio {
    /// Begins to run the pipeline of what is open, as it is saved.
    ///
    /// # Errors
    ///
    /// If a run is under way.
    pub fn run(self: &Arc<Self>) -> Result<Arc<JobView>> {
        let project = self.project()?;
        let studio = self.clone();
        self.jobs.start(JobKind::Run, project.opened, move |job| studio.run_all(&project, job))
    }

    fn run_all(&self, project: &Project, job: &Job) -> Result<Outcome> {
        job.begin("reading");
        project.pipeline.save_new();
        let pipeline = project.pipeline.revision();
        let (markers, pairs) = project.markers.pairs();
        // Files number pairs without a name by their places.
        let number_at =
            |place: usize| pairs.get(place).filter(|pair| pair.content.name.is_none()).map(|pair| pair.number);
        let cache = self.context.cache.as_ref();
        let all = prepare_all(project.pipeline.file(), &self.context.options(project.pipeline.file()), cache)?;
        let mut warnings = Vec::new();
        let mut reports = Vec::new();
        for prepared in &all {
            let plan = Plan::new(prepared, cache);
            let done = run(prepared, &plan, 0, cache, job);
            let Finished { report, failed } = done.map_err(|failure: Diagnostics| ApiError::of(&failure))?;
            warnings.extend(failed.iter().map(|diagnostic| format!("a pose failed: {}", diagnostic.message)));
            warnings.extend(report.warnings.iter().cloned());
            reports.push(report);
        }
        warnings.dedup();
        let one = reports
            .first()
            .ok_or_else(|| ApiError::new(Code::Internal, "a pipeline without a run was taken for checked"))?;
        let written: Vec<PathBuf> = reports.iter().flat_map(files_of).collect();
        let verdict = reports.iter().filter_map(|report| report.verdict).max();
        let status = if reports.iter().any(|report| report.status != "done") {
            "partly"
        } else if verdict == Some(Level::Failed) {
            "gate"
        } else {
            "done"
        };
        let prepared = all.first();
        let result = json!({
            "status": status,
            "verdict": verdict,
            "written": written.iter().map(|path| written_view(path)).collect::<Vec<_>>(),
            "report": if reports.len() == 1 { json!(one) } else { json!(reports) },
            "summary": Summary::new(one, &(self.context.help)(project.pipeline.file())),
            "of": { "project": project.number, "markers": markers, "pipeline": pipeline },
            "worst": prepared.map(|prepared| worst(one, project, prepared, number_at)).unwrap_or_default(),
        });
        self.allow_written(written);
        Ok(Outcome { warnings, result: Some(result) })
    }
}

/// The files of a run, its report among them.
fn files_of(report: &Report) -> Vec<PathBuf> {
    let own = Some(report.place.clone()).filter(|place| !place.as_os_str().is_empty());
    report.outputs.iter().map(|file| file.path.clone()).chain(own).collect()
}

fn written_view(path: &Path) -> Value {
    let bytes = std::fs::metadata(path).map_or(0, |metadata| metadata.len());
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    json!({ "name": name, "path": path, "bytes": bytes, "url": format!("/api/written?path={}", escaped(path)) })
}

/// A path as the value of a query.
fn escaped(path: &Path) -> String {
    let is_plain = |byte: u8| byte.is_ascii_alphanumeric() || b"-._~/".contains(&byte);
    let bytes = path.to_string_lossy().into_owned().into_bytes();
    bytes
        .iter()
        .map(|&byte| if is_plain(byte) { char::from(byte).to_string() } else { format!("%{byte:02X}") })
        .collect()
}

/// All statistics above their limits, worst first.
fn worst(
    report: &Report,
    project: &Project,
    prepared: &Prepared,
    number_at: impl Fn(usize) -> Option<usize>,
) -> Vec<Worst> {
    let of_rest = report.rest_verdict.iter().flat_map(|verdict| verdict.reasons.iter().map(|reason| (None, reason)));
    let of_poses = report.poses.iter().enumerate().flat_map(|(i, pose)| {
        pose.verdict.iter().flat_map(move |verdict| verdict.reasons.iter().map(move |reason| (Some(i), reason)))
    });
    let one = |(pose, reason)| Worst::new(pose, reason, project, prepared, None).renumbered(&number_at);
    Worst::sorted(of_rest.chain(of_poses).map(one).collect())
}
