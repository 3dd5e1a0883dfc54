"""Runs jobs as processes of their own, one at a time, and measures them alike on both sides."""

import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]

# A job that takes longer than this is run once.
LONG_SECONDS = 120.0


def target_folder():
    """Where cargo builds; everything that is made here lies below it."""
    return Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))


def build_program():
    """Builds the program that runs one stage, and gives its path."""
    command = ["cargo", "bench", "--no-run", "--locked", "--bench", "peers", "--message-format=json"]
    messages = subprocess.run(command, cwd=ROOT, stdout=subprocess.PIPE, check=True, text=True).stdout
    for line in messages.splitlines():
        message = json.loads(line)
        if message.get("reason") == "compiler-artifact" and message["target"]["name"] == "peers":
            return message["executable"]
    sys.exit("cargo built no program `peers`")


class Runner:
    """Runs jobs of ours with `program` and those of peers with this Python."""

    def __init__(self, program, threads, runs):
        self.program, self.runs = str(program), runs
        # Names by which OpenMP, BLAS, libigl and rayon are told.
        names = ["RAYON_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "IGL_NUM_THREADS"]
        self.environment = {**os.environ, **{name: str(threads) for name in names}}

    def ours(self, job, runs=None):
        """The medians of a job of ours."""
        return self._repeat([self.program], job, runs)

    def peer(self, job, runs=None):
        """The medians of a job of a peer."""
        return self._repeat([sys.executable, str(Path(__file__).with_name("peer_jobs.py"))], job, runs)

    def _repeat(self, command, job, runs):
        taken = []
        for _ in range(runs or self.runs):
            taken.append(self._once(command, job))
            if taken[-1]["process"]["wall"] > LONG_SECONDS:
                break
        return medians(taken)

    def _once(self, command, job):
        with tempfile.NamedTemporaryFile("w", suffix=".json") as file, tempfile.TemporaryFile("w+") as out:
            json.dump(job, file)
            file.flush()
            started = time.perf_counter()
            child = subprocess.Popen([*command, file.name], stdout=out, env=self.environment)
            _, status, usage = os.wait4(child.pid, 0)
            wall = time.perf_counter() - started
            # The child is gone, which `Popen` does not know.
            child.returncode = os.waitstatus_to_exitcode(status)
            if child.returncode != 0:
                raise SystemExit(f"{command[0]} failed with status {child.returncode} on {json.dumps(job)}")
            out.seek(0)
            report = json.loads(out.read().splitlines()[-1])
        report["process"] = {"cpu": usage.ru_utime + usage.ru_stime, "wall": wall, "peak": report["peak"] or 0}
        return report


def medians(reports):
    """One report with the median of each number; what a job says of its result is that of the last run."""
    phases = {
        name: {clock: statistics.median(r["phases"][name][clock] for r in reports) for clock in ("cpu", "wall")}
        for name in reports[-1]["phases"]
    }
    work = {clock: statistics.median(sum(p[clock] for p in r["phases"].values()) for r in reports) for clock in ("cpu", "wall")}
    # Memory that the work needs beyond what the process had before it: its program, libraries and input.
    work["memory"] = statistics.median(r["process"]["peak"] - (r["resident"] or 0) for r in reports)
    process = {name: statistics.median(r["process"][name] for r in reports) for name in ("cpu", "wall", "peak")}
    return {"phases": phases, "work": work, "process": process, "runs": len(reports), "about": reports[-1]["about"]}
