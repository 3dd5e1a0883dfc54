//! A shell script with all tasks of a job: a loop for one machine, and the tasks for engines that number them.

use super::{
    files::JobFile,
    job::{Job, RunOfJob},
};
use crate::cli::help_commands::in_quotes as quoted;

/// The name of the script.
pub const SCRIPT: &str = "job.sh";

/// The script, alone enough to run the job.
pub fn files(job: &Job) -> Vec<JobFile> {
    vec![JobFile::script(SCRIPT, script(job))]
}

/// How to go on.
pub fn next(folder: &str) -> String {
    format!("run it all, two tasks at a time: {}\n", quoted(&format!("{folder}/{SCRIPT}")) + " all 2")
}

/// The script, whose tasks are numbered from 0.
pub fn script(job: &Job) -> String {
    let list = |words: &mut dyn Iterator<Item = String>| words.map(|word| format!("    {word}\n")).collect::<String>();
    let names = list(&mut job.runs.iter().map(|run| quoted(&run.name)));
    let poses = list(&mut job.runs.iter().map(|run| run.poses.to_string()));
    let options = list(&mut job.options.iter().map(|option| quoted(option)));
    let chunks = list(&mut job.runs.iter().map(|run| run.chunk.to_string()));
    let warm = list(&mut job.runs.iter().map(|run| quoted(&run.warm.map(|n| n.to_string()).unwrap_or_default())));
    let tasks: usize = job.runs.iter().map(RunOfJob::tasks).sum();
    let Job { program, pipeline, cache, .. } = job;
    let (program, pipeline, cache) = (quoted(program), quoted(pipeline), quoted(cache));
    let runs = job.runs.len();
    format!(
        r#"#!/usr/bin/env bash
# The tasks of a pipeline, written by `mimesh submit`: {runs} runs, {tasks} tasks of poses.
#
#   job.sh prepare RUN          stages that run once, for the run with this number from 0
#   job.sh transfer TASK        the poses of this task, from 0
#   job.sh merge RUN            the results of a run, when its tasks are done
#   job.sh all [PROCESSES]      everything, so many tasks at a time; done tasks are not computed again
#   job.sh count                the number of runs and of tasks
#
# MIMESH and MIMESH_CACHE replace the program and the folder of the cache.
set -euo pipefail

mimesh=${{MIMESH:-{program}}}
cache=${{MIMESH_CACHE:-{cache}}}
pipeline={pipeline}
runs=(
{names})
poses=(
{poses})
# The most poses of a task, and frames that its parts begin earlier, for each run.
chunks=(
{chunks})
warm=(
{warm})
options=(
{options})

# Runs a command of mimesh. Status 75 says that another process has what it needs, so it waits and tries again.
attempt() {{
    local wait status
    for wait in 1 2 5 10 20 40 80 160 0; do
        status=0
        "$mimesh" "$@" --cache "$cache" --quiet "${{options[@]}}" || status=$?
        [ "$status" = 75 ] && [ "$wait" != 0 ] || return "$status"
        sleep "$wait"
    done
}}

# The options that choose a run.
choose() {{
    chosen=()
    if [ -n "${{runs[$1]}}" ]; then chosen=("--run=${{runs[$1]}}"); fi
    warmed=()
    if [ -n "${{warm[$1]}}" ]; then warmed=(--warm "${{warm[$1]}}"); fi
}}

transfer() {{
    local task=$1 run chunk count first last
    for run in "${{!poses[@]}}"; do
        chunk=${{chunks[run]}}
        count=$(((poses[run] + chunk - 1) / chunk))
        if ((task < count)); then
            first=$((task * chunk))
            last=$((first + chunk - 1))
            if ((last >= poses[run])); then last=$((poses[run] - 1)); fi
            choose "$run"
            attempt run "$pipeline" "${{chosen[@]}}" --frames "$first-$last" "${{warmed[@]}}"
            return
        fi
        task=$((task - count))
    done
    echo "job.sh: there is no task $1" >&2
    return 2
}}

numbers() {{
    if (($1 > 0)); then seq 0 $(($1 - 1)); fi
}}

tasks={tasks}
case ${{1:-}} in
    prepare)
        choose "$2"
        attempt prepare "$pipeline" "${{chosen[@]}}"
        ;;
    transfer) transfer "$2" ;;
    merge)
        choose "$2"
        attempt merge "$pipeline" "${{chosen[@]}}" "${{warmed[@]}}"
        ;;
    all)
        processes=${{2:-1}}
        # A task that fails does not stop the others; merge says what is missing.
        numbers "${{#runs[@]}}" | xargs -r -n 1 -P "$processes" bash "$0" prepare || true
        numbers "$tasks" | xargs -r -n 1 -P "$processes" bash "$0" transfer || true
        numbers "${{#runs[@]}}" | xargs -r -n 1 bash "$0" merge
        ;;
    count) echo "${{#runs[@]}} $tasks" ;;
    *)
        echo "job.sh: expected prepare RUN, transfer TASK, merge RUN, all [PROCESSES] or count" >&2
        exit 2
        ;;
esac
"#
    )
}
