"""Surfaces, as stages see meshes; and what the compiled part calls to hand them to stages in Python."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Optional, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _mimesh
from ._mesh import Mesh, Positions, _positions

Point = Union[int, "tuple[int, tuple[float, float, float]]"]
"""A point of a surface or mesh: a vertex, or a triangle with barycentric coordinates of its corners."""

_Parts = tuple[int, Optional[tuple[float, float, float]]]


class Surface:
    """The triangles of a mesh as stages see them: seams are welded, and every vertex belongs to a triangle.

    Triangles have the numbers of `Mesh.faces`. Vertices have numbers of their own.
    """

    def __init__(self, mesh: Mesh) -> None:
        self._data = _mimesh.SurfaceData(mesh._data)
        self._views: dict[str, NDArray[Any]] = {}

    @classmethod
    def _of(cls, data: _mimesh.SurfaceData) -> Surface:
        surface = cls.__new__(cls)
        surface._data = data
        surface._views = {}
        return surface

    def _view(self, name: str) -> NDArray[Any]:
        if name not in self._views:
            self._views[name] = np.asarray(getattr(self._data, name)())
        return self._views[name]

    @property
    def vertices(self) -> Positions:
        """Positions at rest, n × 3: the memory of the surface itself, which cannot be written."""
        return self._view("vertices")

    @property
    def triangles(self) -> NDArray[np.uint32]:
        """The corners of the triangles, m × 3, counter-clockwise seen from outside."""
        return self._view("triangles")

    @property
    def edges(self) -> NDArray[np.uint32]:
        """The edges of triangles, each once, smaller vertex first."""
        if "edges" not in self._views:
            corners = self.triangles
            pairs = np.concatenate([corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [2, 0]]])
            self._views["edges"] = np.unique(np.sort(pairs, axis=1), axis=0)
        return self._views["edges"]

    @property
    def vertex_of(self) -> NDArray[np.int64]:
        """The vertex of the surface for each vertex of the mesh, -1 for one that no face uses."""
        return self._view("vertex_of")

    @property
    def representative(self) -> NDArray[np.uint32]:
        """The first vertex of the mesh for each vertex of the surface."""
        return self._view("representative")

    @property
    def components(self) -> NDArray[np.int64]:
        """The connected component of each vertex."""
        return self._view("components")

    @property
    def diagonal(self) -> float:
        """The length of the diagonal of the box around it."""
        return float(np.linalg.norm(np.ptp(self.vertices, axis=0)))

    def from_mesh(self, positions: ArrayLike) -> Positions:
        """Positions of the surface, from those of the mesh."""
        return np.asarray(self._data.from_mesh(_positions(positions, "positions")))

    def to_mesh(self, positions: ArrayLike) -> Positions:
        """Positions of the mesh, from those of the surface."""
        return np.asarray(self._data.to_mesh(_positions(positions, "positions")))

    def __repr__(self) -> str:
        return f"<mimesh.Surface: {len(self.vertices)} vertices, {len(self.triangles)} triangles>"


class TriangleMap:
    """Where on the source each triangle of the target takes its motion from."""

    def __init__(self, source_triangles: int, triangles: ArrayLike) -> None:
        """A map of triangles as wholes: for each triangle of the target that of the source, or -1."""
        self._data = _mimesh.MapData(int(source_triangles), [int(t) for t in np.asarray(triangles).tolist()])

    @classmethod
    def _of(cls, data: _mimesh.MapData) -> TriangleMap:
        made = cls.__new__(cls)
        made._data = data
        return made

    @property
    def triangles(self) -> NDArray[np.int64]:
        """For each triangle of the target that of the source, or -1."""
        return np.asarray(self._data.triangles(), dtype=np.int64)

    @property
    def points(self) -> list[Point | None]:
        """For each vertex of the target's surface the point of the source's that it lies at; empty if triangles are wholes."""
        return [None if parts is None else point_of(parts) for parts in self._data.points()]


@dataclass(frozen=True)
class Link:
    """Two components of a surface that keep together."""

    components: tuple[int, int]
    """Their numbers, as in `Surface.components`."""
    distance: float
    """The shortest distance between their vertices."""
    pairs: tuple[tuple[int, int], ...]
    """Pairs of vertices that keep together, closest first."""


def surface_of(on: Mesh | Surface) -> Surface:
    """The surface of a mesh, or itself."""
    return on if isinstance(on, Surface) else Surface(on)


def point_of(parts: _Parts) -> Point:
    """A point as Python has it."""
    index, barycentric = parts
    return index if barycentric is None else (index, (barycentric[0], barycentric[1], barycentric[2]))


def parts_of(points: Iterable[Any]) -> list[_Parts]:
    """Points as the compiled part has them."""
    if isinstance(points, np.ndarray):
        points = points.tolist()
    parts: list[_Parts] = []
    for point in points:
        if isinstance(point, (int, np.integer)):
            if point < 0:
                raise ValueError(f"expected vertices from 0, found {point}")
            parts.append((int(point), None))
        else:
            index, (a, b, c) = point
            parts.append((int(index), (float(a), float(b), float(c))))
    return parts


def mesh_points(surface: Surface, points: Sequence[Point]) -> list[Point]:
    """Points of a surface as its mesh counts them."""
    first = surface.representative
    return [int(first[point]) if isinstance(point, int) else point for point in points]


def surface_parts(surface: Surface, points: Iterable[Any]) -> list[_Parts]:
    """Points of a mesh as its surface counts them, for the compiled part."""
    vertex_of = surface.vertex_of
    parts = []
    for index, barycentric in parts_of(points):
        if barycentric is None:
            if index >= len(vertex_of) or vertex_of[index] < 0:
                raise ValueError(f"the mesh has no vertex {index} that a face uses: it has {len(vertex_of)}, from 0")
            index = int(vertex_of[index])
        parts.append((index, barycentric))
    return parts


# What follows hands data of the compiled part to stages in Python, and their results back.


def pairs_of(pairs: Iterable[tuple[_Parts, _Parts]]) -> list[tuple[Point, Point]]:
    return [(point_of(source), point_of(target)) for source, target in pairs]


def solve_weights(stage: Any, surface: Surface, handles: list[int], links: list[Any]) -> Any:
    pairs = np.asarray(links, dtype=np.int64).reshape(-1, 2)
    return stage.solve(surface, np.asarray(handles, dtype=np.int64), pairs)


def correspond(stage: Any, source: Surface, target: Surface, markers: Any) -> Any:
    found = stage.correspond(source, target, pairs_of(markers))
    return found.triangles if isinstance(found, TriangleMap) else found


def propose(stage: Any, source: Surface, target: Surface, markers: Any) -> list[tuple[_Parts, _Parts, float]]:
    found = []
    for pair in stage.propose(source, target, pairs_of(markers)):
        points = parts_of(pair[:2])
        found.append((points[0], points[1], float(pair[2]) if len(pair) > 2 else 0.5))
    return found


def bind(stage: Any, source: Surface, target: Surface, map: _mimesh.MapData | None, markers: Any) -> Any:
    made = None if map is None else TriangleMap._of(map)
    return stage.bind(source, target, made, pairs_of(markers))


def fit(stage: Any, surface: Surface, weights: Any, regions: Any, posed: Any) -> Any:
    maps = np.asarray(stage.fit(surface, weights, regions, posed), dtype=np.float64)
    return maps.reshape(len(maps), -1)


def statistics_of(stage: Any) -> list[tuple[str, str, str, str, str, tuple[float, float] | None]]:
    return [(s.name, s.unit, s.meaning, s.title, s.aggregate, s.limits) for s in stage.statistics]


def measure(stage: Any, surface: Surface, result: Any, truth: Any = None) -> list[tuple[str, float]]:
    return [(str(name), float(value)) for name, value in stage.measure(surface, result, truth).items()]
