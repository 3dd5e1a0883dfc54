//! `mimesh submit`: a pipeline as the files of a job for an engine that spreads work over machines.

mod files;
mod hyperqueue;
mod job;
mod openjd;
mod shell;
mod slurm;

use std::{
    fs,
    path::{Path, PathBuf},
};

use clap::ValueEnum;
use mimesh_document::{
    Diagnostic, Kind,
    diagnostic::{Location, Result},
};
use {
    mimesh_pipeline as pipeline,
    mimesh_pipeline::{
        Options, Prepared,
        cache::DEFAULT_LIMIT,
        shard::{bytes_of_poses, megabytes_of_poses},
        text::{bytes, count},
    },
};

use self::{
    files::JobFile,
    job::{Job, RunOfJob},
};
use crate::cli::{
    CommandResult, absolute_path::absolute, out_file::write_all, overrides::Overrides, run::threads,
    shard_options::RunNames, status::Status, terminal,
};

/// The engines that files are written for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Engine {
    /// Open Job Description, for AWS Deadline Cloud and others
    #[value(name = "openjd")]
    OpenJd,
    /// Arrays of Slurm
    Slurm,
    /// HyperQueue
    Hq,
    /// A script for one machine, or for engines that number tasks
    Shell,
}

/// Writes the files of a job that runs a pipeline on many machines, for an engine that you have.
///
/// No engine is contacted. The job has three steps: stages that run once, the poses in tasks of some frames each, and the results. Tasks meet in the cache, a
/// folder that all machines see. Results have the bytes of `mimesh run`. A task may be run again at any time, which computes nothing twice.
#[derive(Debug, clap::Args)]
#[command(
    name = "submit",
    after_help = "Examples:
  mimesh submit --to openjd horse-to-camel.yaml --cache /farm/cache
  mimesh submit --to slurm herd.yaml --chunk 200 --dir jobs/herd
  mimesh submit --to shell herd.yaml && bash herd-job/job.sh all 4"
)]
pub struct Submit {
    /// The pipeline's YAML file
    pipeline: PathBuf,
    /// The engine
    #[arg(long, value_name = "ENGINE", value_enum)]
    to: Engine,
    #[command(flatten)]
    overrides: Overrides,
    #[command(flatten)]
    runs: RunNames,
    /// The most poses of a task; the smaller, the more often stages that are not cached are computed [default: 100]
    #[arg(long, value_name = "FRAMES", default_value = "100", hide_default_value = true, value_parser = chunk)]
    chunk: usize,
    /// Frames of one motion: begin each task N frames earlier, as `mimesh run --warm N` does
    #[arg(long, value_name = "N")]
    warm: Option<usize>,
    /// The folder of the cache, which all machines see [default: cache, in the folder of the job]
    #[arg(long, value_name = "DIR")]
    cache: Option<PathBuf>,
    /// Limit the cache to this many megabytes [default: what all poses take, and 2048 at least]
    #[arg(long, value_name = "MB")]
    cache_limit: Option<u64>,
    /// The program on the machines that work [default: this one]
    #[arg(long, value_name = "PROGRAM")]
    program: Option<String>,
    /// Threads that each task uses [default: all of its machine]
    #[arg(long, value_name = "N", value_parser = threads)]
    threads: Option<u16>,
    /// Let stages run programs that the pipeline names
    #[arg(long)]
    allow_commands: bool,
    /// The folder for the files of the job [default: NAME-job, beside NAME.yaml]
    #[arg(long, value_name = "DIR")]
    dir: Option<PathBuf>,
}

impl Submit {
    /// Runs the command.
    pub fn run(&self) -> CommandResult {
        let runs = self.runs.names.clone();
        let options = Options { allow_commands: self.allow_commands, runs, ..self.overrides.options() };
        let all = pipeline::prepare_all(&self.pipeline, &options, None)?;
        let job = self.job(&all)?;
        let files = match self.to {
            Engine::OpenJd => openjd::files(&job)?,
            Engine::Slurm => slurm::files(&job),
            Engine::Hq => hyperqueue::files(&job)?,
            Engine::Shell => shell::files(&job),
        };
        let written = write(Path::new(&job.folder), &files)?;
        if job.runs.iter().any(|run| run.chunk != job.chunk) {
            terminal::warn(
                "frames of one motion stay in one task; `--warm N` splits them, with results that are near the same",
            );
        }
        if self.warm.is_some() && job.runs.iter().all(|run| run.warm.is_none()) {
            terminal::warn("--warm is for frames of one motion, which no run has; it is left out");
        }
        let tasks = job.tasks().count();
        let mut text = format!(
            "{}, {} of at most {}; all poses take {} in {}\n",
            count(job.runs.len(), "run", "runs"),
            count(tasks, "task", "tasks"),
            count(job.chunk, "pose", "poses"),
            bytes(all.iter().map(bytes_of_poses).sum()),
            job.cache,
        );
        written.iter().for_each(|file| text += &format!("{}\n", file.display()));
        text += &match self.to {
            Engine::OpenJd => openjd::next(&job.folder),
            Engine::Slurm => slurm::next(&job.folder),
            Engine::Hq => hyperqueue::next(&job.folder),
            Engine::Shell => shell::next(&job.folder),
        };
        terminal::print(&text);
        Ok(Status::Done)
    }

    /// The job of all runs that were checked.
    fn job(&self, all: &[Prepared]) -> Result<Job> {
        let name = self.pipeline.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let beside = || self.pipeline.with_file_name(format!("{name}-job"));
        let folder = absolute(&self.dir.clone().unwrap_or_else(beside))?;
        let cache = match &self.cache {
            Some(cache) => absolute(cache)?,
            None => format!("{folder}/cache"),
        };
        let program = match &self.program {
            Some(program) => program.clone(),
            None => absolute(&std::env::current_exe().map_err(|error| {
                Diagnostic::new(Kind::Internal, format!("the program does not know where it is: {error}"))
                    .hint("give it by --program")
            })?)?,
        };
        let run = |prepared: &Prepared| {
            let poses = prepared.poses.len();
            // Frames of one motion depend on those before.
            let is_motion = prepared.pipeline.transfer.as_ref().is_some_and(|transfer| transfer.gives_motion());
            let chunk = if is_motion && self.warm.is_none() { poses.max(1) } else { self.chunk };
            RunOfJob { name: prepared.variant.name.clone(), poses, chunk, warm: self.warm.filter(|_| is_motion) }
        };
        Ok(Job {
            name,
            program,
            pipeline: absolute(&self.pipeline)?,
            cache,
            options: self.options(all)?,
            runs: all.iter().map(run).collect(),
            chunk: self.chunk,
            folder,
        })
    }

    /// The options of every command of the job.
    fn options(&self, all: &[Prepared]) -> Result<Vec<String>> {
        let mut options = self.overrides.absolute_arguments()?;
        let limit = self.cache_limit(all)?;
        if self.cache_limit.is_some() || limit > DEFAULT_MEGABYTES {
            options.extend(["--cache-limit".into(), limit.to_string()]);
        }
        if let Some(threads) = self.threads {
            options.extend(["--threads".into(), threads.to_string()]);
        }
        if self.allow_commands {
            options.push("--allow-commands".into());
        }
        Ok(options)
    }

    /// The limit of the cache in megabytes, within which the poses of all runs stay until they are merged.
    fn cache_limit(&self, all: &[Prepared]) -> Result<u64> {
        let needed = megabytes_of_poses(all);
        match self.cache_limit {
            Some(limit) if limit < needed => {
                let message =
                    format!("--cache-limit {limit}: the poses of all runs need {needed} until they are merged");
                Err(Diagnostic::new(Kind::Usage, message)
                    .hint("leave it out, or take some of the runs by `--run NAME`")
                    .into())
            }
            limit => Ok(limit.unwrap_or(needed)),
        }
    }
}

/// The limit of the cache that commands have by themselves.
const DEFAULT_MEGABYTES: u64 = DEFAULT_LIMIT >> 20;

/// Writes `files` into `folder`, none of which may be there.
fn write(folder: &Path, files: &[JobFile]) -> Result<Vec<PathBuf>> {
    let places: Vec<PathBuf> = files.iter().map(|file| folder.join(file.name)).collect();
    if let Some(there) = places.iter().find(|place| place.symlink_metadata().is_ok()) {
        let diagnostic = Diagnostic::new(Kind::CannotWrite, "exists already").at(Location::File(there.clone()));
        return Err(diagnostic
            .hint("nothing is overwritten; choose another folder by --dir, or remove the job")
            .into());
    }
    let contents: Vec<(&Path, &[u8])> =
        places.iter().zip(files).map(|(place, file)| (place.as_path(), file.text.as_bytes())).collect();
    let written = write_all(&contents)?;
    for (place, _) in places.iter().zip(files).filter(|(_, file)| file.is_script) {
        make_executable(place);
    }
    Ok(written)
}

/// Lets a script be run by its name; where that cannot be, `bash` runs it all the same.
fn make_executable(script: &Path) {
    #[cfg(unix)]
    if let Ok(metadata) = fs::metadata(script) {
        use std::os::unix::fs::PermissionsExt;
        let mut permissions = metadata.permissions();
        permissions.set_mode(permissions.mode() | 0o111);
        let _ = fs::set_permissions(script, permissions);
    }
    #[cfg(not(unix))]
    let _ = (script, fs::metadata::<&Path>);
}

/// Parses a number of poses.
fn chunk(text: &str) -> std::result::Result<usize, String> {
    text.parse().ok().filter(|count| *count > 0).ok_or_else(|| "expected a whole number from 1".into())
}
