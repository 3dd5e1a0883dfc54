"""Meshes of other libraries; none of them is needed before it is used."""

from __future__ import annotations

import os
from typing import Any, Union

import numpy as np

from ._errors import misuse
from ._mesh import Mesh, load

MeshLike = Union[Mesh, str, "os.PathLike[str]", "tuple[Any, Any]", Any]
"""A `Mesh`, a file, a pair of vertices and faces, or a mesh of trimesh, meshio or Blender."""


def as_mesh(mesh: MeshLike) -> Mesh:
    """A mesh of any kind that mimesh understands."""
    if isinstance(mesh, Mesh):
        return mesh
    if isinstance(mesh, (str, os.PathLike)):
        return load(mesh)
    if isinstance(mesh, (tuple, list)) and len(mesh) == 2:
        return Mesh(np.asarray(mesh[0]), mesh[1])
    if hasattr(mesh, "cells_dict") and hasattr(mesh, "points"):
        return from_meshio(mesh)
    if hasattr(mesh, "vertices") and hasattr(mesh, "faces"):
        return from_trimesh(mesh)
    if hasattr(mesh, "data") or hasattr(mesh, "polygons"):
        return from_bpy(mesh)
    hint = "give a mimesh.Mesh, a path, a pair (vertices, faces), or a mesh of trimesh, meshio or Blender"
    raise misuse(f"expected a mesh, found {type(mesh).__name__}", hint)


def from_trimesh(mesh: Any) -> Mesh:
    """The mesh of a ``trimesh.Trimesh``, with its vertices in their order."""
    return Mesh(np.asarray(mesh.vertices, dtype=np.float64), np.asarray(mesh.faces))


def to_trimesh(mesh: Mesh, pose: int | str | None = None) -> Any:
    """A ``trimesh.Trimesh`` of the triangles, at rest or in a pose; nothing is merged."""
    import trimesh

    vertices = mesh.vertices if pose is None else mesh.pose(pose)
    return trimesh.Trimesh(np.array(vertices), np.array(mesh.faces, dtype=np.int64), process=False)


def from_meshio(mesh: Any) -> Mesh:
    """The triangles, quadrangles and polygons of a ``meshio.Mesh``, in the order of its cells."""
    points = np.asarray(mesh.points, dtype=np.float64)
    if points.ndim == 2 and points.shape[1] == 2:
        points = np.column_stack([points, np.zeros(len(points))])
    faces: list[Any] = []
    for block in mesh.cells:
        if block.type in ("triangle", "quad") or block.type.startswith("polygon"):
            faces.extend(np.asarray(block.data))
    if not faces:
        kinds = ", ".join(sorted({block.type for block in mesh.cells})) or "none"
        raise misuse(f"the mesh has no triangles, quadrangles or polygons; its cells are {kinds}")
    return Mesh(points, faces)


def to_meshio(mesh: Mesh, pose: int | str | None = None) -> Any:
    """A ``meshio.Mesh`` of the polygons, at rest or in a pose."""
    import meshio

    vertices = mesh.vertices if pose is None else mesh.pose(pose)
    blocks: list[tuple[str, list[Any]]] = []
    for polygon in mesh.polygons:
        kind = {3: "triangle", 4: "quad"}.get(len(polygon), f"polygon{len(polygon)}")
        if not blocks or blocks[-1][0] != kind:
            blocks.append((kind, []))
        blocks[-1][1].append(polygon)
    cells = [(kind.rstrip("0123456789"), np.array(rows, dtype=np.int64)) for kind, rows in blocks]
    return meshio.Mesh(np.array(vertices), cells)


def from_bpy(mesh: Any) -> Mesh:
    """The mesh of an object of Blender, or of its ``data``: polygons as they are, and shape keys as poses.

    Positions are those of the mesh's own space. The first shape key is the rest.
    """
    data = getattr(mesh, "data", mesh)
    count = len(data.vertices)
    corners = np.empty(len(data.loops), dtype=np.int32)
    data.loops.foreach_get("vertex_index", corners)
    sizes = np.empty(len(data.polygons), dtype=np.int32)
    data.polygons.foreach_get("loop_total", sizes)
    polygons = np.split(corners, np.cumsum(sizes)[:-1]) if len(sizes) else []
    blocks = list(data.shape_keys.key_blocks) if getattr(data, "shape_keys", None) else []
    rest = _coordinates(blocks[0].data if blocks else data.vertices, count)
    poses = {block.name: _coordinates(block.data, count) for block in blocks[1:]}
    return Mesh(rest, polygons, poses or None)


def to_bpy(mesh: Mesh, data: Any) -> None:
    """Writes a mesh and its poses into ``data``, a mesh of Blender without vertices or an object of one.

    Poses become shape keys, for which ``data`` must be an object.
    """
    target = getattr(data, "data", data)
    target.from_pydata(mesh.vertices.tolist(), [], [polygon.tolist() for polygon in mesh.polygons])
    target.update()
    if not mesh.poses:
        return
    if not hasattr(data, "shape_key_add"):
        raise misuse("shape keys belong to objects", "give the object instead of its mesh")
    data.shape_key_add(name="Basis", from_mix=False)
    for name in mesh.poses:
        block = data.shape_key_add(name=name, from_mix=False)
        block.data.foreach_set("co", np.asarray(mesh.pose(name), dtype=np.float32).reshape(-1))


def _coordinates(items: Any, count: int) -> Any:
    values = np.empty(3 * count, dtype=np.float32)
    items.foreach_get("co", values)
    return values.reshape(-1, 3).astype(np.float64)
