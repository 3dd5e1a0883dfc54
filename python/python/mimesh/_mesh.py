"""Meshes."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _display, _mimesh
from ._errors import misuse

if TYPE_CHECKING:
    from ._surface import Surface


Positions = NDArray[np.float64]
"""Positions of vertices, n × 3."""

PosesLike = Union[ArrayLike, Mapping[str, Any], Sequence[Any]]
"""Poses: an array of p × n × 3, arrays or meshes in a list, or a mapping of names to them."""


class Mesh:
    """A polygon mesh with its poses; it does not change.

    Vertices and polygons are those of the file or of the arrays, in their order.

    >>> import numpy as np
    >>> mesh = Mesh(np.eye(3), [[0, 1, 2]])
    >>> mesh.vertices.shape, mesh.faces.tolist()
    ((3, 3), [[0, 1, 2]])
    """

    def __init__(self, vertices: ArrayLike, faces: ArrayLike | Sequence[Sequence[int]], poses: PosesLike | None = None) -> None:
        """A mesh of positions (n × 3) and polygons: an array of m × 3 or m × 4 indices, or a list of polygons of any size.

        Both are copied once, and the mesh keeps the copies.
        """
        corners, sizes = _polygons(faces)
        self._data = _mimesh.MeshData(_positions(vertices, "vertices"), corners, sizes)
        self._views: dict[str, NDArray[Any]] = {}
        if poses is not None:
            self._data = _with_poses(self._data, poses)

    @classmethod
    def _of(cls, data: _mimesh.MeshData) -> Mesh:
        mesh = cls.__new__(cls)
        mesh._data = data
        mesh._views = {}
        return mesh

    def _view(self, name: str) -> NDArray[Any]:
        if name not in self._views:
            self._views[name] = np.asarray(getattr(self._data, name)())
        return self._views[name]

    @property
    def vertices(self) -> Positions:
        """Positions at rest, n × 3: the memory of the mesh itself, which cannot be written."""
        return self._view("vertices")

    @property
    def faces(self) -> NDArray[np.uint32]:
        """Triangles, m × 3; larger polygons are cut into fans from their first corners."""
        sizes = self._view("sizes")
        if np.all(sizes == 3):
            return self._view("corners").reshape(-1, 3)
        return self._view("triangles")

    @property
    def polygons(self) -> list[NDArray[np.uint32]]:
        """The polygons as they are, each with the indices of its corners."""
        return np.split(self._view("corners"), np.cumsum(self._view("sizes"))[:-1])

    @property
    def surface(self) -> Surface:
        """The surface that stages see."""
        from ._surface import Surface

        return Surface(self)

    @property
    def poses(self) -> tuple[str, ...]:
        """The names of the poses."""
        return tuple(self._data.pose_names())

    def pose(self, which: int | str) -> Positions:
        """Positions in a pose, n × 3, by its number or name."""
        names = self._data.pose_names()
        if isinstance(which, str):
            if which not in names:
                raise misuse(f"no pose is called {which!r}", f"poses: {', '.join(names) or 'none'}")
            which = names.index(which)
        count = len(names)
        if not -count <= which < count:
            raise misuse(f"there is no pose {which}", f"the mesh has {count}")
        return np.asarray(self._data.pose(which % count))

    def with_poses(self, poses: PosesLike) -> Mesh:
        """The same mesh with these poses and no others."""
        return Mesh._of(_with_poses(self._data, poses))

    def with_vertices(self, vertices: ArrayLike) -> Mesh:
        """The same polygons, with vertices elsewhere and without poses."""
        return Mesh._of(self._data.with_vertices(_positions(vertices, "vertices")))

    @property
    def clips(self) -> tuple[str, ...]:
        """The names of the clips of its file."""
        return tuple(clip["name"] for clip in self._facts()["clips"])

    @property
    def warnings(self) -> tuple[str, ...]:
        """What its file holds and was left out."""
        return tuple(self._facts()["warnings"])

    def _facts(self) -> dict[str, Any]:
        facts: dict[str, Any] = json.loads(self._data.facts())
        return facts

    def save(self, path: str | os.PathLike[str]) -> list[Path]:
        """Writes the mesh, and the poses where the format takes them; with ``{pose}`` in the name a file a pose.

        The files that were written. A file that is there already is replaced.
        """
        return [Path(file) for file in self._data.save(path)]

    def picture(self, pose: int | str | None = None, *, view: str = "three_quarter", up: str = "y", size: int = 320) -> bytes:
        """A PNG of the mesh at rest or in a pose.

        ``view`` is ``three_quarter``, ``front``, ``side`` or ``top``, and ``up`` the axis that points up, ``y`` or ``z``.
        """
        positions = self.vertices if pose is None else self.pose(pose)
        return _display.pictures(self, [positions], view, up, size)[0]

    def animation(
        self, frames_per_second: float = 12.0, *, view: str = "three_quarter", up: str = "y", size: int = 320
    ) -> bytes:
        """A PNG that plays the poses, at most 24 of them; browsers and notebooks show it as any picture."""
        shown = [self.pose(i) for i in _display.evenly_spaced(len(self.poses))] or [self.vertices]
        return _display.animation(self, shown, frames_per_second, view, up, size)

    def _repr_html_(self) -> str:
        return _display.as_html(self.picture(), repr(self)[1:-1])

    def __repr__(self) -> str:
        sizes = self._view("sizes")
        what = "triangles" if np.all(sizes == 3) else "polygons"
        poses = f", {len(self.poses)} poses" if self.poses else ""
        return f"<mimesh.Mesh: {len(self.vertices)} vertices, {len(sizes)} {what}{poses}>"


def load(
    path: str | os.PathLike[str],
    *,
    meshes: str | Sequence[str] = (),
    clip: str | None = None,
    frames_per_second: float = 24.0,
) -> Mesh:
    """Reads a mesh with its poses from a file of any format that mimesh knows.

    The poses are the file's morph targets; else frames of ``clip``, or of its first clip that lasts. ``meshes`` are names of
    objects or materials, where only these are wanted.
    """
    names = [meshes] if isinstance(meshes, str) else list(meshes)
    return Mesh._of(_mimesh.load(path, names, clip, float(frames_per_second)))


def save(mesh: Mesh, path: str | os.PathLike[str]) -> list[Path]:
    """Writes ``mesh``; see `Mesh.save`."""
    return mesh.save(path)


def _positions(values: Any, what: str) -> Positions:
    """Values as an array that can be read in one go; it is copied only where it is none yet."""
    array = np.ascontiguousarray(values, dtype=np.float64)
    if array.ndim != 2 or array.shape[1] != 3:
        raise misuse(f"{what}: expected an array of n × 3 numbers, found one of the shape {array.shape}")
    return array


def _polygons(faces: Any) -> tuple[NDArray[np.uint32], NDArray[np.uint32]]:
    """The corners of all polygons, and the number of corners of each."""
    if not isinstance(faces, np.ndarray):
        faces = [np.asarray(polygon) for polygon in faces]
        sizes = np.array([len(polygon) for polygon in faces], dtype=np.uint32)
        corners = np.concatenate(faces) if faces else np.empty(0, dtype=np.int64)
    else:
        if faces.ndim != 2:
            raise misuse(f"faces: expected an array of m × 3 indices or a list of polygons, found the shape {faces.shape}")
        sizes = np.full(faces.shape[0], faces.shape[1], dtype=np.uint32)
        corners = faces.reshape(-1)
    if corners.size and not np.issubdtype(corners.dtype, np.integer):
        raise misuse(f"faces: expected whole numbers, found {corners.dtype}")
    if corners.size and (corners.min() < 0 or corners.max() > np.iinfo(np.uint32).max):
        raise misuse(f"faces: expected indices of vertices from 0, found {corners.min()} to {corners.max()}")
    return np.ascontiguousarray(corners, dtype=np.uint32), sizes


def _with_poses(data: _mimesh.MeshData, poses: Any) -> _mimesh.MeshData:
    named = named_poses(poses)
    arrays = [_positions(positions, f"pose {name}") for name, positions in named]
    return data.with_poses([name for name, _ in named], arrays)


def named_poses(poses: Any) -> list[tuple[str, Any]]:
    """Poses with their names; those without are numbered from 1."""
    if isinstance(poses, Mapping):
        return [(str(name), _of_pose(pose)) for name, pose in poses.items()]
    listed = list(poses)
    digits = max(2, len(str(len(listed))))
    return [(f"pose-{i:0{digits}}", _of_pose(pose)) for i, pose in enumerate(listed, 1)]


def _of_pose(pose: Any) -> Any:
    """The positions of a pose that may be a mesh of any kind."""
    if isinstance(pose, Mesh):
        return pose.vertices
    if isinstance(pose, (str, os.PathLike)):
        return load(pose).vertices
    for name in ("vertices", "points"):
        if hasattr(pose, name):
            return getattr(pose, name)
    if isinstance(pose, tuple) and len(pose) == 2:
        return pose[0]
    return pose
