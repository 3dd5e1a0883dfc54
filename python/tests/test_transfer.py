"""Transfers between meshes of memory and files."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import mimesh
from conftest import rotation


def height(mesh: mimesh.Mesh) -> float:
    return float(np.linalg.norm(np.ptp(mesh.vertices, axis=0)))


def test_a_mesh_that_takes_its_own_poses_takes_them_exactly(horse) -> None:
    result = mimesh.transfer(horse, horse.with_vertices(horse.vertices))
    assert result.poses == horse.poses
    assert result.positions.shape == (len(horse.poses), len(horse.vertices), 3)
    for i in range(len(horse.poses)):
        error = np.linalg.norm(result.positions[i] - horse.pose(i), axis=1)
        # Equal topology is paired by `identity`; what is left is the solver's tolerance.
        assert error.max() < 1e-6 * height(horse)


def test_a_turned_target_takes_the_turned_poses(horse) -> None:
    turn, shift = rotation(), np.array([3.0, -2.0, 5.0])
    turned = horse.with_vertices(2.0 * horse.vertices @ turn.T + shift)
    result = mimesh.transfer(horse, turned, correspondence="identity", transfer=mimesh.transfers.Gradient())
    for i in range(len(horse.poses)):
        expected = 2.0 * horse.pose(i) @ turn.T + shift
        moved = result.positions[i] - result.positions[i].mean(axis=0)
        error = np.linalg.norm(moved - (expected - expected.mean(axis=0)), axis=1)
        assert error.max() < 1e-3 * height(turned)


def test_no_clicks_are_needed(horse, camel, tmp_path) -> None:
    result = mimesh.transfer(horse, camel)
    truth = np.array([camel.pose(i) for i in range(len(camel.poses))])
    error = np.linalg.norm(result.positions - truth, axis=2).mean()
    still = np.linalg.norm(truth - camel.vertices, axis=2).mean()
    # The animals have named points; by these the camel takes the gallop.
    assert error < 0.2 * still
    assert result.report["choices"] and result.verdict in ("good", "doubtful", "bad")
    assert result.failed == []
    written = result.save(tmp_path / "camel.glb")
    read = mimesh.load(written[0])
    assert read.poses == result.poses
    np.testing.assert_allclose(read.pose(1), result.positions[1], atol=1e-5 * height(camel))


def test_every_kind_of_mesh_gives_the_same(horse, camel, tmp_path) -> None:
    trimesh, meshio = pytest.importorskip("trimesh"), pytest.importorskip("meshio")
    poses = {name: horse.pose(name) for name in horse.poses}
    source = mimesh.Mesh(horse.vertices, horse.faces)
    target = mimesh.Mesh(camel.vertices, camel.faces)
    settings = {"correspondence": "nearest", "transfer": "copy_displacement", "metrics": []}
    expected = mimesh.transfer(source, target, poses=poses, **settings)
    kinds = {
        "pair": ((source.vertices, source.faces), (target.vertices, target.faces)),
        "trimesh": (mimesh.to_trimesh(source), mimesh.to_trimesh(target)),
        "meshio": (mimesh.to_meshio(source), mimesh.to_meshio(target)),
    }
    assert isinstance(kinds["trimesh"][0], trimesh.Trimesh) and isinstance(kinds["meshio"][0], meshio.Mesh)
    for kind, (one, other) in kinds.items():
        result = mimesh.transfer(one, other, poses=poses, **settings)
        np.testing.assert_array_equal(result.positions, expected.positions, err_msg=kind)
        assert result.poses == expected.poses
    one, other = tmp_path / "source.obj", tmp_path / "target.obj"
    source.save(one), target.save(other)
    for name, positions in poses.items():
        source.with_vertices(positions).save(tmp_path / f"pose-{name}.obj")
    by_files = mimesh.transfer(one, other, poses=str(tmp_path / "pose-*.obj"), **settings)
    files = {name: mimesh.load(tmp_path / f"pose-{name}.obj") for name in poses}
    by_memory = mimesh.transfer(mimesh.load(one), mimesh.load(other), poses=files, **settings)
    np.testing.assert_array_equal(by_files.positions, by_memory.positions)


def test_an_array_of_poses_and_markers_of_vertices(horse, camel) -> None:
    poses = np.stack([horse.pose(i) for i in range(2)])
    same = camel.with_vertices(camel.vertices)
    markers = [(int(i), int(np.argmin(np.linalg.norm(camel.vertices - horse.vertices[i], axis=1)))) for i in (5, 80, 200, 350)]
    result = mimesh.transfer(horse, same, poses=poses, markers=markers, correspondence="nearest", transfer="copy_displacement")
    assert result.poses == ("pose-01", "pose-02")
    assert result.report["markers"] == 4
    with pytest.raises(mimesh.UsageError, match="pairs of vertices"):
        mimesh.transfer(horse, same, markers=[1, 2, 3])


def test_results_do_not_depend_on_threads_or_the_cache(horse, camel, tmp_path) -> None:
    first = mimesh.transfer(horse, camel, threads=1, cache=tmp_path)
    second = mimesh.transfer(horse, camel, threads=2, cache=tmp_path)
    np.testing.assert_array_equal(first.positions, second.positions)
    assert any(stage.get("reused") for stage in second.report["stages"])


def test_progress_is_told_on_the_calling_thread(horse, camel) -> None:
    told: list[mimesh.Progress] = []
    threads = set()

    def listen(progress: mimesh.Progress) -> None:
        told.append(progress)
        threads.add(threading.get_ident())

    mimesh.transfer(horse, camel, progress=listen)
    assert threads == {threading.get_ident()}
    assert told[-1].poses_done == told[-1].pose_count == len(horse.poses)
    assert any(progress.stage.startswith("correspondence") for progress in told)

    def refuse(progress: mimesh.Progress) -> None:
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        mimesh.transfer(horse, camel, progress=refuse)


def test_other_threads_run_meanwhile(horse, camel) -> None:
    ticks = []
    done = threading.Event()

    def tick() -> None:
        while not done.wait(0.002):
            ticks.append(time.perf_counter())

    thread = threading.Thread(target=tick)
    thread.start()
    started = time.perf_counter()
    mimesh.transfer(horse, camel)
    seconds = time.perf_counter() - started
    done.set()
    thread.join()
    # A machine under load gives few turns, but never none for long.
    assert len(ticks) > 20 * seconds


def test_an_interrupt_ends_the_call_and_leaves_no_file(tmp_path) -> None:
    horse = mimesh.generators.Quadruped(proportions="horse", gait="gallop", frames=24, resolution=120).generate()
    camel = mimesh.generators.Quadruped(proportions="camel", gait="gallop", frames=2, resolution=120, seed=1).generate()
    pipeline = mimesh.Pipeline.from_dict(
        {"source": {"rest": horse}, "target": {"rest": camel}, "output": [str(tmp_path / "out" / "{pose}.obj")]}
    )
    began = threading.Event()
    sent = []

    def interrupt() -> None:
        began.wait(60)
        time.sleep(0.3)
        sent.append(time.perf_counter())
        os.kill(os.getpid(), signal.SIGINT)

    thread = threading.Thread(target=interrupt)
    thread.start()
    with pytest.raises(KeyboardInterrupt):
        pipeline.run(progress=lambda progress: began.set())
    waited = time.perf_counter() - sent[0]
    thread.join()
    assert waited < 2.0
    time.sleep(0.5)
    assert [path for path in tmp_path.rglob("*.obj") if not path.name.startswith(".mimesh-")] == []


INTERRUPTED = """
import os, signal, sys, threading, time
import mimesh
horse = mimesh.generators.Quadruped(proportions="horse", gait="gallop", frames=24, resolution=120).generate()
camel = mimesh.generators.Quadruped(proportions="camel", gait="gallop", frames=2, resolution=120, seed=1).generate()
pipeline = mimesh.Pipeline.from_dict({"source": {"rest": horse}, "target": {"rest": camel}, "output": [sys.argv[1]]})
def listen(progress):
    if not began.is_set() and progress.stage.startswith(sys.argv[2]):
        began.set()
        threading.Timer(0.2, os.kill, (os.getpid(), signal.SIGINT)).start()
began = threading.Event()
pipeline.run(progress=listen)
"""


@pytest.mark.parametrize("stage", ["correspondence", "poses"])
def test_a_script_that_is_interrupted_leaves_nothing(tmp_path, stage) -> None:
    command = [sys.executable, "-c", INTERRUPTED, str(tmp_path / "{pose}.obj"), stage]
    ended = subprocess.run(command, capture_output=True, text=True, timeout=120)
    assert "KeyboardInterrupt" in ended.stderr and ended.returncode != 0
    assert [path.name for path in tmp_path.rglob("*")] == []


def test_what_is_refused_says_what_to_do(horse, camel, tmp_path) -> None:
    still = mimesh.Mesh(horse.vertices, horse.faces)
    with pytest.raises(mimesh.Error, match="no poses") as refused:
        mimesh.transfer(still, camel)
    assert "`poses=…`" in (refused.value.diagnostics[0].hint or "")
    with pytest.raises(mimesh.MissingInputError):
        mimesh.transfer(tmp_path / "none.glb", camel)
    with pytest.raises(mimesh.BadPipelineError, match="unknown key `transfr`") as unknown:
        mimesh.transfer(horse, camel, transfr="gradient")
    assert "transfer" in (unknown.value.diagnostics[0].hint or "")
    with pytest.raises(mimesh.UsageError, match="threads"):
        mimesh.transfer(horse, camel, threads=0)
    with pytest.raises(mimesh.UsageError, match="expected a mesh, found int"):
        mimesh.transfer(horse, 7)
    with pytest.raises(mimesh.BadDataError, match="vertices"):
        horse.with_poses([camel.vertices])
