"""One transfer: read from the source, compute, write into the target. Only the middle may run in another thread."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from . import animation, landmarks, library, outcome, source, target
from .messages import Refusal, counted, listed
from .spaces import Space


@dataclass
class Step:
    """How far the job is."""

    label: str
    share: float


class Job:
    """A transfer with the settings of a scene."""

    def __init__(self, context: Any, use_selection: bool = False) -> None:
        self._context = context
        self._settings = settings = context.scene.mimesh
        self.source, self.target = pair_of(context, use_selection)
        self.messages: list[str] = []
        self._mimesh = library.load()
        self._arguments: dict[str, Any] = {}
        if settings.method != "AUTO":
            self._arguments["transfer"] = settings.method
        self._arguments["threads"] = settings.threads or None
        self._shapes: dict[str, np.ndarray] = {}
        self._frames: source.Frames | None = None
        self._landmarks: landmarks.Landmarks | None = None
        self._results: dict[str, Any] = {}
        self._copies_motion = False

    def read(self) -> Iterator[Step]:
        """Reads meshes and poses; gives a step now and then."""
        settings, from_, to = self._settings, self.source, self.target
        check_pair(from_, to)
        if not settings.on_copy:
            target.check(to)
            if to.data.users > 1:
                self.messages.append(f"{counted(to.data.users, 'object')} share the mesh of {to.name}: all take the shape keys")
        self.messages += [
            f"{obj.name} is mirrored by a modifier, and only the half that is its own was used: apply the modifier to use all"
            for obj in (from_, to)
            if any(modifier.type == "MIRROR" and modifier.show_viewport for modifier in obj.modifiers)
        ]
        yield Step("Reading meshes", 0.0)
        self._space, self._target_space = Space(from_), Space(to)
        rest, target_rest = source.rest_of(from_), source.rest_of(to)
        polygons, target_polygons = source.polygons_of(from_), source.polygons_of(to)
        if settings.landmarks == "EMPTIES":
            local = [self._mimesh.Mesh(rest, polygons), self._mimesh.Mesh(target_rest, target_polygons)]
            self._landmarks = landmarks.from_empties(self._context.scene, from_, to, *local)
        elif settings.landmarks == "GROUPS":
            self._landmarks = landmarks.from_groups(from_, to, rest, target_rest)
        with_shapes, with_frames = self._parts()
        if with_shapes:
            self._shapes = source.shape_poses(from_)
            if not from_.data.shape_keys.use_relative:
                self.messages.append(f"the shape keys of {from_.name} are absolute: each was taken as the shape that it holds")
        if with_frames:
            yield from self._read_frames(rest)
        self._source_mesh = self._mimesh.Mesh(self._space.stretched(rest), polygons)
        self._target_mesh = self._mimesh.Mesh(self._target_space.stretched(target_rest), target_polygons)

    def _parts(self) -> tuple[bool, bool]:
        """Whether shape keys are transferred, and whether frames are."""
        from_, what = self.source, self._settings.what
        has_shapes = bool(source.shape_keys_of(from_))
        keys_move = animation.is_moved(from_.data.shape_keys)
        moves_else = source.is_deformed(from_) and animation.frame_range(from_) is not None
        if what == "AUTO":
            if not has_shapes and not moves_else and animation.frame_range(from_) is None:
                raise Refusal(
                    f"{from_.name} has neither shape keys nor an action",
                    "Choose a source with either; are source and target swapped?",
                )
            motion = moves_else or keys_move or not has_shapes
            what = "BOTH" if has_shapes and motion else "SHAPE_KEYS" if has_shapes else "ACTION"
        if what in ("SHAPE_KEYS", "BOTH") and not has_shapes:
            raise Refusal(f"{from_.name} has no shape keys", "Transfer its action; are source and target swapped?")
        if what == "BOTH" and not source.is_deformed(from_) and not animation.plays_strips(from_.data.shape_keys):
            # The curves of the keys are all the motion there is.
            self._copies_motion = True
            if not keys_move:
                self.messages.append(f"the shape keys of {from_.name} have no animation")
        return what != "ACTION", what == "ACTION" or (what == "BOTH" and not self._copies_motion)

    def _read_frames(self, rest: np.ndarray) -> Iterator[Step]:
        settings, from_ = self._settings, self.source
        numbers = source.frame_numbers(self._context.scene, from_, settings.frames, settings.step)
        reading = source.read_frames(self._context, from_, numbers, rest, settings.object_motion)
        try:
            for frames in reading:
                self._frames = frames
                done = len(frames.positions)
                yield Step(f"Reading frame {done} of {len(numbers)}", done / len(numbers))
        finally:
            # Brings back frame and modifiers, whatever happened.
            reading.close()
        if self._frames.switched_off:
            off = listed(self._frames.switched_off)
            self.messages.append(f"modifiers that add or remove vertices were off while frames were read: {off}")
        if self._frames.moves_as_object and not settings.object_motion:
            self.messages.append(f"{from_.name} also moves as an object, which was left out: Object Motion would include it")

    def compute(self, report: Callable[[Step], object]) -> None:
        """Transfers the poses; touches nothing of Blender. It ends where `report` raises."""
        parts = {"shapes": self._shapes}
        if self._frames is not None:
            parts["frames"] = {f"{n:+06d}": positions for n, positions in zip(self._frames.numbers, self._frames.positions)}
        parts = {kind: poses for kind, poses in parts.items() if poses}

        def progress(now: Any) -> None:
            report(Step(now.stage.replace("_", " ").capitalize() or "Starting", now.share or 0.0))

        with tempfile.TemporaryDirectory(prefix="mimesh-") as folder:
            markers = self._landmarks.write(folder) if self._landmarks else None
            for kind, poses in parts.items():
                self._results[kind] = self._mimesh.transfer(
                    self._source_mesh,
                    self._target_mesh,
                    poses={name: self._space.stretched(positions) for name, positions in poses.items()},
                    poses_are=kind,
                    markers=markers,
                    # Shapes and frames share the correspondence.
                    cache=f"{folder}/cache" if len(parts) > 1 else False,
                    progress=progress,
                    **self._arguments,
                )

    def write(self) -> str:
        """Writes the results and what is known of them; a summary in one line."""
        settings, to = self._settings, self.target
        if settings.on_copy:
            to = target.copy_of(self._context, to)
        writer = None
        try:
            if settings.on_copy:
                target.check(to)
            if len(to.data.vertices) != len(self._target_mesh.vertices):
                raise Refusal(f"{to.name} has changed meanwhile", "Transfer again")
            writer = target.Writer(to, settings.replace)
            names = {kind: self._write_part(writer, kind, result) for kind, result in self._results.items()}
        except BaseException:
            if writer is not None:
                writer.undo()
            if settings.on_copy:
                target.remove_copy(to)
            raise
        self.messages += writer.messages() + (self._landmarks.messages if self._landmarks else [])
        if animation.is_moved(to) and any(modifier.type == "ARMATURE" for modifier in to.modifiers):
            self.messages.append(f"the armature of {to.name} moves it too, beside what was transferred")
        written = outcome.store(settings.outcome, to, self._results, names, self.messages)
        points = f", by {counted(len(self._landmarks.names), 'landmark')}" if self._landmarks else ""
        return f"{counted(written, 'shape key')} from {self.source.name} on {to.name}{points}: {settings.outcome.verdict}"

    def _write_part(self, writer: target.Writer, kind: str, result: Any) -> dict[str, str]:
        """Writes all poses of a kind; the names of their shape keys."""
        action_name = animation.action_name(self.source)
        names = {}
        for pose, positions in zip(result.poses, result.positions):
            name = target.frame_key_name(action_name, int(pose)) if kind == "frames" else pose
            key = writer.write_shape(name, self._target_space.local(positions))
            names[pose] = key.name
            if kind == "shapes":
                self._copy_range(pose, key, is_new=key.name not in writer.replaced)
        new_action = f"{action_name} ({writer.obj.name})"
        if kind == "frames" and self._settings.result == "ACTION":
            numbers = [int(pose) for pose in names]
            action = writer.new_action(new_action)
            animation.play_frames(action, list(names.values()), numbers, self._settings.interpolation)
        elif kind == "shapes" and self._copies_motion:
            self._copy_motion(writer, names, new_action)
        return names

    def _copy_range(self, pose: str, key: Any, is_new: bool) -> None:
        """Copies slider and value of the source's key."""
        original = self.source.data.shape_keys.key_blocks[pose]
        if is_new:
            key.slider_min, key.slider_max, key.mute = original.slider_min, original.slider_max, original.mute
            # Where frames hold all of the motion, it must not count twice.
            key.value = 0.0 if self._frames is not None else original.value

    def _copy_motion(self, writer: target.Writer, names: dict[str, str], action: str) -> None:
        """Copies F-curves and drivers of the values of the source's keys."""
        keys = self.source.data.shape_keys
        curves = {curve.data_path: curve for curve in animation.curves_of(keys)}
        drivers = {curve.data_path: curve for curve in (keys.animation_data.drivers if keys.animation_data else ())}
        replaced = {self.source: writer.obj, keys: writer.keys, self.source.data: writer.obj.data}
        for pose, name in names.items():
            path = animation.value_path(pose)
            if path in curves:
                animation.copy_curve(curves[path], writer.new_action(action).curve(animation.value_path(name)))
            if path in drivers:
                writer.copy_driver(drivers[path], name, replaced)


def pair_of(context: Any, use_selection: bool = False) -> tuple[Any, Any]:
    """Source and target: as picked, else the active mesh is the target and the other selected one the source."""
    settings = context.scene.mimesh
    active = context.view_layer.objects.active
    selected = [obj for obj in context.view_layer.objects if obj.select_get() and obj.type == "MESH"]
    target_picked, source_picked = (None, None) if use_selection else (settings.target, settings.source)
    to = target_picked or (active if active and active.type == "MESH" and active != source_picked else None)
    others = [obj for obj in selected if obj not in (to, active)] or [obj for obj in selected if obj != to]
    from_ = source_picked or (others[0] if len(others) == 1 else None)
    if to is None or from_ is None:
        missing = "target" if to is None else "source"
        raise Refusal(f"there is no {missing}", "Pick it in the panel, or select the source first and then the target, two meshes in all")
    return from_, to


def check_pair(from_: Any, to: Any) -> None:
    """Refuses objects that are no pair, or being edited."""
    if from_ == to or from_.data == to.data:
        hint = "Choose two meshes, or make the data of one a single user"
        raise Refusal(f"source and target are the same mesh ({from_.data.name})", hint)
    for obj in (from_, to):
        if obj.mode == "EDIT":
            raise Refusal(f"{obj.name} is in edit mode", "Leave it with Tab")
