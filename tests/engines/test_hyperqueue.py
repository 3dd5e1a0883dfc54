"""HyperQueue, by the server and the workers of its package for Python."""

import os
import signal
import subprocess
import sys
import time
import tomllib
from pathlib import Path

from conftest import CHUNK, Project

# A cluster of two workers that runs a job file to its end; the folder of the server and the file are arguments.
CLUSTER = """
import sys, tomllib
from hyperqueue.cluster import LocalCluster, WorkerConfig
from hyperqueue.job import Job

file = tomllib.load(open(sys.argv[2], "rb"))
with LocalCluster(sys.argv[1], WorkerConfig(cores=1)) as cluster:
    cluster.start_worker(WorkerConfig(cores=1))
    job, tasks = Job(name=file["name"], max_fails=None), {}
    for task in file["task"]:
        before = [tasks[number] for number in task.get("deps", [])]
        tasks[task["id"]] = job.program(task["command"], cwd=task["cwd"], deps=before, stdout=None, stderr=None)
    client = cluster.client()
    sys.exit(0 if client.wait_for_jobs([client.submit(job)], raise_on_error=False) else 1)
"""


def submitted(project: Project) -> Path:
    project.mimesh("submit", "--to", "hq", "herd.yaml", "--chunk", str(CHUNK), "--threads", "1")
    return project.folder / "herd-job/job.toml"


def cluster(file: Path, folder: Path) -> "subprocess.Popen[bytes]":
    folder.mkdir(exist_ok=True)
    return subprocess.Popen([sys.executable, "-c", CLUSTER, folder, file], start_new_session=True, stdout=subprocess.DEVNULL)


def test_the_job_gives_the_bytes_of_a_whole_run(project: Project, expected: dict[str, bytes], tmp_path: Path) -> None:
    file = submitted(project)
    assert cluster(file, tmp_path / "server").wait(timeout=300) == 0
    assert project.results() == expected
    project.nothing_ran()


def test_a_killed_task_and_then_a_killed_cluster_lose_nothing(
    project: Project, expected: dict[str, bytes], tmp_path: Path
) -> None:
    file = submitted(project)
    transfers = [task["command"] for task in tomllib.loads(file.read_text())["task"] if "--frames" in task["command"]]
    first = cluster(file, tmp_path / "one")
    assert kill_a_task(transfers), "no task was seen at work"
    assert first.wait(timeout=300) == 1, "the job goes on although a task was killed"
    assert project.results() != expected
    # The cluster and all that it runs.
    second = cluster(file, tmp_path / "two")
    time.sleep(1.0)
    os.killpg(second.pid, signal.SIGKILL)
    second.wait()
    assert cluster(file, tmp_path / "three").wait(timeout=300) == 0
    assert project.results() == expected


def kill_a_task(commands: list[list[str]]) -> bool:
    """Kills one of these commands while it runs."""
    end = time.monotonic() + 60
    while time.monotonic() < end:
        for entry in Path("/proc").glob("[0-9]*"):
            try:
                words = (entry / "cmdline").read_bytes().decode(errors="replace").split("\0")[:-1]
                if words in commands:
                    os.kill(int(entry.name), signal.SIGKILL)
                    return True
            except OSError:
                continue
        time.sleep(0.005)
    return False
