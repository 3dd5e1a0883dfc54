"""The panel in the sidebar of the 3D view."""

from __future__ import annotations

from typing import Any

import bpy

from . import landmarks, runner
from .job import pair_of
from .messages import Refusal

_ICONS = {"good": "CHECKMARK", "doubtful": "QUESTION", "bad": "ERROR"}


class _Panel:
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "mimesh"


class VIEW3D_PT_mimesh(_Panel, bpy.types.Panel):
    bl_label = "Transfer Deformation"
    bl_idname = "VIEW3D_PT_mimesh"

    def draw(self, context: Any) -> None:
        layout, settings = self.layout, context.scene.mimesh
        layout.use_property_split = True
        layout.use_property_decorate = False
        row = layout.row(align=True)
        column = row.column(align=True)
        column.prop(settings, "source")
        column.prop(settings, "target")
        row.operator("mimesh.swap", text="", icon="FILE_REFRESH")
        try:
            source, target = pair_of(context)
        except Refusal as refusal:
            source = target = None
            layout.label(text=str(refusal.message).capitalize(), icon="INFO")
        else:
            layout.label(text=f"{source.name} moves {target.name}", icon="FORWARD")
        layout.prop(settings, "what")
        frames = layout.column()
        frames.active = settings.what != "SHAPE_KEYS"
        frames.prop(settings, "frames")
        frames.prop(settings, "step")
        frames.prop(settings, "result")
        layout.prop(settings, "landmarks")
        if settings.landmarks == "EMPTIES" and source is not None:
            pairs = landmarks.empties_of(context.scene, source, target).values()
            if pairs:
                complete = sum(len(ends) == 2 for ends in pairs)
                layout.label(text=f"{complete} complete pairs of {len(pairs)}", icon="EMPTY_AXIS")
            else:
                layout.operator("mimesh.find_landmarks", icon="EMPTY_AXIS")
        layout.prop(settings, "on_copy")
        if runner.running is None:
            layout.operator("mimesh.transfer", icon="PLAY")
        else:
            layout.progress(factor=runner.running.share, text=runner.running.label)
            layout.label(text="Escape cancels")


class VIEW3D_PT_mimesh_advanced(_Panel, bpy.types.Panel):
    bl_label = "Advanced"
    bl_idname = "VIEW3D_PT_mimesh_advanced"
    bl_parent_id = "VIEW3D_PT_mimesh"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: Any) -> None:
        layout, settings = self.layout, context.scene.mimesh
        layout.use_property_split = True
        layout.use_property_decorate = False
        for name in ("method", "replace", "interpolation", "object_motion", "threads"):
            layout.prop(settings, name)


class VIEW3D_PT_mimesh_outcome(_Panel, bpy.types.Panel):
    bl_label = "Last Result"
    bl_idname = "VIEW3D_PT_mimesh_outcome"
    bl_parent_id = "VIEW3D_PT_mimesh"

    @classmethod
    def poll(cls, context: Any) -> bool:
        return bool(context.scene.mimesh.outcome.verdict)

    def draw(self, context: Any) -> None:
        layout, outcome = self.layout, context.scene.mimesh.outcome
        name = outcome.target.name if outcome.target else "a deleted object"
        layout.label(text=f"{name}: {outcome.verdict}", icon=_ICONS.get(outcome.verdict, "INFO"))
        layout.label(text=outcome.summary)
        for index, pose in enumerate(outcome.worst):
            text = f"Frame {pose.frame}" if pose.is_frame else pose.key
            row = layout.row()
            row.operator("mimesh.show_pose", text=text, icon=_ICONS.get(pose.level, "INFO")).index = index
            row.label(text=pose.reason)
        for message in outcome.messages:
            layout.label(text=message.text, icon="INFO")


_CLASSES = (VIEW3D_PT_mimesh, VIEW3D_PT_mimesh_advanced, VIEW3D_PT_mimesh_outcome)


def register() -> None:
    for one in _CLASSES:
        bpy.utils.register_class(one)


def unregister() -> None:
    for one in reversed(_CLASSES):
        bpy.utils.unregister_class(one)
