//! Finding pairs by shape.

use std::sync::Arc;

use mimesh_core::{
    plugin::instance,
    stage::{Landmarks, Work},
};
use mimesh_pipeline::propose::propose;

use crate::{
    error::{ApiError, Code, Result},
    events::Cause,
    job::{Job, JobKind, JobView, Outcome},
    markers::{Status, pair::Content, store::Usable},
    project::Project,
    studio::Studio,
};

/// The stage that finds markers where the pipeline names none.
const DEFAULT_LANDMARKS: &str = "extremities";

impl Studio {
    /// Begins to find pairs by shape; reading number `other` of the shapes, where 0 is the likeliest.
    ///
    /// # Errors
    ///
    /// If that is under way already.
    pub fn propose(self: &Arc<Self>, project: Arc<Project>, other: usize) -> Result<Arc<JobView>> {
        let studio = self.clone();
        self.jobs.start(JobKind::Propose, project.opened, move |job| studio.proposed(&project, other, job))
    }

    fn proposed(&self, project: &Project, other: usize, job: &Job) -> Result<Outcome> {
        let default = instance::<dyn Landmarks>(DEFAULT_LANDMARKS);
        let stage = project.landmarks.as_deref().or(default.as_deref()).ok_or_else(|| {
            ApiError::new(Code::Unprocessable, "no stage that finds landmarks is part of this program")
        })?;
        job.begin(&format!("landmarks ({})", stage.typetag_name()));
        let Usable { markers, contents, .. } = project.markers.usable();
        let clicks = markers.into_iter().zip(contents).filter(|(_, content)| content.status == Status::Confirmed);
        let clicks: Vec<_> = clicks.map(|(marker, _)| marker).collect();
        let sides = [&*project.meshes.sides[0], &*project.meshes.sides[1]];
        let report = |share| job.share(share);
        let proposal = propose(stage, sides, &clicks, self.context.allow_commands, Work::new(&report))?;
        let pairs = match other {
            0 => &proposal.pairs,
            n => proposal.others.get(n - 1).ok_or_else(|| {
                let message = format!("there are {} other readings of the shapes", proposal.others.len());
                ApiError::new(Code::Unprocessable, message)
            })?,
        };
        let content = |pair: &mimesh_core::stage::ProposedPair| Content {
            name: Some(pair.marker.name.clone()),
            points: [
                Some(sides[0].surface.mesh_point(pair.marker.source).into()),
                Some(sides[1].surface.mesh_point(pair.marker.target).into()),
            ],
            status: Status::Proposed,
            // Four digits are more than it is worth.
            confidence: Some((pair.confidence * 1e4).round() / 1e4),
            ..Content::default()
        };
        let clicked: Vec<_> = clicks.iter().map(|click| (click.source, click.target)).collect();
        let is_new =
            |pair: &&mimesh_core::stage::ProposedPair| !clicked.contains(&(pair.marker.source, pair.marker.target));
        let contents: Vec<Content> = pairs.iter().filter(is_new).map(content).collect();
        job.cancel.check();
        if project.markers.propose(contents).is_changed {
            self.markers_changed(project, Cause::Propose);
        }
        Ok(Outcome { warnings: proposal.figures.warnings.clone(), result: None })
    }
}
