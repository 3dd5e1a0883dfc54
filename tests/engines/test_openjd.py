"""Open Job Description, run by `openjd`."""

import json
import re
import subprocess
import sys
from pathlib import Path

from conftest import CHUNK, FRAMES, MIMESH, SET, TARGETS, Project

OPENJD = str(Path(sys.executable).with_name("openjd"))


def openjd(project: Project, *words: str, succeeds: bool = True) -> str:
    done = subprocess.run([OPENJD, *words], cwd=project.folder, capture_output=True, text=True)
    assert (done.returncode == 0) == succeeds, f"{words}: {done.returncode}\n{done.stdout}\n{done.stderr}"
    return done.stdout + done.stderr


def submitted(project: Project) -> list[str]:
    """Submits the job; the arguments of `openjd run`."""
    project.mimesh("submit", "--to", "openjd", "herd.yaml", "--chunk", str(CHUNK), "--threads", "1", *SET)
    return ["herd-job/template.json", "-p", f"file://{project.folder}/herd-job/parameters.json"]


def test_the_job_gives_the_bytes_of_a_whole_run(project: Project, expected: dict[str, bytes]) -> None:
    job = submitted(project)
    openjd(project, "check", job[0])
    said = openjd(project, "run", *job)
    assert project.results() == expected
    assert re.search(r"Progress: 100|openjd_progress: 100", said), said[-3000:]
    assert "status" in said.lower()
    project.nothing_ran()


def test_a_part_that_failed_is_run_again_alone(project: Project, expected: dict[str, bytes], tmp_path: Path) -> None:
    job = submitted(project)
    chunks = [f"{first}-{min(first + CHUNK, FRAMES) - 1}" for first in range(0, FRAMES, CHUNK)]
    one, *others = [{"Run": name, "Frame": chunk} for chunk in chunks for name in TARGETS]
    openjd(project, "run", *job, "--step", "Prepare")
    openjd(project, "run", *job, "--step", "Transfer", "--tasks", json.dumps(others))
    # The one that is left fails.
    broken = tmp_path / "mimesh"
    broken.write_text(f'#!/bin/sh\ncase "$*" in *"--frames {one["Frame"]}"*) exit 1 ;; esac\nexec "{MIMESH}" "$@"\n')
    broken.chmod(0o755)
    alone = ["--step", "Transfer", "--tasks", json.dumps([one])]
    failed = openjd(project, "run", *job, *alone, "-p", f"Mimesh={broken}", succeeds=False)
    assert one["Frame"] in failed
    missing = project.mimesh("merge", "herd.yaml", "--cache", "herd-job/cache", *SET, status=75).stderr
    assert f"{CHUNK} of {FRAMES} poses not computed: {one['Frame']}" in missing
    openjd(project, "run", *job, *alone)
    openjd(project, "run", *job, "--step", "Merge")
    assert project.results() == expected
