"""Pipelines on a cluster of Dask: tasks of some frames each, which meet in a cache that all workers see.

>>> from distributed import Client                                        # doctest: +SKIP
>>> import mimesh.dask                                                     # doctest: +SKIP
>>> mimesh.dask.run(Client("tcp://scheduler:8786"), "herd.yaml", cache="/farm/cache")    # doctest: +SKIP

Each task is a process of its own, so that one that dies takes no worker with it. A task that is lost with its worker is run again
elsewhere, and poses that are done are not computed again. Results have the bytes of ``mimesh run``.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from collections.abc import Sequence
from typing import Any

from ._errors import _CLASSES, Error, misuse

_KINDS = {
    2: "usage",
    65: "bad_data",
    66: "missing_input",
    71: "memory",
    73: "cannot_write",
    75: "busy",
    78: "bad_pipeline",
}
"""Kinds of errors by the exit status of the command."""

_BUSY = 75
_LEFT_RESULTS = (0, 3, 4)
"""Done, a quality gate is broken, some poses failed: reports say which."""

_LEAST_LIMIT = 2048
"""The limit of the cache in megabytes where less would do."""

_PATIENCE = 300.0
"""For so many seconds a task tries again while another has what it needs."""


def run(
    client: Any,
    pipeline: str | os.PathLike[str],
    *,
    cache: str | os.PathLike[str],
    chunk: int = 100,
    runs: Sequence[str] = (),
    warm: int | None = None,
    threads: int = 1,
    set: Sequence[str] = (),
    out: str | os.PathLike[str] | None = None,
    roots: Sequence[str | os.PathLike[str]] = (),
    allow_commands: bool = False,
    python: Sequence[str | os.PathLike[str]] = (),
    retries: int = 2,
) -> dict[str, dict[str, Any]]:
    """Runs the pipeline in a file on the workers of ``client``; the reports of its runs by their names.

    Args:
        client: A ``distributed.Client``. Its workers need this package and see the same files under the same names.
        pipeline: The file of the pipeline.
        cache: The folder in which tasks meet.
        chunk: The most poses of a task.
        runs: The names of the runs that are meant, of those that targets and a matrix make; left out, all.
        warm: Begin each part of a motion so many frames earlier.
        threads: Threads of a task.
        set: Values that replace those of the pipeline.
        out: The folder for all results.
        roots: Folders whose files meshes may open.
        allow_commands: Whether stages may run programs that the pipeline names.
        python: Files with stages written in Python.
        retries: How often a task that fails is tried again.

    Raises:
        mimesh.Error: When all other tasks have ended, the first failure; a later call computes only what is missing.
    """
    import distributed

    wait: Any = distributed.wait
    if chunk < 1:
        raise misuse(f"chunk: expected at least 1, found {chunk}")
    file = os.path.abspath(pipeline)
    common = ["--cache", os.path.abspath(cache)]
    for value in set:
        common += ["--set", value]
    if out is not None:
        common += ["--out", os.path.abspath(out)]
    for root in roots:
        common += ["--root", os.path.abspath(root)]
    for stages in python:
        common += ["--python", os.path.abspath(stages)]
    warm_options = [] if warm is None else ["--warm", str(warm)]
    work = ["--threads", str(threads), *(["--allow-commands"] if allow_commands else [])]
    chosen = [f"--run={name}" for name in runs]
    plan = json.loads(_call(["plan", file, "--json", *common, *chosen]))
    plans = plan if isinstance(plan, list) else [{"run": "", "plan": plan}]
    # All poses stay in the cache until they are merged.
    limit = max(_LEAST_LIMIT, sum(one["plan"]["cache_limit"] for one in plans))
    common += ["--cache-limit", str(limit)]
    merges = {}
    for one in plans:
        name = one["run"]
        option = [f"--run={name}"] if name else []
        poses = next(step["of"] for step in one["plan"]["steps"] if step["stage"] == "poses")

        def task(words: list[str], after: list[Any], name: str = name) -> Any:
            label = f"mimesh {words[0]} {name}".strip()
            return client.submit(_task, words, after, pure=False, retries=retries, key=f"{label}-{os.urandom(8).hex()}")

        prepared = task(["prepare", file, *option, *common, *work, "--quiet"], [])
        parts = [
            task(
                ["run", file, *option, "--frames", f"{first}-{min(first + chunk, poses) - 1}", *warm_options, *common, *work, "--quiet"],
                [prepared],
            )
            for first in range(0, poses, chunk)
        ]
        merges[name] = task(["merge", file, *option, *warm_options, *common, *work, "--json"], parts)
    wait(list(merges.values()))
    failures = [future.exception() for future in merges.values() if future.status != "finished"]
    if failures:
        raise failures[0] or Error("a task was cancelled")
    return {name: json.loads(future.result()) for name, future in merges.items()}


def _task(words: list[str], after: list[Any]) -> str:
    """Runs the command; ``after`` is there to come first."""
    return _call(words)


def _call(words: list[str]) -> str:
    """What the command prints; it tries again while another process has what it needs."""
    end = time.monotonic() + _PATIENCE
    pause = 0.25
    while True:
        done = subprocess.run([sys.executable, "-m", "mimesh", *words], capture_output=True, text=True, stdin=subprocess.DEVNULL)
        # Poses that merge misses will not come by waiting.
        waits = done.returncode == _BUSY and words[0] != "merge"
        if not waits or time.monotonic() > end:
            break
        time.sleep(pause)
        pause = min(2 * pause, 10.0)
    if done.returncode in _LEFT_RESULTS:
        return done.stdout
    kind = _KINDS.get(done.returncode, "internal")
    told = done.stderr.strip() or f"mimesh {words[0]} ended with status {done.returncode}"
    raise _CLASSES[kind](told.removeprefix("error: "))
