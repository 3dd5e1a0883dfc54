"""HyperQueue, by the server and the workers of its package for Python."""

import os
import signal
import subprocess
import sys
import time
import tomllib
from pathlib import Path

import psutil
from conftest import CHUNK, SET, Project

# A server that runs a job file to its end; its folder and the file are arguments.
SERVER = """
import sys, tomllib
from hyperqueue.cluster import LocalCluster
from hyperqueue.job import Job

file = tomllib.load(open(sys.argv[2], "rb"))
with LocalCluster(sys.argv[1]) as cluster:
    job, tasks = Job(name=file["name"], max_fails=None), {}
    for task in file["task"]:
        before = [tasks[number] for number in task.get("deps", [])]
        tasks[task["id"]] = job.program(task["command"], cwd=task["cwd"], deps=before, stdout=None, stderr=None)
    client = cluster.client()
    sys.exit(0 if client.wait_for_jobs([client.submit(job)], raise_on_error=False) else 1)
"""

# A worker of one core; its own folder and that of the server are arguments. The package starts workers as threads beside a server.
# So this starts a server that gets no jobs, and leads the worker to the other one, as `hq worker start --server-dir` does.
WORKER = """
import sys, threading
from pathlib import Path
from hyperqueue.cluster import LocalCluster, WorkerConfig

cluster = LocalCluster(sys.argv[1])
current = Path(sys.argv[1], "hq-current")
current.unlink()
current.symlink_to(Path(sys.argv[2], "hq-current"))
cluster.start_worker(WorkerConfig(cores=1))
threading.Event().wait()
"""

Process = subprocess.Popen[bytes]


class Cluster:
    """A server with a job and two workers, each a process of its own."""

    def __init__(self, file: Path, folder: Path) -> None:
        self.server = self._start(SERVER, folder / "server", file)
        end = time.monotonic() + 30
        while not (folder / "server/hq-current/access.json").exists():
            assert time.monotonic() < end, "the server did not start"
            time.sleep(0.05)
        self.workers = [self._start(WORKER, folder / name, folder / "server") for name in ("one", "two")]

    @staticmethod
    def _start(script: str, own: Path, other: Path) -> Process:
        own.mkdir(parents=True)
        command = [sys.executable, "-c", script, own, other]
        return subprocess.Popen(command, start_new_session=True, stdout=subprocess.DEVNULL)

    def busy_worker(self, options: set[str]) -> tuple[Process, psutil.Process]:
        """A worker with its task, once it has one whose command has one of these options."""
        end = time.monotonic() + 120
        while time.monotonic() < end:
            for worker in self.workers:
                for task in psutil.Process(worker.pid).children(recursive=True):
                    try:
                        if options & set(task.cmdline()):
                            return worker, task
                    except psutil.NoSuchProcess:
                        continue
            time.sleep(0.002)
        raise AssertionError("no worker was seen at work")

    def end(self) -> int:
        """Waits for the job; 0 if all its tasks went well."""
        status = self.server.wait(timeout=300)
        self.kill()
        return status

    def kill(self) -> None:
        """Ends all that still runs."""
        for process in (self.server, *self.workers):
            kill(process)


def kill(process: Process) -> None:
    try:
        os.killpg(process.pid, signal.SIGKILL)
    except ProcessLookupError:
        pass
    process.wait()


def submitted(project: Project) -> Path:
    project.mimesh("submit", "--to", "hq", "herd.yaml", "--chunk", str(CHUNK), "--threads", "1", *SET)
    return project.folder / "herd-job/job.toml"


def test_the_job_gives_the_bytes_of_a_whole_run(project: Project, expected: dict[str, bytes], tmp_path: Path) -> None:
    assert Cluster(submitted(project), tmp_path).end() == 0
    assert project.results() == expected
    project.nothing_ran()


def test_of_two_workers_one_killed_at_work_loses_nothing(
    project: Project, expected: dict[str, bytes], tmp_path: Path
) -> None:
    cluster = Cluster(submitted(project), tmp_path)
    worker, _ = cluster.busy_worker({"--frames"})
    kill(worker)
    assert cluster.end() == 0, "the other worker finishes the job"
    assert project.results() == expected


def test_a_killed_task_and_then_a_killed_cluster_lose_nothing(
    project: Project, expected: dict[str, bytes], tmp_path: Path
) -> None:
    file = submitted(project)
    first = Cluster(file, tmp_path / "first")
    _, task = first.busy_worker({"--frames"})
    task.kill()
    assert first.end() == 1, "the job goes on although a task was killed"
    assert project.results() != expected
    second = Cluster(file, tmp_path / "second")
    second.busy_worker({"--frames"})
    second.kill()
    assert Cluster(file, tmp_path / "third").end() == 0
    assert project.results() == expected
