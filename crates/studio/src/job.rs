//! Long work that a page asked for: a proposal or a run.

use std::{
    fmt,
    sync::{Arc, Mutex, MutexGuard, PoisonError},
    time::{Duration, Instant},
};

use mimesh_pipeline::{Progress, progress::TimeLeft};
use serde::Serialize;
use serde_json::Value;

use crate::{
    cancel::{Cancel, Stopped},
    error::{ApiError, Code},
};

/// Pages hear of a job no oftener than this.
const STEP: Duration = Duration::from_millis(100);

/// Who hears of jobs.
#[derive(Clone)]
pub struct Tell(Arc<dyn Fn(Arc<JobView>) + Send + Sync>);

impl fmt::Debug for Tell {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Tell(..)")
    }
}

impl Tell {
    /// Tells `tell`.
    pub fn new(tell: impl Fn(Arc<JobView>) + Send + Sync + 'static) -> Self {
        Self(Arc::new(tell))
    }
}

/// What a job does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum JobKind {
    /// Finds markers by shape.
    Propose,
    /// Runs the pipeline.
    Run,
}

/// A job.
#[derive(Debug)]
pub struct Job {
    id: u64,
    kind: JobKind,
    project: u64,
    began: Instant,
    /// Stops it.
    pub cancel: Cancel,
    state: Mutex<State>,
    tell: Tell,
}

#[derive(Debug)]
struct State {
    status: JobStatus,
    stage: Option<String>,
    stage_began: Instant,
    share: Option<f64>,
    left: TimeLeft,
    poses: Option<PosesDone>,
    ended: Option<f64>,
    error: Option<ApiError>,
    warnings: Vec<String>,
    result: Option<Value>,
    told: Option<Instant>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
enum JobStatus {
    Running,
    Done,
    Failed,
    Cancelled,
}

#[derive(Clone, Copy, Debug, Serialize)]
struct PosesDone {
    done: usize,
    count: usize,
}

/// A job as pages see it.
#[derive(Clone, Debug, Serialize)]
pub struct JobView {
    id: u64,
    kind: JobKind,
    /// The project that it is about, by its number when it was opened.
    project: u64,
    state: JobStatus,
    stage: Option<String>,
    share: Option<f64>,
    poses: Option<PosesDone>,
    seconds: f64,
    seconds_left: Option<f64>,
    error: Option<ApiError>,
    warnings: Vec<String>,
    result: Option<Value>,
}

/// What a job gave.
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    /// Sentences about what looks wrong.
    pub warnings: Vec<String>,
    /// What pages get of it.
    pub result: Option<Value>,
}

impl Job {
    /// A job that begins now; what becomes of it is told to `tell`.
    pub fn new(id: u64, kind: JobKind, project: u64, tell: Tell) -> Self {
        let began = Instant::now();
        let state = State {
            status: JobStatus::Running,
            stage: None,
            stage_began: began,
            share: None,
            left: TimeLeft::default(),
            poses: None,
            ended: None,
            error: None,
            warnings: vec![],
            result: None,
            told: None,
        };
        Self { id, kind, project, began, cancel: Cancel::default(), state: Mutex::new(state), tell }
    }

    /// Its number.
    pub fn id(&self) -> u64 {
        self.id
    }

    /// What it does.
    pub fn kind(&self) -> JobKind {
        self.kind
    }

    /// The job as pages see it.
    pub fn view(&self) -> Arc<JobView> {
        let state = self.lock();
        Arc::new(JobView {
            id: self.id,
            kind: self.kind,
            project: self.project,
            state: state.status,
            stage: state.stage.clone(),
            share: state.share,
            poses: state.poses,
            seconds: state.ended.unwrap_or_else(|| self.began.elapsed().as_secs_f64()),
            seconds_left: state
                .left
                .seconds(state.stage_began.elapsed().as_secs_f64())
                .filter(|_| state.ended.is_none()),
            error: state.error.clone(),
            warnings: state.warnings.clone(),
            result: state.result.clone(),
        })
    }

    /// Names the stage under way.
    pub fn begin(&self, stage: &str) {
        self.cancel.check();
        self.change(true, |state| {
            (state.stage, state.share, state.left) = (Some(stage.into()), None, TimeLeft::default());
            state.stage_began = Instant::now();
        });
    }

    /// Notes how much of the stage is done.
    pub fn share(&self, share: f64) {
        self.cancel.check();
        self.change(false, |state| {
            let time = state.stage_began.elapsed().as_secs_f64();
            state.left.report(time, share);
            state.share = Some(share);
        });
    }

    /// Whether it goes on.
    pub fn is_running(&self) -> bool {
        self.lock().status == JobStatus::Running
    }

    /// Notes how it ended.
    pub fn finish(&self, done: Result<Result<Outcome, ApiError>, Stopped>) {
        self.change(true, |state| {
            (state.ended, state.stage) = (Some(self.began.elapsed().as_secs_f64()), None);
            match done {
                Ok(Ok(Outcome { warnings, result })) => {
                    (state.status, state.warnings, state.result) = (JobStatus::Done, warnings, result);
                }
                Ok(Err(error)) => (state.status, state.error) = (JobStatus::Failed, Some(error)),
                Err(Stopped::Cancelled) => state.status = JobStatus::Cancelled,
                Err(Stopped::Panicked(words)) => {
                    let error = ApiError::new(Code::Internal, format!("the program made a mistake: {words}"));
                    (state.status, state.error) = (JobStatus::Failed, Some(error));
                }
            }
        });
    }

    fn change(&self, is_important: bool, change: impl FnOnce(&mut State)) {
        let mut state = self.lock();
        change(&mut state);
        if !is_important && state.told.is_some_and(|told| told.elapsed() < STEP) {
            return;
        }
        state.told = Some(Instant::now());
        drop(state);
        (self.tell.0)(self.view());
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Progress for Job {
    fn stage(&self, name: &str) {
        self.begin(name);
    }

    fn done(&self, share: f64) {
        self.share(share);
    }

    fn poses(&self, count: usize) {
        self.begin("poses");
        self.change(true, |state| state.poses = Some(PosesDone { done: 0, count }));
    }

    fn pose_done(&self) {
        self.cancel.check();
        self.change(false, |state| {
            if let Some(poses) = &mut state.poses {
                poses.done += 1;
                let share = poses.done as f64 / poses.count.max(1) as f64;
                let time = state.stage_began.elapsed().as_secs_f64();
                state.left.report(time, share);
                state.share = Some(share);
            }
        });
    }
}
