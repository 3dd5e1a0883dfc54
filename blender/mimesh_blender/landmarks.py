"""Points that correspond, from empties or vertex groups."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
from mathutils.bvhtree import BVHTree

from .messages import Refusal, counted, listed

_NUMBER = re.compile(r"\.\d{3,}$")
_FEW = 4
# An empty that is farther from the surface than this share of the diagonal was hardly put there on purpose.
_FAR = 0.1


class Landmarks:
    """Pairs of points of two surfaces."""

    def __init__(self, names: list[str], source: list[dict[str, Any]], target: list[dict[str, Any]], messages: list[str]) -> None:
        self.names = names
        self.messages = messages
        self._source, self._target = source, target

    def write(self, folder: str) -> str:
        """Writes them as mimesh reads them; the file."""
        pairs = zip(self.names, self._source, self._target)
        markers = [{"name": name, "source": source, "target": target} for name, source, target in pairs]
        path = Path(folder) / "landmarks.yaml"
        path.write_text(json.dumps({"markers": markers}), encoding="utf-8")
        return str(path)


def from_empties(scene: Any, source: Any, target: Any, source_mesh: Any, target_mesh: Any) -> Landmarks:
    """The points of the surfaces nearest to empties.

    The meshes are those of the objects at rest.
    """
    found = empties_of(scene, source, target)
    names = _paired({name: set(ends) for name, ends in found.items()}, source.name, target.name, "empty")
    messages: list[str] = []
    sides = []
    for side, obj, mesh in (("source", source, source_mesh), ("target", target, target_mesh)):
        places = [found[name][side] for name in names]
        sides.append(_on_surface(obj, mesh, places, messages))
    return Landmarks(names, *sides, messages)


def empties_of(scene: Any, source: Any, target: Any) -> dict[str, dict[str, Any]]:
    """Empties by the name of the landmark and the side: `source` or `target`."""
    found: dict[str, dict[str, Any]] = {}
    for obj in scene.objects:
        if obj.type != "EMPTY":
            continue
        plain = _NUMBER.sub("", obj.name)
        name, _, suffix = plain.rpartition(".")
        if name and suffix in ("source", "target"):
            found.setdefault(name, {})[suffix] = obj
        elif obj.parent in (source, target):
            found.setdefault(plain, {})["source" if obj.parent == source else "target"] = obj
    return found


def from_groups(source: Any, target: Any, source_rest: np.ndarray, target_rest: np.ndarray) -> Landmarks:
    """The vertices nearest to the middle of vertex groups of equal name."""
    middles = [_middles(obj, rest) for obj, rest in ((source, source_rest), (target, target_rest))]
    common = [name for name in middles[0] if name in middles[1]]
    if not common:
        raise Refusal(
            f"{source.name} and {target.name} have no vertex group of equal name that holds vertices",
            "Name groups alike on both, or choose other landmarks",
        )
    alone = sorted(set(middles[0]) ^ set(middles[1]))
    messages = [f"vertex groups of one object alone were left out: {listed(alone)}"] if alone else []
    source_points, target_points = ([{"vertex": side[name]} for name in common] for side in middles)
    return Landmarks(common, source_points, target_points, messages)


def _paired(sides: dict[str, set[str]], source: str, target: str, thing: str) -> list[str]:
    """The names that both sides have; refuses names without a partner."""
    alone = {side: sorted(name for name, ends in sides.items() if ends == {side}) for side in ("source", "target")}
    lacking = [
        f"no {thing} on {other} for {listed(alone[side])}"
        for side, other in (("source", f"the target ({target})"), ("target", f"the source ({source})"))
        if alone[side]
    ]
    if lacking:
        raise Refusal("; ".join(lacking), "Add the partners, or delete or rename these empties")
    if not sides:
        raise Refusal(
            "there are no empties as landmarks",
            "Name empties NAME.source and NAME.target, or parent empties of equal names to both objects; or choose Automatic",
        )
    if len(sides) < _FEW:
        raise Refusal(f"there are only {counted(len(sides), 'landmark')}", f"Set at least {_FEW}, better a dozen, or choose Automatic")
    return sorted(sides)


def _on_surface(obj: Any, mesh: Any, empties: list[Any], messages: list[str]) -> list[dict[str, Any]]:
    """The points of a surface nearest to empties, as triangles with barycentric coordinates."""
    triangles = np.asarray(mesh.faces, dtype=np.int64)
    # In the world, where distances are those that one sees.
    matrix = np.array(obj.matrix_world)
    vertices = mesh.vertices @ matrix[:3, :3].T + matrix[:3, 3]
    tree = BVHTree.FromPolygons(vertices.tolist(), triangles.tolist(), all_triangles=True)
    diagonal = float(np.linalg.norm(np.ptp(vertices, axis=0)))
    points, far = [], []
    for empty in empties:
        nearest, _, triangle, distance = tree.find_nearest(empty.matrix_world.translation)
        if distance > _FAR * diagonal:
            far.append(empty.name)
        barycentric = _barycentric(vertices[triangles[triangle]], np.array(nearest))
        points.append({"triangle": triangle, "barycentric": barycentric})
    if far:
        messages.append(f"far from the surface of {obj.name} at rest: {listed(far)}")
    return points


def _barycentric(corners: np.ndarray, point: np.ndarray) -> list[float]:
    edges = np.stack([corners[1] - corners[0], corners[2] - corners[0]], axis=1)
    second, third = np.linalg.lstsq(edges, point - corners[0], rcond=None)[0]
    weights = np.clip([1 - second - third, second, third], 0, 1)
    return (weights / weights.sum()).tolist()


def _middles(obj: Any, rest: np.ndarray) -> dict[str, int]:
    """For each vertex group that holds vertices the one of them nearest to its middle."""
    members: dict[int, list[tuple[int, float]]] = {}
    for vertex in obj.data.vertices:
        for element in vertex.groups:
            if element.weight > 0:
                members.setdefault(element.group, []).append((vertex.index, element.weight))
    middles = {}
    for group in obj.vertex_groups:
        if group.index in members:
            indices, weights = zip(*members[group.index])
            places = rest[list(indices)]
            middle = np.average(places, axis=0, weights=weights)
            middles[group.name] = int(indices[np.linalg.norm(places - middle, axis=1).argmin()])
    return middles
