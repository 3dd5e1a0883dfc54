"""Actions, F-curves and drivers, with and without the slots that Blender has since 4.4."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import bpy


def frame_range(obj: Any) -> tuple[int, int] | None:
    """The first and last frame of the actions and strips that move an object, its shape keys or its armatures."""
    ranges = [found for owner in _movers(obj) for found in _ranges(owner)]
    if not ranges:
        return None
    return round(min(first for first, _ in ranges)), round(max(last for _, last in ranges))


def action_name(obj: Any) -> str:
    """The name of the action that moves an object; else its own name."""
    for owner in _movers(obj):
        if owner.animation_data and owner.animation_data.action:
            return owner.animation_data.action.name
    return obj.name


def is_moved(owner: Any) -> bool:
    """Whether a data-block has an action, strips or drivers."""
    data = owner.animation_data if owner else None
    return bool(data and (data.action or data.drivers)) or plays_strips(owner)


def plays_strips(owner: Any) -> bool:
    """Whether strips move a data-block."""
    data = owner.animation_data if owner else None
    return bool(data and any(not (track.mute or strip.mute) for track in data.nla_tracks for strip in track.strips))


def _movers(obj: Any) -> list[Any]:
    """The data-blocks whose animation changes the shape of an object, nearest first."""
    movers = [obj.data.shape_keys, obj.data]
    movers += [modifier.object for modifier in obj.modifiers if getattr(modifier, "object", None)]
    ancestor = obj
    while ancestor is not None:
        movers.append(ancestor)
        ancestor = ancestor.parent
    unique = []
    for mover in movers:
        if mover is not None and mover not in unique:
            unique.append(mover)
    return unique


def _ranges(owner: Any) -> Iterable[tuple[float, float]]:
    data = owner.animation_data
    if data is None:
        return
    if data.action:
        yield tuple(data.action.frame_range)
    for track in data.nla_tracks:
        for strip in track.strips:
            if not (track.mute or strip.mute):
                yield strip.frame_start, strip.frame_end


def curves_of(owner: Any) -> list[Any]:
    """The F-curves of the active action of a data-block."""
    data = owner.animation_data if owner else None
    if data is None or data.action is None:
        return []
    if not hasattr(data, "action_slot"):
        return list(data.action.fcurves)
    if data.action_slot is None:
        return []
    bags = [strip.channelbag(data.action_slot) for layer in data.action.layers for strip in layer.strips]
    return [curve for bag in bags if bag is not None for curve in bag.fcurves]


class NewAction:
    """A new action of a data-block, which takes the place of the one before."""

    def __init__(self, owner: Any, name: str) -> None:
        self._owner = owner
        data = owner.animation_data or owner.animation_data_create()
        self.before = data.action
        self._slot_before = getattr(data, "action_slot", None)
        if self.before is not None:
            self._had_user, self.before.use_fake_user = self.before.use_fake_user, True
        self.action = bpy.data.actions.new(name)
        data.action = self.action
        if hasattr(data, "action_slot"):
            data.action_slot = self.action.slots.new(id_type=owner.id_type, name=owner.name)
            strip = self.action.layers.new("Layer").strips.new(type="KEYFRAME")
            self._curves = strip.channelbag(data.action_slot, ensure=True).fcurves
        else:
            self._curves = self.action.fcurves

    def curve(self, path: str) -> Any:
        """A new F-curve without keyframes."""
        return self._curves.new(path)

    def undo(self) -> None:
        """Puts back what was there before."""
        data = self._owner.animation_data
        data.action = self.before
        if self.before is not None:
            self.before.use_fake_user = self._had_user
            if self._slot_before is not None:
                data.action_slot = self._slot_before
        bpy.data.actions.remove(self.action)


def value_path(key_name: str) -> str:
    """The path of the value of a shape key, from the shape keys of the mesh."""
    return f'key_blocks["{bpy.utils.escape_identifier(key_name)}"].value'


def play_frames(action: NewAction, names: list[str], numbers: list[int], interpolation: str) -> None:
    """Turns on one shape key at each frame."""
    for i, name in enumerate(names):
        points = [(numbers[j], float(j == i)) for j in (i - 1, i, i + 1) if 0 <= j < len(numbers)]
        curve = action.curve(value_path(name))
        curve.keyframe_points.add(len(points))
        curve.keyframe_points.foreach_set("co", [value for point in points for value in point])
        for point in curve.keyframe_points:
            point.interpolation = interpolation
        curve.update()


def copy_curve(curve: Any, to: Any) -> None:
    """Copies keyframes, what lies between and outside them, and modifiers of an F-curve."""
    to.extrapolation = curve.extrapolation
    to.keyframe_points.add(len(curve.keyframe_points))
    for new, old in zip(to.keyframe_points, curve.keyframe_points):
        new.co = old.co
        for name in ("interpolation", "easing", "back", "amplitude", "period", "type"):
            setattr(new, name, getattr(old, name))
        new.handle_left_type, new.handle_right_type = old.handle_left_type, old.handle_right_type
        new.handle_left, new.handle_right = old.handle_left, old.handle_right
    for old in curve.modifiers:
        _copy_properties(old, to.modifiers.new(old.type))
    to.update()


def _copy_properties(old: Any, new: Any) -> None:
    for rule in old.bl_rna.properties:
        if not rule.is_readonly and rule.type in {"BOOLEAN", "INT", "FLOAT", "ENUM"}:
            setattr(new, rule.identifier, getattr(old, rule.identifier))


def copy_driver(curve: Any, owner: Any, key_name: str, replaced: dict[Any, Any]) -> Any:
    """Copies the driver of a shape key's value; variables that read the source read the target instead."""
    data = owner.animation_data or owner.animation_data_create()
    new = data.drivers.from_existing(src_driver=curve)
    new.data_path = value_path(key_name)
    for variable in new.driver.variables:
        for target in variable.targets:
            if target.id in replaced:
                target.id = replaced[target.id]
    return new
