"""The operators: transfer, swap, find landmarks, and show a pose."""

import traceback
from typing import Any

import bpy
from bpy.props import BoolProperty, IntProperty

from . import proposals, runner
from .job import Job, check_pair, pair_of
from .messages import Cancelled, Refusal, counted, text_of

# How often a running transfer looks for news, in seconds.
_TICK = 0.1
_NAVIGATION = {"MIDDLEMOUSE", "WHEELUPMOUSE", "WHEELDOWNMOUSE", "MOUSEMOVE", "TRACKPADPAN", "TRACKPADZOOM", "MOUSEROTATE", "NDOF_MOTION"}


def refuse(operator: bpy.types.Operator, error: Exception) -> set[str]:
    """Reports an error as one text, and ends the operator."""
    if isinstance(error, Cancelled):
        operator.report({"INFO"}, "Cancelled: nothing was changed")
    else:
        if not isinstance(error, Refusal) and not getattr(error, "diagnostics", None):
            # A fault of ours: the console has where it is.
            traceback.print_exception(error)
        operator.report({"ERROR"}, text_of(error))
    return {"CANCELLED"}


class MIMESH_OT_transfer(bpy.types.Operator):
    """Transfer shape keys or the action of the source to the target. Escape cancels"""

    bl_idname = "mimesh.transfer"
    bl_label = "Transfer Deformation"
    bl_options = {"REGISTER", "UNDO"}

    use_selection: BoolProperty(
        name="By Selection",
        description="Take the active mesh as target and the other selected one as source, whatever the panel says",
        options={"SKIP_SAVE", "HIDDEN"},
    )

    @classmethod
    def poll(cls, context: Any) -> bool:
        if runner.running is not None:
            cls.poll_message_set("A transfer is running")
            return False
        if context.mode != "OBJECT":
            cls.poll_message_set("Only in object mode")
            return False
        return True

    def execute(self, context: Any) -> set[str]:
        """Does all of it before it returns."""
        manager = context.window_manager
        manager.progress_begin(0, 100)
        try:
            job = Job(context, self.use_selection)
            for step in job.read():
                manager.progress_update(100 * step.share)
            job.compute(lambda step: manager.progress_update(100 * step.share))
            return self._finish(job)
        except Exception as error:
            return refuse(self, error)
        finally:
            manager.progress_end()

    def invoke(self, context: Any, _event: Any) -> set[str]:
        """Runs beside the window, if there is one."""
        if bpy.app.background or context.window is None:
            return self.execute(context)
        try:
            self._runner = runner.Runner(Job(context, self.use_selection))
        except Exception as error:
            return refuse(self, error)
        manager = context.window_manager
        self._timer = manager.event_timer_add(_TICK, window=context.window)
        manager.progress_begin(0, 100)
        manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: Any, event: Any) -> set[str]:
        """Reads a few frames, or looks after the thread."""
        if event.type == "ESC" and event.value == "PRESS":
            return self._end(context, refuse(self, Cancelled()))
        if event.type != "TIMER":
            # Edits meanwhile would pull the meshes away under the transfer; looking around is fine.
            return {"PASS_THROUGH"} if event.type in _NAVIGATION else {"RUNNING_MODAL"}
        try:
            if not self._runner.advance():
                self._show(context)
                return {"RUNNING_MODAL"}
            return self._end(context, self._finish(self._runner.job))
        except Exception as error:
            return self._end(context, refuse(self, error))

    def cancel(self, context: Any) -> None:
        """Blender ends the operator, e.g. since a file is loaded."""
        self._end(context, set())

    def _show(self, context: Any) -> None:
        if (step := runner.running) is None:
            return
        context.window_manager.progress_update(100 * step.share)
        context.workspace.status_text_set(f"mimesh: {step.label} ({step.share:.0%})   Escape: cancel")
        for area in context.screen.areas if context.screen else ():
            if area.type == "VIEW_3D":
                area.tag_redraw()

    def _end(self, context: Any, result: set[str]) -> set[str]:
        """Leaves no timer and no text behind."""
        self._runner.stop()
        manager = context.window_manager
        manager.event_timer_remove(self._timer)
        manager.progress_end()
        context.workspace.status_text_set(None)
        return result

    def _finish(self, job: Job) -> set[str]:
        summary = job.write()
        for text in job.messages:
            self.report({"WARNING"}, text)
        self.report({"INFO"}, summary)
        return {"FINISHED"}


class MIMESH_OT_swap(bpy.types.Operator):
    """Exchange source and target"""

    bl_idname = "mimesh.swap"
    bl_label = "Swap Source and Target"
    bl_options = {"REGISTER", "UNDO", "INTERNAL"}

    def execute(self, context: Any) -> set[str]:
        settings = context.scene.mimesh
        settings.source, settings.target = settings.target, settings.source
        return {"FINISHED"}


class MIMESH_OT_find_landmarks(bpy.types.Operator):
    """Find points that correspond by shape, and set an empty at each, to be corrected"""

    bl_idname = "mimesh.find_landmarks"
    bl_label = "Find Landmarks"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: Any) -> bool:
        return context.mode == "OBJECT" and runner.running is None

    def execute(self, context: Any) -> set[str]:
        try:
            source, target = pair_of(context)
            check_pair(source, target)
            count, least_sure = proposals.place(context, source, target)
        except Exception as error:
            return refuse(self, error)
        context.scene.mimesh.landmarks = "EMPTIES"
        self.report({"INFO"}, f"{counted(count, 'pair')} of empties; the least sure is {least_sure}")
        return {"FINISHED"}


class MIMESH_OT_show_pose(bpy.types.Operator):
    """Go to this pose: its frame, or its shape key"""

    bl_idname = "mimesh.show_pose"
    bl_label = "Show Pose"
    bl_options = {"REGISTER", "UNDO", "INTERNAL"}

    index: IntProperty(min=0)

    def execute(self, context: Any) -> set[str]:
        outcome = context.scene.mimesh.outcome
        if self.index >= len(outcome.worst):
            self.report({"ERROR"}, f"There is no pose {self.index}")
            return {"CANCELLED"}
        pose, obj = outcome.worst[self.index], outcome.target
        keys = obj.data.shape_keys if obj else None
        position = keys.key_blocks.find(pose.key) if keys else -1
        if position < 0:
            self.report({"ERROR"}, f"The shape key {pose.key} is gone")
            return {"CANCELLED"}
        obj.active_shape_key_index = position
        if pose.is_frame:
            context.scene.frame_set(pose.frame)
        return {"FINISHED"}


def _draw_menu(menu: Any, _context: Any) -> None:
    menu.layout.separator()
    menu.layout.operator(MIMESH_OT_transfer.bl_idname, icon="MOD_MESHDEFORM").use_selection = True


_CLASSES = (MIMESH_OT_transfer, MIMESH_OT_swap, MIMESH_OT_find_landmarks, MIMESH_OT_show_pose)


def register() -> None:
    for one in _CLASSES:
        bpy.utils.register_class(one)
    bpy.types.VIEW3D_MT_object.append(_draw_menu)


def unregister() -> None:
    bpy.types.VIEW3D_MT_object.remove(_draw_menu)
    for one in reversed(_CLASSES):
        bpy.utils.unregister_class(one)
