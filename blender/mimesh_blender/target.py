"""Results into an object, all or nothing."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import bpy
import numpy as np

from . import animation
from .messages import Refusal, listed
from .source import coordinates, rest_of

# The longest name of a shape key, in bytes.
_LONGEST = 63


def check(obj: Any) -> None:
    """Refuses an object that cannot take shape keys."""
    mesh = obj.data
    if not obj.is_editable or not mesh.is_editable:
        raise Refusal(f"{obj.name} is linked from another file", "Make it local, or transfer onto a copy")
    if mesh.shape_keys and not mesh.shape_keys.use_relative:
        raise Refusal(f"the shape keys of {obj.name} are absolute", "Turn on Relative in its shape keys")


class Writer:
    """Writes into a target; `undo` takes everything back."""

    def __init__(self, obj: Any, replace: bool) -> None:
        self.obj = obj
        self.renamed: list[str] = []
        self.replaced: list[str] = []
        self.action: animation.NewAction | None = None
        self._replace = replace
        self._undo: list[Callable[[], object]] = []
        if obj.data.shape_keys is None:
            obj.shape_key_add(name="Basis", from_mix=False)
            self._undo.append(obj.shape_key_clear)
        self._rest = rest_of(obj)

    @property
    def keys(self) -> Any:
        """The shape keys of the target."""
        return self.obj.data.shape_keys

    def write_shape(self, name: str, positions: np.ndarray) -> Any:
        """Writes a shape key, and gives it."""
        blocks = self.keys.key_blocks
        existing = blocks.get(name)
        if existing is not None and self._replace and existing != self.keys.reference_key:
            before = coordinates(existing.data)
            self._undo.append(lambda: _put(blocks[name], before))
            # Keys may be relative to others than the first.
            _put(existing, positions - self._rest + coordinates(existing.relative_key.data))
            self.replaced.append(name)
            return existing
        key = self.obj.shape_key_add(name=name, from_mix=False)
        # Blender 5 makes new keys with the value 1.
        key.value = 0.0
        made = key.name
        self._undo.append(lambda: self.obj.shape_key_remove(self.keys.key_blocks[made]))
        if made != name:
            self.renamed.append(f"{name} is {made}")
        _put(key, positions)
        return key

    def new_action(self, name: str) -> animation.NewAction:
        """The action of this transfer, which is made when it is first asked for."""
        if self.action is None:
            self.action = animation.NewAction(self.keys, name)
            self._undo.append(self.action.undo)
        return self.action

    def copy_driver(self, curve: Any, key_name: str, replaced: dict[Any, Any]) -> None:
        """Copies a driver of the source, unless the target's key is driven already."""
        data = self.keys.animation_data
        path = animation.value_path(key_name)
        if data is None or data.drivers.find(path) is None:
            made = animation.copy_driver(curve, self.keys, key_name, replaced)
            self._undo.append(lambda: self.keys.animation_data.drivers.remove(made))

    def undo(self) -> None:
        """Takes everything back, last first."""
        while self._undo:
            self._undo.pop()()

    def messages(self) -> list[str]:
        """What the user has to know about names and actions."""
        messages = []
        if self.replaced:
            messages.append(f"replaced: {listed(self.replaced)}")
        if self.renamed:
            messages.append(f"names were taken: {listed(self.renamed)}")
        if self.action is not None and self.action.before is not None:
            messages.append(f"the action {self.action.before.name} is kept, with a fake user, but no longer plays")
        return messages


def copy_of(context: Any, obj: Any) -> Any:
    """A copy of an object with a mesh of its own, in the same collections."""
    copy = obj.copy()
    copy.data = obj.data.copy()
    for collection in obj.users_collection or (context.scene.collection,):
        collection.objects.link(copy)
    return copy


def remove_copy(obj: Any) -> None:
    """Removes a copy with its mesh."""
    mesh = obj.data
    bpy.data.objects.remove(obj)
    bpy.data.meshes.remove(mesh)


def frame_key_name(action: str, frame: int) -> str:
    """The name of the shape key that holds a frame."""
    ending = f".{frame:04d}"
    kept = action.encode()[: _LONGEST - 4 - len(ending)].decode(errors="ignore")
    return kept + ending


def _put(key: Any, positions: np.ndarray) -> None:
    key.data.foreach_set("co", np.ascontiguousarray(positions, dtype=np.float32).reshape(-1))
    key.id_data.user.update()
