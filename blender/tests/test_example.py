"""The script that needs no window: files in, .blend and .glb out."""

import subprocess
import sys
from pathlib import Path

import bpy
import numpy as np
import pytest
from conftest import evaluated

import mimesh

EXAMPLE = Path(__file__).resolve().parents[1] / "example.py"


def run(*arguments) -> subprocess.CompletedProcess:
    return subprocess.run([sys.executable, EXAMPLE, *map(str, arguments)], capture_output=True, text=True, timeout=900)


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    folder = tmp_path_factory.mktemp("animals")
    horse = mimesh.generators.Quadruped(proportions="horse", frames=4, resolution=20).generate()
    camel = mimesh.generators.Quadruped(proportions="camel", frames=4, resolution=24, seed=1).generate()
    horse.save(folder / "horse.glb")
    camel.with_vertices(camel.vertices).save(folder / "camel.obj")
    done = run(folder / "horse.glb", folder / "camel.obj", folder / "out.blend")
    assert done.returncode == 0, done.stdout + done.stderr
    assert "4 poses" in done.stdout
    return folder, camel


def test_the_blend_plays_about_the_known_result(files, registered):
    folder, camel = files
    bpy.ops.wm.open_mainfile(filepath=str(folder / "out.blend"))
    obj = bpy.data.objects["camel"]
    names = [key.name for key in obj.data.shape_keys.key_blocks][1:]
    assert names == list(camel.poses)
    scene = bpy.context.scene
    frames = range(scene.frame_start, scene.frame_end + 1)
    assert len(frames) > 1
    shown = {frame: evaluated(obj, frame) for frame in frames}
    still = np.linalg.norm(camel.pose(1) - camel.vertices, axis=1).mean()
    nearest = min(np.linalg.norm(positions - camel.pose(1), axis=1).mean() for positions in shown.values())
    # The clip passes through the second pose, whose truth the generator knows. No names of points help here.
    assert nearest < 0.4 * still


def test_the_glb_has_the_same_shapes(files, registered):
    folder, camel = files
    bpy.ops.wm.open_mainfile(filepath=str(folder / "out.blend"))
    blocks = bpy.data.objects["camel"].data.shape_keys.key_blocks
    written = mimesh.load(folder / "out.glb")
    assert written.poses == camel.poses
    rest = np.array([point.co for point in blocks[0].data])
    # glTF has its own vertices, so each is looked up by where it rests.
    nearest = np.array([np.linalg.norm(rest - vertex, axis=1).argmin() for vertex in written.vertices])
    np.testing.assert_allclose(written.vertices, rest[nearest], atol=1e-5)
    for name in written.poses:
        shape = np.array([point.co for point in blocks[name].data])
        np.testing.assert_allclose(written.pose(name), shape[nearest], atol=1e-5)


def test_wrong_files_are_named(tmp_path):
    (tmp_path / "source.txt").write_text("")
    done = run(tmp_path / "source.txt", tmp_path / "x.obj", tmp_path / "out.blend")
    assert done.returncode != 0 and "expected .glb, .gltf, .obj, .ply or .stl" in done.stderr
