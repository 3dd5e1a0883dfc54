"""Meshes and poses out of objects: shape keys, and the evaluated shape at each frame."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from . import animation
from .messages import Refusal, listed

# Modifiers that make other vertices. Whatever others do is found out when the shape is evaluated.
_CONSTRUCTIVE = {
    "ARRAY", "BEVEL", "BOOLEAN", "BUILD", "DECIMATE", "EDGE_SPLIT", "EXPLODE", "FLUID", "MASK", "MIRROR", "MULTIRES", "OCEAN",
    "PARTICLE_INSTANCE", "PARTICLE_SYSTEM", "REMESH", "SCREW", "SKIN", "SOLIDIFY", "SUBSURF", "TRIANGULATE", "VOLUME_TO_MESH",
    "WELD", "WIREFRAME",
}  # fmt: skip


@dataclass
class Frames:
    """The shape of an object at frames."""

    numbers: list[int]
    positions: list[np.ndarray] = field(default_factory=list)
    moves_as_object: bool = False
    """Whether the object also moves as a whole."""
    switched_off: list[str] = field(default_factory=list)
    """Modifiers that were off meanwhile."""


def coordinates(items: Any) -> np.ndarray:
    """Positions of vertices, or of the points of a shape key."""
    values = np.empty(3 * len(items), dtype=np.float32)
    items.foreach_get("co", values)
    return values.reshape(-1, 3).astype(np.float64)


def rest_of(obj: Any) -> np.ndarray:
    """Positions at rest: those of the first shape key, if there is one."""
    keys = obj.data.shape_keys
    return coordinates(keys.reference_key.data if keys else obj.data.vertices)


def polygons_of(obj: Any) -> Any:
    """Polygons with any number of corners."""
    mesh = obj.data
    if not len(mesh.polygons):
        raise Refusal(f"{obj.name} has no faces", "Choose a mesh with faces")
    corners = np.empty(len(mesh.loops), dtype=np.int32)
    mesh.loops.foreach_get("vertex_index", corners)
    sizes = np.empty(len(mesh.polygons), dtype=np.int32)
    mesh.polygons.foreach_get("loop_total", sizes)
    if np.all(sizes == sizes[0]):
        return corners.reshape(-1, sizes[0])
    return np.split(corners, np.cumsum(sizes)[:-1])


def shape_keys_of(obj: Any) -> list[Any]:
    """The shape keys without the first."""
    keys = obj.data.shape_keys
    return [key for key in keys.key_blocks if key != keys.reference_key] if keys else []


def shape_poses(obj: Any) -> dict[str, np.ndarray]:
    """The shape that each key gives alone at the value 1, by its name."""
    keys = obj.data.shape_keys
    rest = rest_of(obj)
    poses = {}
    for key in shape_keys_of(obj):
        shape = coordinates(key.data)
        if keys.use_relative:
            shape = rest + _mask_of(obj, key) * (shape - coordinates(key.relative_key.data))
        poses[key.name] = shape
    return poses


def _mask_of(obj: Any, key: Any) -> Any:
    """The weights by which a vertex group limits a key."""
    group = obj.vertex_groups.get(key.vertex_group) if key.vertex_group else None
    if group is None:
        return 1.0
    weights = np.zeros((len(obj.data.vertices), 1))
    for vertex in obj.data.vertices:
        for element in vertex.groups:
            if element.group == group.index:
                weights[vertex.index] = element.weight
    return weights


def is_deformed(obj: Any) -> bool:
    """Whether anything but shape keys changes the shape."""
    # Old files deform by the parent, without a modifier.
    by_parent = obj.parent is not None and obj.parent_type in ("ARMATURE", "LATTICE")
    return by_parent or any(modifier.show_viewport and modifier.type not in _CONSTRUCTIVE for modifier in obj.modifiers)


def frame_numbers(scene: Any, obj: Any, which: str, step: int) -> list[int]:
    """The frames of the source's actions or of the scene."""
    if which == "SCENE":
        first, last = scene.frame_start, scene.frame_end
    else:
        found = animation.frame_range(obj)
        if found is None:
            raise Refusal(
                f"{obj.name} has no action, nor has its armature",
                "Give it one, or take the frames of the scene, or transfer its shape keys",
            )
        first, last = found
    return list(range(first, last + 1, step))


def read_frames(context: Any, obj: Any, numbers: list[int], rest: np.ndarray, object_motion: bool) -> Iterator[Frames]:
    """Evaluates the object at each frame; gives what there is so far after each of them."""
    if not obj.visible_get(view_layer=context.view_layer):
        raise Refusal(f"{obj.name} is hidden, so Blender does not evaluate its motion", "Show it in this view layer")
    frames = Frames(numbers)
    with _evaluation(context, obj, frames, len(rest)):
        first = None
        for number in numbers:
            context.scene.frame_set(number)
            positions, matrix = _evaluated(context, obj)
            if first is None:
                first = np.linalg.inv(matrix)
            relative = first @ matrix
            frames.moves_as_object |= not np.allclose(relative, np.eye(4), atol=1e-5)
            if object_motion:
                positions = positions @ relative[:3, :3].T + relative[:3, 3]
            frames.positions.append(positions)
            yield frames


def _evaluated(context: Any, obj: Any) -> tuple[np.ndarray, np.ndarray]:
    """Positions in the object's own space, and its matrix, at the current frame."""
    evaluated = obj.evaluated_get(context.evaluated_depsgraph_get())
    mesh = evaluated.to_mesh()
    try:
        return coordinates(mesh.vertices), np.array(evaluated.matrix_world)
    finally:
        evaluated.to_mesh_clear()


@contextmanager
def _evaluation(context: Any, obj: Any, frames: Frames, count: int) -> Iterator[None]:
    """Keeps the number of vertices as it is, and brings everything back afterwards."""
    scene, hidden = context.scene, []
    before = (scene.frame_current, scene.frame_subframe, obj.show_only_shape_key)

    def switch_off(modifier: Any) -> None:
        modifier.show_viewport = False
        hidden.append(modifier.name)
        frames.switched_off.append(modifier.name)

    try:
        obj.show_only_shape_key = False
        for modifier in obj.modifiers:
            if modifier.show_viewport and modifier.type in _CONSTRUCTIVE:
                switch_off(modifier)
        scene.frame_set(frames.numbers[0])
        # Nodes may make vertices or only move them.
        for modifier in reversed(obj.modifiers):
            if len(_evaluated(context, obj)[0]) == count:
                break
            if modifier.show_viewport and modifier.type == "NODES":
                switch_off(modifier)
                context.view_layer.update()
        found = len(_evaluated(context, obj)[0])
        if found != count:
            left = listed(modifier.name for modifier in obj.modifiers if modifier.show_viewport)
            raise Refusal(
                f"{obj.name} has {count} vertices, and {found} with its modifiers ({left})",
                "Apply or switch off the modifiers that add or remove vertices",
            )
        yield
    finally:
        for name in hidden:
            obj.modifiers[name].show_viewport = True
        obj.show_only_shape_key = before[2]
        scene.frame_set(before[0], subframe=before[1])
