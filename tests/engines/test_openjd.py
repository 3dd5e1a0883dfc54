"""Open Job Description, run by `openjd`."""

import json
import re
import subprocess
import sys
from pathlib import Path

from conftest import CHUNK, FRAMES, MIMESH, TARGETS, Project

OPENJD = str(Path(sys.executable).with_name("openjd"))


def openjd(project: Project, *words: str, succeeds: bool = True) -> str:
    done = subprocess.run([OPENJD, *words], cwd=project.folder, capture_output=True, text=True)
    assert (done.returncode == 0) == succeeds, f"{words}: {done.returncode}\n{done.stdout}\n{done.stderr}"
    return done.stdout + done.stderr


def submitted(project: Project) -> str:
    project.mimesh("submit", "--to", "openjd", "herd.yaml", "--chunk", str(CHUNK), "--threads", "1")
    return "herd-job/template.json"


def test_the_job_gives_the_bytes_of_a_whole_run(project: Project, expected: dict[str, bytes]) -> None:
    template = submitted(project)
    openjd(project, "check", template)
    said = openjd(project, "run", template)
    assert project.results() == expected
    assert re.search(r"Progress: 100|openjd_progress: 100", said), said[-3000:]
    assert "status" in said.lower()
    project.nothing_ran()


def test_a_part_that_failed_is_run_again_alone(project: Project, expected: dict[str, bytes], tmp_path: Path) -> None:
    template = submitted(project)
    # The part with frame 5 fails once.
    broken = tmp_path / "mimesh"
    broken.write_text(f'#!/bin/sh\ncase "$*" in *"--frames 5-9"*) exit 1 ;; esac\nexec "{MIMESH}" "$@"\n')
    broken.chmod(0o755)
    openjd(project, "run", template, "--step", "Prepare")
    failed = openjd(project, "run", template, "--step", "Transfer", "-p", f"Mimesh={broken}", succeeds=False)
    assert "5-9" in failed
    project.mimesh("merge", "herd.yaml", "--cache", "herd-job/cache", status=75)
    chunks = [f"{first}-{min(first + CHUNK, FRAMES) - 1}" for first in range(0, FRAMES, CHUNK)]
    again = json.dumps([{"Run": name, "Frame": chunk} for name in TARGETS for chunk in chunks])
    openjd(project, "run", template, "--step", "Transfer", "--tasks", again)
    openjd(project, "run", template, "--step", "Merge")
    assert project.results() == expected
