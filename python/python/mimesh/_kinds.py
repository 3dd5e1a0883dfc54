"""The kinds of stages, and how each is called."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _mimesh
from ._mesh import Mesh, Positions, _positions
from ._stages import Stage
from ._surface import Link, Point, Surface, TriangleMap, mesh_points, parts_of, point_of, surface_of, surface_parts


class Sampler(Stage):
    """Spreads points over a surface.

    A subclass gives ``sample(surface)``: vertices, or pairs of a triangle and barycentric coordinates, in any sequence.
    """

    kind: ClassVar[str] = "sampler"
    _methods = ("sample",)

    def sample(self, surface: Any) -> Any:
        """Points on a `Mesh`, as its file counts, or on a `Surface`."""
        of = surface_of(surface)
        points = [point_of(parts) for parts in _mimesh.sample(self._json(), of._data)]
        return mesh_points(of, points) if isinstance(surface, Mesh) else points


class Weights(Stage):
    """How much each handle moves each vertex.

    A subclass gives ``solve(surface, handles, links)``: an array of vertices × handles whose rows sum to 1, with 1 for each handle at
    its own vertex. ``links`` are pairs of vertices that join components, if they may pass influence on. A row of zeros is of a vertex
    that no handle reaches.
    """

    kind: ClassVar[str] = "weights"
    _methods = ("solve",)

    def solve(self, surface: Any, handles: Any, links: Any = None) -> Any:
        """Weights of handles at vertices of a `Mesh` or points of a `Surface`, #V × #H.

        ``links`` may be a stage of `mimesh.proximity`, so that influence passes between components. Vertices of a mesh that no face
        uses have rows of zeros.
        """
        of = surface_of(surface)
        is_mesh = isinstance(surface, Mesh)
        parts = surface_parts(of, handles) if is_mesh else parts_of(handles)
        proximity = links._json() if isinstance(links, Stage) else None
        weights: NDArray[np.float64] = np.asarray(_mimesh.weights(self._json(), of._data, parts, proximity)).T
        if not is_mesh:
            return weights
        used = of.vertex_of >= 0
        return np.where(used[:, None], weights[np.maximum(of.vertex_of, 0)], 0.0)


class Clusterer(Stage):
    """Divides a surface into regions that move about rigidly.

    A subclass gives ``cluster(surface, poses, weights)``: the number of a region for each vertex.
    """

    kind: ClassVar[str] = "clusterer"
    _methods = ("cluster",)

    def cluster(self, surface: Any, poses: Any, weights: Any) -> Any:
        """The region of each vertex of a `Surface`, by its poses and weights (#V × #H)."""
        seen = [_positions(pose, "pose") for pose in poses]
        matrix = np.ascontiguousarray(weights, dtype=np.float64)
        return np.asarray(_mimesh.cluster(self._json(), surface_of(surface)._data, seen, matrix)[0])


class Deformer(Stage):
    """Finds the affine maps of handles that bring a surface closest to a pose.

    A subclass gives ``fit(surface, weights, regions, posed)``: an array of handles × 3 × 4.
    """

    kind: ClassVar[str] = "deformer"
    _methods = ("fit",)

    def fit(self, surface: Any, weights: Any, regions: Any, posed: Any) -> Any:
        """The maps of the handles, #H × 3 × 4."""
        matrix = np.ascontiguousarray(weights, dtype=np.float64)
        labels = [int(region) for region in regions]
        of = surface_of(surface)
        return np.asarray(_mimesh.fit(self._json(), of._data, matrix, labels, _positions(posed, "posed"))[0])


class KeyPoints(Stage):
    """Chooses the few points of a source that tell its poses best."""

    kind: ClassVar[str] = "key_points"
    _methods = ()

    def choose(self, source: Mesh, poses: Any = None) -> list[Point]:
        """Points of a mesh by its poses, or by others."""
        of = Surface(source)
        seen = [source.pose(i) for i in range(len(source.poses))] if poses is None else poses
        moved = [np.asarray(of.from_mesh(pose)) for pose in seen]
        return mesh_points(of, [point_of(parts) for parts in _mimesh.choose(self._json(), of._data, moved)])


class Landmarks(Stage):
    """Proposes corresponding points of two surfaces.

    A subclass gives ``propose(source, target, markers)``: pairs of points, each perhaps with how sure it is, from 0 to 1. They do not
    share points with the markers.
    """

    kind: ClassVar[str] = "landmarks"
    _methods = ("propose",)

    def propose(self, source: Any, target: Any, markers: Any = ()) -> Any:
        """Pairs of points of two meshes that correspond, with how sure each is."""
        of_source, of_target = surface_of(source), surface_of(target)
        pairs = _pairs(source, target, of_source, of_target, markers)
        found = _mimesh.propose(self._json(), of_source._data, of_target._data, pairs)
        points = [(point_of(a), point_of(b), sure) for a, b, sure in found]
        if not isinstance(source, Mesh):
            return points
        return [(mesh_points(of_source, [a])[0], mesh_points(of_target, [b])[0], sure) for a, b, sure in points]


class Proximity(Stage):
    """Finds which components of a surface lie close together."""

    kind: ClassVar[str] = "proximity"
    _methods = ()

    def link(self, target: Mesh | Surface) -> list[Link]:
        """The links between the components of a surface, whose vertices they name."""
        found = _mimesh.link(self._json(), surface_of(target)._data)
        return [Link((c[0], c[1]), distance, tuple((a, b) for a, b in pairs)) for c, distance, pairs in found]


class Correspondence(Stage):
    """Pairs the triangles of two surfaces.

    A subclass gives ``correspond(source, target, markers)``: for each triangle of the target that of the source, or -1.
    """

    kind: ClassVar[str] = "correspondence"
    _methods = ("correspond",)

    def correspond(self, source: Any, target: Any, markers: Any = ()) -> Any:
        """The `TriangleMap` of two meshes, by pairs of vertices that correspond."""
        of_source, of_target = surface_of(source), surface_of(target)
        pairs = _pairs(source, target, of_source, of_target, markers)
        return TriangleMap._of(_mimesh.correspond(self._json(), of_source._data, of_target._data, pairs))


class Transfer(Stage):
    """Moves a target as its source moves.

    A subclass gives ``bind(source, target, map, markers)``: a function of the source's positions that gives the target's.
    """

    kind: ClassVar[str] = "transfer"
    _methods = ("bind",)
    needs_correspondence: ClassVar[bool] = True
    """Whether it needs a map."""
    markers_needed: ClassVar[int] = 0
    """How many markers it needs."""

    def bind(self, source: Any, target: Any, map: Any = None, markers: Any = (), poses: Any = (), proximity: Any = None) -> Any:
        """A `BoundTransfer` of two meshes.

        ``poses`` are those of the source that a method may want to see. ``proximity`` is a stage that links the components of the
        target.
        """
        of_source, of_target = surface_of(source), surface_of(target)
        pairs = _pairs(source, target, of_source, of_target, markers)
        is_mesh = isinstance(source, Mesh)
        seen = [np.asarray(of_source.from_mesh(pose)) if is_mesh else _positions(pose, "pose") for pose in poses]
        near = None if proximity is None else proximity._json()
        along = None if map is None else map._data
        data = _mimesh.bind(self._json(), of_source._data, of_target._data, pairs, along, seen, near)
        return BoundTransfer(data, of_source, of_target, is_mesh)


class BoundTransfer:
    """A transfer between two meshes, which serves any number of poses."""

    def __init__(self, data: _mimesh.BoundData, source: Surface, target: Surface, is_of_meshes: bool) -> None:
        """Use `Transfer.bind`."""
        self._data = data
        self._source = source
        self._target = target
        self._is_of_meshes = is_of_meshes

    def transfer(self, posed: ArrayLike) -> Positions:
        """The target's positions when the source is at ``posed``."""
        if not self._is_of_meshes:
            return np.asarray(self._data.transfer(_positions(posed, "posed")))
        moved = self._data.transfer(np.asarray(self._source.from_mesh(posed)))
        return self._target.to_mesh(np.asarray(moved))

    @property
    def figures(self) -> dict[str, Any]:
        """What binding found out."""
        figures: dict[str, Any] = json.loads(self._data.figures())
        return figures


@dataclass(frozen=True)
class Statistic:
    """One number that a metric gives of a pose."""

    name: str
    """Its name in reports and gates."""
    unit: str
    """Its unit, e.g. ``%`` or ``degrees``."""
    meaning: str
    """What it measures, in a sentence."""
    title: str = ""
    """What people read where it is above a limit."""
    aggregate: str = "mean"
    """How its values are combined over poses: ``mean``, ``rms`` or ``none``."""
    limits: tuple[float, float] | None = None
    """The sizes above which it is doubtful and bad."""


class Metric(Stage):
    """Measures a posed target.

    A subclass has ``statistics``, a sequence of `Statistic`, and gives ``measure(surface, result, truth)``: a mapping of their names
    to finite numbers. ``truth`` is ``None`` where it is not known.
    """

    kind: ClassVar[str] = "metric"
    _methods = ("measure",)
    statistics: ClassVar[Sequence[Statistic]] = ()
    """What it measures."""
    needs_ground_truth: ClassVar[bool] = False
    """Whether it measures nothing without the truth."""

    def measure(self, surface: Any, result: Any, truth: Any = None) -> Any:
        """The statistics of positions of a `Mesh`, with those that are right if they are known."""
        known = None if truth is None else _positions(truth, "truth")
        measured = _mimesh.measure(self._json(), surface._data, _positions(result, "result"), known)
        values: dict[str, float] = json.loads(measured)
        return values


class Generator(Stage):
    """Makes a mesh with poses."""

    kind: ClassVar[str] = "generator"
    _methods = ()

    def generate(self) -> Mesh:
        """The mesh with its poses."""
        return Mesh._of(_mimesh.generate(self._json()))


class Format(Stage):
    """Settings of a file format."""

    kind: ClassVar[str] = "format"
    _methods = ()


def _pairs(source: Any, target: Any, of_source: Surface, of_target: Surface, markers: Any) -> list[Any]:
    """Markers as the compiled part has them."""
    if isinstance(markers, np.ndarray):
        markers = markers.tolist()
    sides = []
    for i, (mesh, surface) in enumerate([(source, of_source), (target, of_target)]):
        points = [pair[i] for pair in markers]
        sides.append(surface_parts(surface, points) if isinstance(mesh, Mesh) else parts_of(points))
    return list(zip(*sides))


KINDS: tuple[type[Stage], ...] = (
    Clusterer,
    Correspondence,
    Deformer,
    Format,
    Generator,
    KeyPoints,
    Landmarks,
    Metric,
    Proximity,
    Sampler,
    Transfer,
    Weights,
)
"""All kinds."""

