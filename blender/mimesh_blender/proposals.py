"""Empties where landmarks are found by shape, for users to correct."""

from __future__ import annotations

from typing import Any

import bpy
import numpy as np
from mathutils import Vector

from . import landmarks, library, source
from .messages import Refusal

# The size of an empty as a share of the diagonal.
_SIZE = 0.015


def place(context: Any, from_: Any, to: Any) -> tuple[int, str]:
    """Makes pairs of empties on both objects; how many, and which is the least sure."""
    if landmarks.empties_of(context.scene, from_, to):
        raise Refusal("there are empties as landmarks already", "Delete them first")
    mimesh = library.load()
    meshes = [mimesh.Mesh(source.rest_of(obj), source.polygons_of(obj)) for obj in (from_, to)]
    pairs = mimesh.landmarks.Extremities().propose(*meshes)
    if not pairs:
        raise Refusal("no points were found that correspond", "Set empties NAME.source and NAME.target by hand")
    for number, pair in enumerate(pairs, 1):
        for side, obj, mesh, point in zip(("source", "target"), (from_, to), meshes, pair):
            _add(context, f"point{number:02}.{side}", obj, mesh, _position(mesh, point))
    least = min(range(len(pairs)), key=lambda i: pairs[i][2])
    return len(pairs), f"point{least + 1:02} ({pairs[least][2]:.0%})"


def _position(mesh: Any, point: Any) -> np.ndarray:
    """Where a point lies: a vertex, or a triangle with barycentric coordinates."""
    if isinstance(point, int):
        return mesh.vertices[point]
    triangle, weights = point
    return np.asarray(weights) @ mesh.vertices[mesh.faces[triangle]]


def _add(context: Any, name: str, parent: Any, mesh: Any, position: np.ndarray) -> None:
    empty = bpy.data.objects.new(name, None)
    collection = parent.users_collection[0] if parent.users_collection else context.scene.collection
    collection.objects.link(empty)
    empty.parent = parent
    empty.location = Vector(position.tolist())
    empty.empty_display_type = "SPHERE"
    empty.empty_display_size = _SIZE * float(np.linalg.norm(np.ptp(mesh.vertices, axis=0)))
    empty.show_name = empty.show_in_front = True
