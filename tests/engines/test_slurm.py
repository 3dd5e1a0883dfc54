"""Arrays of Slurm, whose `sbatch` is a program of these tests."""

import os
import subprocess
from pathlib import Path

from conftest import CHUNK, Project

# Runs the elements of an array in another order, two at a time, from a copy of the script as Slurm does, and gives a number of a job.
SBATCH = r"""#!/usr/bin/env bash
set -eu
script=${@: -1}
copy=$(mktemp)
cp "$script" "$copy"
range=$(sed -n 's/^#SBATCH --array=//p' "$script")
seq "${range%-*}" "${range#*-}" | sort -R --random-source=/dev/zero |
    xargs -P 2 -I ELEMENT env SLURM_ARRAY_TASK_ID=ELEMENT bash "$copy" || true
echo "$*" >> "$SBATCH_LOG"
echo "$(wc -l < "$SBATCH_LOG");cluster"
"""


def test_arrays_give_the_bytes_of_a_whole_run(project: Project, expected: dict[str, bytes], tmp_path: Path) -> None:
    project.mimesh("submit", "--to", "slurm", "herd.yaml", "--chunk", str(CHUNK), "--threads", "1")
    job = project.folder / "herd-job"
    for script in sorted(job.glob("*.s*")):
        subprocess.run(["shellcheck", "--severity=style", "--shell=bash", script], check=True)
    sbatch = tmp_path / "bin/sbatch"
    sbatch.parent.mkdir()
    sbatch.write_text(SBATCH)
    sbatch.chmod(0o755)
    log = tmp_path / "log"
    log.touch()
    environment = {**os.environ, "PATH": f"{sbatch.parent}:{os.environ['PATH']}", "SBATCH_LOG": str(log)}
    subprocess.run([job / "submit.sh", "--partition=short"], env=environment, check=True, cwd=tmp_path)
    asked = log.read_text().splitlines()
    assert asked == [
        "--parsable --partition=short prepare.slurm",
        "--parsable --dependency=afterok:1 --partition=short transfer.slurm",
        "--parsable --dependency=afterany:2 --partition=short merge.slurm",
    ]
    assert project.results() == expected
    project.nothing_ran()
