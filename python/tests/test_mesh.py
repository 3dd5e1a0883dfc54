"""Meshes in and out of NumPy and files."""

from __future__ import annotations

import gc

import numpy as np
import pytest

import mimesh
from conftest import make_grid


def address(array: np.ndarray) -> int:
    return array.__array_interface__["data"][0]


def test_vertices_are_the_memory_of_the_mesh_and_cannot_be_written() -> None:
    mesh = make_grid(1000)
    assert mesh.vertices.shape == (1_000_000, 3)
    inside = mesh._data.vertices().__array_interface__["data"][0]
    assert address(mesh.vertices) == inside == address(mesh.vertices)
    assert mesh.vertices.flags.c_contiguous and not mesh.vertices.flags.writeable
    with pytest.raises(ValueError):
        mesh.vertices[0, 0] = 1.0
    faces = mesh.faces
    assert address(faces) == mesh._data.corners().__array_interface__["data"][0]


def test_an_array_outlives_its_mesh() -> None:
    mesh = make_grid(50)
    expected = np.array(mesh.vertices)
    vertices, pose = mesh.vertices, mesh.with_poses([expected + 1]).pose(0)
    del mesh
    gc.collect()
    _ = [np.ones(7500) for _ in range(20)]
    np.testing.assert_array_equal(vertices, expected)
    np.testing.assert_array_equal(pose, expected + 1)


def test_any_numbers_go_in_and_come_back() -> None:
    vertices = np.arange(12, dtype=np.float32).reshape(4, 3)[:, ::-1]
    mesh = mimesh.Mesh(vertices, [[0, 1, 2, 3]])
    np.testing.assert_array_equal(mesh.vertices, vertices)
    assert [polygon.tolist() for polygon in mesh.polygons] == [[0, 1, 2, 3]]
    assert mesh.faces.tolist() == [[0, 1, 2], [0, 2, 3]]
    mixed = mimesh.Mesh(vertices.tolist(), [[0, 1, 2], (0, 2, 3, 1)])
    assert [len(polygon) for polygon in mixed.polygons] == [3, 4]
    assert repr(mixed) == "<mimesh.Mesh: 4 vertices, 2 polygons>"


@pytest.mark.parametrize(
    ("vertices", "faces", "words"),
    [
        (np.zeros((3, 2)), [[0, 1, 2]], "n × 3"),
        (np.zeros((3, 3)), [[0, 1, 3]], "vertex 3"),
        (np.zeros((3, 3)), [[0, 1, -1]], "-1"),
        (np.zeros((3, 3)), np.zeros(3, dtype=int), "list of polygons"),
        (np.zeros((3, 3)), [[0.0, 1.0, 2.0]], "whole numbers"),
        (np.full((3, 3), np.nan), [[0, 1, 2]], "vertex 0"),
        (np.zeros((0, 3)), [], "empty mesh"),
    ],
)
def test_what_is_no_mesh_is_refused(vertices: np.ndarray, faces: object, words: str) -> None:
    with pytest.raises(mimesh.Error, match=words):
        mimesh.Mesh(vertices, faces)  # type: ignore[arg-type]


def test_files_keep_vertices_polygons_and_poses(tmp_path, horse) -> None:
    file = tmp_path / "horse.glb"
    assert horse.save(file) == [file]
    read = mimesh.load(file)
    # A glTF has numbers of 32 bits.
    np.testing.assert_allclose(read.vertices, horse.vertices, atol=1e-6 * np.abs(horse.vertices).max())
    np.testing.assert_array_equal(read.faces, horse.faces)
    assert read.poses == horse.poses
    np.testing.assert_allclose(read.pose(-1), horse.pose(horse.poses[-1]), atol=1e-5)
    files = mimesh.save(horse, tmp_path / "horse-{pose}.obj")
    assert len(files) == len(horse.poses) and all(file.exists() for file in files)
    # An OBJ has nine decimals.
    np.testing.assert_allclose(mimesh.load(files[0]).vertices, horse.pose(0), rtol=0, atol=1e-9)
    with pytest.raises(mimesh.UsageError, match="no pose is called"):
        horse.pose("no such")


def test_a_mesh_of_a_file_that_is_changed_is_written_as_it_is_now(tmp_path, horse) -> None:
    for name in ("horse.glb", "horse.obj", "horse.ply"):
        horse.save(tmp_path / name)
        larger = mimesh.load(tmp_path / name)
        larger = larger.with_vertices(2 * larger.vertices).with_poses({"up": 2 * larger.vertices + [0, 1, 0]})
        larger.save(tmp_path / f"larger-{name}")
        read = mimesh.load(tmp_path / f"larger-{name}")
        np.testing.assert_allclose(read.vertices, larger.vertices, atol=1e-6 * np.abs(larger.vertices).max())
        np.testing.assert_array_equal(read.faces, larger.faces)
    assert mimesh.load(tmp_path / "larger-horse.glb").poses == ("up",)


def test_missing_and_unwritable_files_are_what_python_knows(tmp_path, grid) -> None:
    with pytest.raises(FileNotFoundError) as missing:
        mimesh.load(tmp_path / "none.obj")
    assert isinstance(missing.value, mimesh.MissingInputError)
    assert missing.value.diagnostics[0].file == str(tmp_path / "none.obj")
    with pytest.raises(mimesh.UsageError, match="no format can write .xyz"):
        grid.save(tmp_path / "grid.xyz")
    (tmp_path / "bad.obj").write_text("v 0 0\n")
    with pytest.raises(mimesh.BadDataError) as bad:
        mimesh.load(tmp_path / "bad.obj")
    assert bad.value.diagnostics[0].line == 1
