//! The work of a pipeline as tasks: stages that run once, parts of the poses, and the results.

/// A pipeline as a job of many tasks, with all that its commands need.
#[derive(Debug)]
pub struct Job {
    /// What the engine shows for it.
    pub name: String,
    /// The program `mimesh` on the machines that work.
    pub program: String,
    /// The pipeline's file, absolute.
    pub pipeline: String,
    /// The folder of the cache that all tasks share, absolute.
    pub cache: String,
    /// Options that change the pipeline, and others of all its commands.
    pub options: Vec<String>,
    /// The runs that the pipeline declares.
    pub runs: Vec<RunOfJob>,
    /// The most poses of a task, but for motions that cannot be split.
    pub chunk: usize,
    /// The folder that the files are for, absolute.
    pub folder: String,
}

/// One of the runs.
#[derive(Clone, Debug)]
pub struct RunOfJob {
    /// Its name; empty for the only run of a pipeline without targets and matrix.
    pub name: String,
    /// The number of its poses.
    pub poses: usize,
    /// The most poses of a task.
    pub chunk: usize,
    /// Frames that each part begins earlier, for a motion that is split.
    pub warm: Option<usize>,
}

/// The poses of one run that a task transfers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Task {
    /// The run, from 0.
    pub run: usize,
    /// Its first pose, from 0.
    pub first: usize,
    /// Its last pose.
    pub last: usize,
}

impl RunOfJob {
    /// The number of its tasks.
    pub fn tasks(&self) -> usize {
        self.poses.div_ceil(self.chunk)
    }

    /// `--warm` of the commands that know it.
    pub fn warm_options(&self) -> Vec<String> {
        self.warm.map(|frames| vec!["--warm".into(), frames.to_string()]).unwrap_or_default()
    }
}

impl Job {
    /// The tasks that transfer poses, in the order of runs and poses.
    pub fn tasks(&self) -> impl Iterator<Item = Task> + '_ {
        self.runs.iter().enumerate().flat_map(|(run, &RunOfJob { poses, chunk, .. })| {
            let last = move |first: usize| (first + chunk).min(poses) - 1;
            (0..poses).step_by(chunk).map(move |first| Task { run, first, last: last(first) })
        })
    }

    /// The command of the stages that run once, for one run.
    pub fn prepare(&self, run: usize) -> Vec<String> {
        self.command("prepare", run, &[])
    }

    /// The command of a task.
    pub fn transfer(&self, task: Task) -> Vec<String> {
        let frames = ["--frames".to_owned(), format!("{}-{}", task.first, task.last)];
        self.command("run", task.run, &[&frames[..], &self.runs[task.run].warm_options()].concat())
    }

    /// The command that writes the results of one run.
    pub fn merge(&self, run: usize) -> Vec<String> {
        self.command("merge", run, &self.runs[run].warm_options())
    }

    fn command(&self, subcommand: &str, run: usize, more: &[String]) -> Vec<String> {
        let run = &self.runs[run].name;
        let mut words = vec![self.program.clone(), subcommand.into(), self.pipeline.clone()];
        if !run.is_empty() {
            // In one word, since a name may begin with a dash.
            words.push(format!("--run={run}"));
        }
        words.extend(more.iter().cloned());
        words.extend(["--cache".into(), self.cache.clone(), "--quiet".into()]);
        words.extend(self.options.iter().cloned());
        words
    }
}
