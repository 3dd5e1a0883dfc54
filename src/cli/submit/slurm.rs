//! Slurm: arrays of tasks that depend on one another.

use super::{
    files::JobFile,
    job::Job,
    shell::{self, SCRIPT},
};
use crate::cli::help_commands::in_quotes as quoted;

/// The most elements of an array: what Slurm allows unless its administrator changed it, `MaxArraySize` 1001.
const MAX_ELEMENTS: usize = 1000;

/// What submits the arrays.
const SUBMIT: &str = "submit.sh";

/// The scripts of the job.
pub fn files(job: &Job) -> Vec<JobFile> {
    let tasks = job.tasks().count();
    let runs = job.runs.len();
    vec![
        JobFile::script(SCRIPT, shell::script(job)),
        JobFile::script("prepare.slurm", array(job, "prepare", runs)),
        JobFile::script("transfer.slurm", array(job, "transfer", tasks)),
        JobFile::script("merge.slurm", array(job, "merge", runs)),
        JobFile::script(SUBMIT, submit(job)),
    ]
}

/// How to go on.
pub fn next(folder: &str) -> String {
    format!("submit it: {}\n", quoted(&format!("{folder}/{SUBMIT}")))
}

/// The script of an array, of which each element has one task of `count`, or several that follow one another.
fn array(job: &Job, action: &str, count: usize) -> String {
    let each = count.div_ceil(MAX_ELEMENTS).max(1);
    let last = count.div_ceil(each).max(1) - 1;
    let end = count.max(1) - 1;
    let folder = quoted(&job.folder);
    format!(
        r#"#!/usr/bin/env bash
#SBATCH --job-name=mimesh-{action}
#SBATCH --array=0-{last}
#SBATCH --output=/dev/null
#SBATCH --requeue
# Element I has the tasks from {each} * I on, {each} of them. Add what your cluster asks for, such as --partition and --time, to submit.sh.
set -uo pipefail
cd {folder} || exit
mkdir -p logs
exec > "logs/{action}-$SLURM_ARRAY_TASK_ID.log" 2>&1
status=0
first=$((SLURM_ARRAY_TASK_ID * {each}))
for ((task = first; task < first + {each} && task <= {end}; task++)); do
    bash ./{SCRIPT} {action} "$task" || status=$?
done
exit "$status"
"#
    )
}

fn submit(job: &Job) -> String {
    let folder = quoted(&job.folder);
    format!(
        r#"#!/usr/bin/env bash
# Submits the arrays; options of sbatch may follow, such as --partition=short --cpus-per-task=4 --mem=8G --time=1:00:00.
set -euo pipefail
cd {folder}
prepare=$(sbatch --parsable "$@" prepare.slurm)
# Results of poses that are done are kept, whatever else failed: merge says what is missing.
transfer=$(sbatch --parsable --dependency="afterok:${{prepare%%;*}}" "$@" transfer.slurm)
merge=$(sbatch --parsable --dependency="afterany:${{transfer%%;*}}" "$@" merge.slurm)
echo "prepare ${{prepare%%;*}}, transfer ${{transfer%%;*}}, merge ${{merge%%;*}}; logs are in logs/"
"#
    )
}
