"""Meshes of other libraries."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

import mimesh


def test_trimesh_and_back(grid) -> None:
    pytest.importorskip("trimesh")
    made = mimesh.to_trimesh(grid)
    assert len(made.vertices) == 144
    back = mimesh.from_trimesh(made)
    np.testing.assert_array_equal(back.vertices, grid.vertices)
    np.testing.assert_array_equal(back.faces, grid.faces)
    assert mimesh.as_mesh(made).faces.shape == grid.faces.shape


def test_meshio_and_back() -> None:
    pytest.importorskip("meshio")
    vertices = np.random.default_rng(0).normal(size=(9, 3))
    mesh = mimesh.Mesh(vertices, [[0, 1, 2], [2, 3, 4, 5], [4, 5, 6, 7, 8], [0, 2, 4]])
    made = mimesh.to_meshio(mesh)
    assert [block.type for block in made.cells] == ["triangle", "quad", "polygon", "triangle"]
    back = mimesh.from_meshio(made)
    np.testing.assert_array_equal(back.vertices, vertices)
    assert [polygon.tolist() for polygon in back.polygons] == [polygon.tolist() for polygon in mesh.polygons]


def test_arrays_of_libigl(grid) -> None:
    igl = pytest.importorskip("igl")
    laplacian = igl.cotmatrix(np.array(grid.vertices), np.array(grid.faces, dtype=np.int64))
    assert laplacian.shape == (144, 144)
    mesh = mimesh.as_mesh((np.array(grid.vertices, order="F"), np.array(grid.faces, dtype=np.int32, order="F")))
    np.testing.assert_array_equal(mesh.vertices, grid.vertices)


class Column:
    """What Blender calls a collection of values that can be had all at once."""

    def __init__(self, **values: np.ndarray) -> None:
        self.values = values

    def __len__(self) -> int:
        return len(next(iter(self.values.values())))

    def foreach_get(self, name: str, into: np.ndarray) -> None:
        into[:] = self.values[name].reshape(-1)

    def foreach_set(self, name: str, values: np.ndarray) -> None:
        self.values[name] = np.array(values).reshape(-1, 3)


class BlenderObject:
    """As much of an object of Blender as is used."""

    def __init__(self) -> None:
        self.data = SimpleNamespace(
            vertices=Column(co=np.zeros((0, 3))),
            loops=Column(vertex_index=np.zeros(0)),
            polygons=Column(loop_total=np.zeros(0)),
            shape_keys=None,
            from_pydata=self._fill,
            update=lambda: None,
        )

    def _fill(self, vertices: list, edges: list, faces: list) -> None:
        assert edges == []
        self.data.vertices = Column(co=np.array(vertices, dtype=np.float32))
        self.data.loops = Column(vertex_index=np.array([v for face in faces for v in face]))
        self.data.polygons = Column(loop_total=np.array([len(face) for face in faces]))

    def shape_key_add(self, name: str, from_mix: bool) -> SimpleNamespace:
        assert not from_mix
        if self.data.shape_keys is None:
            self.data.shape_keys = SimpleNamespace(key_blocks=[])
        rest = self.data.vertices.values["co"]
        block = SimpleNamespace(name=name, data=Column(co=rest.copy()))
        self.data.shape_keys.key_blocks.append(block)
        return block


def test_blender_and_back() -> None:
    vertices = np.round(np.random.default_rng(0).normal(size=(5, 3)), 2).astype(np.float32)
    mesh = mimesh.Mesh(vertices, [[0, 1, 2, 3], [2, 3, 4]], poses={"smile": vertices + 1, "frown": vertices - 1})
    made = BlenderObject()
    mimesh.to_bpy(mesh, made)
    assert [block.name for block in made.data.shape_keys.key_blocks] == ["Basis", "smile", "frown"]
    back = mimesh.as_mesh(made)
    np.testing.assert_array_equal(back.vertices, vertices)
    assert [polygon.tolist() for polygon in back.polygons] == [[0, 1, 2, 3], [2, 3, 4]]
    assert back.poses == ("smile", "frown")
    np.testing.assert_array_equal(back.pose("smile"), (vertices + 1).astype(np.float32))
