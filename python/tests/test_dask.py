"""Pipelines on Dask: the bytes of a whole run, also when a worker is killed."""

from __future__ import annotations

import os
import signal
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

import mimesh
import mimesh.dask

distributed = pytest.importorskip("distributed", reason="the extra `test` is not installed")

PIPELINE = """
source: { generator: { type: quadruped, proportions: horse, gait: gallop, resolution: 20, frames: 24 } }
targets:
  camel: { generator: { type: quadruped, proportions: camel, resolution: 20 } }
  odd name: { generator: { type: quadruped, proportions: camel, resolution: 22, seed: 3 } }
correspondence: { type: nonrigid_fit }
transfer: { type: gradient }
output: ["out/{target}/all.glb", "out/{target}/{pose}.obj"]
"""


@pytest.fixture(scope="module")
def client() -> Iterator[object]:
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None) as cluster:
        with distributed.Client(cluster) as client:
            yield client


def results(folder: Path) -> dict[str, bytes]:
    files = (file for file in folder.rglob("*") if file.is_file() and file.name != "run.json")
    return {str(file.relative_to(folder)): file.read_bytes() for file in files}


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, bytes]]:
    folder = tmp_path_factory.mktemp("whole")
    file = folder / "herd.yaml"
    file.write_text(PIPELINE)
    mimesh.Pipeline.from_file(file).run(out=folder / "whole")
    return file, results(folder / "whole")


def test_tasks_give_the_bytes_of_a_whole_run(client: object, whole: tuple[Path, dict[str, bytes]], tmp_path: Path) -> None:
    file, expected = whole
    assert len(expected) == 2 * 25
    reports = mimesh.dask.run(client, file, cache=tmp_path / "cache", chunk=7, out=tmp_path / "out")
    assert results(tmp_path / "out") == expected
    assert list(reports) == ["camel", "odd name"] and all(report["status"] == "done" for report in reports.values())


def test_a_killed_worker_loses_nothing(client: object, whole: tuple[Path, dict[str, bytes]], tmp_path: Path) -> None:
    file, expected = whole
    workers = {worker["pid"] for worker in client.run(lambda: {"pid": os.getpid()}).values()}  # type: ignore[attr-defined]
    killed = []

    def kill() -> None:
        # When the first poses are there, the others are on their way.
        while not list((tmp_path / "out").rglob("*.obj")):
            time.sleep(0.01)
        killed.append(min(workers))
        os.kill(killed[0], signal.SIGKILL)

    killer = threading.Thread(target=kill, daemon=True)
    killer.start()
    mimesh.dask.run(client, file, cache=tmp_path / "cache", chunk=3, out=tmp_path / "out")
    killer.join(timeout=1)
    assert killed, "no worker was killed"
    assert results(tmp_path / "out") == expected


def test_what_is_wrong_is_raised_as_everywhere(client: object, tmp_path: Path) -> None:
    with pytest.raises(mimesh.MissingInputError, match="none.yaml"):
        mimesh.dask.run(client, tmp_path / "none.yaml", cache=tmp_path / "cache")
    (tmp_path / "p.yaml").write_text(PIPELINE.replace("gradient", "gradients"))
    with pytest.raises(mimesh.BadPipelineError, match="gradient"):
        mimesh.dask.run(client, tmp_path / "p.yaml", cache=tmp_path / "cache")
    with pytest.raises(mimesh.UsageError, match="chunk"):
        mimesh.dask.run(client, tmp_path / "p.yaml", cache=tmp_path / "cache", chunk=0)
