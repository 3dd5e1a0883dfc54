"""Operators, the panel, errors, and what is left when something goes wrong."""

import time
from types import SimpleNamespace

import bpy
import numpy as np
import pytest
from conftest import add, add_mesh, choose, evaluated, key_names, rig, transfer

import mimesh
import mimesh_blender
from mimesh_blender import operators, panel, runner, target
from mimesh_blender.job import Job, pair_of
from mimesh_blender.messages import Cancelled, Refusal, text_of


def ours() -> set:
    """What is registered under our names."""
    types = {name for name in dir(bpy.types) if "mimesh" in name.lower()}
    menu = {function.__module__ for function in bpy.types.VIEW3D_MT_object._dyn_ui_initialize() if "mimesh" in function.__module__}
    return types | menu | ({"scene"} if hasattr(bpy.types.Scene, "mimesh") else set()) | set(dir(bpy.ops.mimesh))


def test_unregister_leaves_nothing(registered):
    assert {"MIMESH_OT_transfer", "VIEW3D_PT_mimesh", "scene", "transfer"} <= ours()
    mimesh_blender.unregister()
    try:
        assert ours() == set()
    finally:
        mimesh_blender.register()


def test_the_active_mesh_is_the_target_and_the_other_selected_one_the_source(scene, horse):
    source, target_object = add_mesh("source", horse, with_poses=True), add_mesh("target", horse)
    for obj in (source, target_object):
        obj.select_set(True)
    bpy.context.view_layer.objects.active = target_object
    assert pair_of(bpy.context) == (source, target_object)
    # What is picked in the panel counts more, unless the menu asks for the selection.
    choose(target_object, source)
    assert pair_of(bpy.context) == (target_object, source)
    assert bpy.ops.mimesh.transfer(use_selection=True) == {"FINISHED"}
    assert key_names(target_object) == list(horse.poses)
    bpy.ops.mimesh.swap()
    assert (scene.mimesh.source, scene.mimesh.target) == (source, target_object)


def test_without_a_pair_it_says_what_is_missing(scene, horse):
    with pytest.raises(RuntimeError, match="there is no target\nHint: "):
        bpy.ops.mimesh.transfer()
    obj = add_mesh("only", horse)
    with pytest.raises(RuntimeError, match="there is no source"):
        transfer(None, obj)
    with pytest.raises(RuntimeError, match="source and target are the same mesh"):
        transfer(obj, obj)


def test_errors_of_mimesh_are_one_text_with_the_way_out(scene, horse):
    source = add_mesh("source", horse, with_poses=True)
    flat = add("flat", np.zeros((4, 3)), [[0, 1, 2], [0, 2, 3]])
    with pytest.raises(RuntimeError) as refused:
        transfer(source, flat)
    assert "Hint: " in str(refused.value) and "Traceback" not in str(refused.value)
    assert flat.data.shape_keys is None
    two = tuple(mimesh.Diagnostic("usage", message, "do") for message in ("one", "two"))
    assert text_of(mimesh.Error("", two)) == "one\nHint: do\ntwo\nHint: do"


def test_a_mesh_without_faces_is_refused(scene, horse):
    source, points = add_mesh("source", horse, with_poses=True), add("points", horse.vertices, [])
    with pytest.raises(RuntimeError, match="points has no faces"):
        transfer(source, points)


def test_absolute_keys_of_the_target_are_refused(scene, horse):
    source, obj = add_mesh("source", horse, with_poses=True), add("target", horse.vertices, horse.faces, {"x": horse.vertices})
    obj.data.shape_keys.use_relative = False
    with pytest.raises(RuntimeError, match="absolute\nHint: Turn on Relative"):
        transfer(source, obj)


@pytest.mark.parametrize("on_copy", [False, True])
def test_nothing_half_written_is_left(scene, horse, monkeypatch, on_copy):
    source, plain = add_mesh("source", horse), add_mesh("plain", horse)
    rig(source)
    kept = add("kept", horse.vertices, horse.faces, {"rigAction.0001": horse.vertices + [0, 0, 1]})
    kept.data.shape_keys.key_blocks["rigAction.0001"].value = 0.5
    kept.data.shape_keys.key_blocks["rigAction.0001"].keyframe_insert("value", frame=1)
    action = kept.data.shape_keys.animation_data.action
    before = {name: len(getattr(bpy.data, name)) for name in ("actions", "meshes", "objects", "shape_keys")}

    def fail(*_):
        raise MemoryError("the disk fell off")

    monkeypatch.setattr(target.animation, "play_frames", fail)
    for obj in (plain, kept):
        with pytest.raises(RuntimeError, match="the disk fell off"):
            transfer(source, obj, replace=True, on_copy=on_copy)
    assert plain.data.shape_keys is None
    assert key_names(kept) == ["rigAction.0001"] and kept.data.shape_keys.animation_data.action == action
    assert not action.use_fake_user
    np.testing.assert_allclose(evaluated(kept, 1), horse.vertices + [0, 0, 0.5], atol=1e-5)
    assert {name: len(getattr(bpy.data, name)) for name in before} == before


def run(job: Job, until=lambda: False) -> runner.Runner:
    """Runs a job as the window does."""
    made = runner.Runner(job)
    end = time.monotonic() + 60
    while not until() and not made.advance():
        assert time.monotonic() < end
        time.sleep(0.001)
    return made


def test_beside_the_window_the_result_is_the_same(scene, horse, camel):
    source, one, two = add_mesh("source", horse), add_mesh("one", camel), add_mesh("two", camel)
    rig(source)
    choose(source, one)
    made = run(Job(bpy.context))
    assert key_names(one) == []
    made.job.write()
    made.stop()
    assert runner.running is None
    transfer(source, two)
    for frame in (1, 4):
        np.testing.assert_array_equal(evaluated(one, frame), evaluated(two, frame))


def test_cancelled_while_frames_are_read(scene, horse):
    source, obj = add_mesh("source", horse), add_mesh("target", horse)
    rig(source, last=2000)
    source.modifiers.new("Smooth", "SUBSURF")
    choose(source, obj)
    scene.frame_set(7)
    made = run(Job(bpy.context), until=lambda: "frame" in runner.running.label)
    assert not source.modifiers["Smooth"].show_viewport
    made.stop()
    assert source.modifiers["Smooth"].show_viewport and scene.frame_current == 7
    assert obj.data.shape_keys is None and runner.running is None


def test_cancelled_while_it_computes(scene):
    animals = [mimesh.generators.Quadruped(proportions=p, frames=12, resolution=50).generate() for p in ("horse", "camel")]
    source, obj = add_mesh("source", animals[0], with_poses=True), add_mesh("target", animals[1])
    choose(source, obj)
    made = run(Job(bpy.context), until=lambda: runner.running.label not in ("Reading", "Reading meshes"))
    assert made._thread.is_alive()
    made.stop()
    made._thread.join(30)
    assert not made._thread.is_alive() and isinstance(made._error, Cancelled)
    assert obj.data.shape_keys is None and runner.running is None


class Window:
    """What the operator uses of a window, and its own `self`."""

    def __init__(self, job):
        self.reports, self.calls = [], []
        self.self = type("Self", (), dict(operators.MIMESH_OT_transfer.__dict__))()
        self.self._runner, self.self._timer = runner.Runner(job), "timer"
        self.self.report = lambda kind, text: self.reports.append((*kind, text))
        self.context = SimpleNamespace(window_manager=self, workspace=self, screen=None)

    def event(self, kind, value="NOTHING"):
        return self.self.modal(self.context, SimpleNamespace(type=kind, value=value))

    def __getattr__(self, name):
        return lambda *arguments: self.calls.append((name, *arguments))


def test_a_window_is_served_and_tidied(scene, horse):
    source, obj = add_mesh("source", horse, with_poses=True), add_mesh("target", horse)
    choose(source, obj)
    window = Window(Job(bpy.context))
    assert window.event("A", "PRESS") == {"RUNNING_MODAL"} and window.event("MIDDLEMOUSE") == {"PASS_THROUGH"}
    while (result := window.event("TIMER")) == {"RUNNING_MODAL"}:
        time.sleep(0.01)
    assert result == {"FINISHED"} and key_names(obj) == list(horse.poses)
    assert any(call[0] == "status_text_set" and "Escape" in call[1] for call in window.calls[:-3])
    tidied = [("event_timer_remove", "timer"), ("progress_end",), ("status_text_set", None)]
    assert window.calls[-3:] == tidied and window.reports[-1][0] == "INFO"

    window = Window(Job(bpy.context))
    window.event("TIMER")
    assert window.event("ESC", "PRESS") == {"CANCELLED"}
    assert window.calls[-3:] == tidied and window.reports == [("INFO", "Cancelled: nothing was changed")]
    assert key_names(obj) == list(horse.poses) and runner.running is None

    scene.mimesh.landmarks = "EMPTIES"
    window = Window(Job(bpy.context))
    assert window.event("TIMER") == {"CANCELLED"}
    assert window.calls[-3:] == tidied and window.reports[0][0] == "ERROR" and "no empties" in window.reports[0][1]


def test_faults_of_the_thread_are_raised(scene, horse):
    source, obj = add_mesh("source", horse, with_poses=True), add("flat", np.zeros((4, 3)), [[0, 1, 2], [0, 2, 3]])
    choose(source, obj)
    with pytest.raises(mimesh.Error):
        run(Job(bpy.context))
    runner.running = None


def test_a_target_that_has_changed_meanwhile_is_refused(scene, horse):
    source, obj = add_mesh("source", horse, with_poses=True), add_mesh("target", horse)
    choose(source, obj)
    made = run(Job(bpy.context))
    obj.data.clear_geometry()
    with pytest.raises(Refusal, match="target has changed meanwhile"):
        made.job.write()
    made.stop()


def test_undo_is_one_step(scene, horse):
    source, obj = add_mesh("source", horse, with_poses=True), add_mesh("target", horse)
    choose(source, obj)
    bpy.ops.ed.undo_push(message="before")
    bpy.ops.mimesh.transfer("EXEC_DEFAULT", True)
    assert key_names(bpy.data.objects["target"])
    bpy.ops.ed.undo()
    assert bpy.data.objects["target"].data.shape_keys is None
    assert not bpy.context.scene.mimesh.outcome.verdict


def test_the_worst_frames_can_be_shown(scene, horse, camel):
    source, obj = add_mesh("source", horse), add_mesh("target", camel)
    rig(source, bones=2, last=6)
    transfer(source, obj)
    outcome = scene.mimesh.outcome
    # Whatever the verdict is, rows lead to their frames.
    row = outcome.worst.add()
    row.key, row.is_frame, row.frame, row.level = "rigAction.0004", True, 4, "doubtful"
    last = len(outcome.worst) - 1
    bpy.ops.mimesh.show_pose(index=last)
    assert scene.frame_current == 4 and obj.active_shape_key.name == "rigAction.0004"
    row.key = "gone"
    with pytest.raises(RuntimeError, match="The shape key gone is gone"):
        bpy.ops.mimesh.show_pose(index=last)


def test_settings_and_outcome_are_saved(scene, horse, tmp_path):
    source, obj = add_mesh("source", horse, with_poses=True), add_mesh("target", horse)
    transfer(source, obj, landmarks="AUTO", step=3)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "file.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "file.blend"))
    read = bpy.context.scene.mimesh
    assert (read.step, read.outcome.verdict, read.outcome.target.name) == (3, "good", "target")


class Layout:
    """Records what a panel draws, and holds it to what exists."""

    def __init__(self, lines):
        self.lines = lines

    def row(self, **_):
        return Layout(self.lines)

    column = row

    def prop(self, data, name, **_):
        assert name in data.bl_rna.properties
        self.lines.append(name)

    def label(self, text="", icon="NONE"):
        assert icon in bpy.types.UILayout.bl_rna.functions["label"].parameters["icon"].enum_items
        self.lines.append(text)

    def operator(self, name, text="", icon="NONE"):
        assert icon in bpy.types.UILayout.bl_rna.functions["label"].parameters["icon"].enum_items
        group, _, function = name.partition(".")
        assert hasattr(getattr(bpy.ops, group), function)
        self.lines.append(text or name)
        return Layout(self.lines)

    def progress(self, factor, text):
        assert 0 <= factor <= 1
        self.lines.append(text)


def test_panels_draw(scene, horse):
    def drawn(kind):
        lines = []
        made = type("Drawn", (), {"layout": Layout(lines)})()
        kind.draw(made, bpy.context)
        return lines

    assert "There is no target" in drawn(panel.VIEW3D_PT_mimesh)
    source, obj = add_mesh("source", horse, with_poses=True), add_mesh("target", horse)
    choose(source, obj, landmarks="EMPTIES")
    lines = drawn(panel.VIEW3D_PT_mimesh)
    assert {"source moves target", "mimesh.find_landmarks", "mimesh.transfer"} <= set(lines)
    bpy.context.scene.collection.objects.link(bpy.data.objects.new("nose.source", None))
    assert "0 complete pairs of 1" in drawn(panel.VIEW3D_PT_mimesh)
    assert not panel.VIEW3D_PT_mimesh_outcome.poll(bpy.context)
    transfer(source, obj, landmarks="AUTO")
    assert panel.VIEW3D_PT_mimesh_outcome.poll(bpy.context)
    assert "target: good" in drawn(panel.VIEW3D_PT_mimesh_outcome)
    assert "method" in drawn(panel.VIEW3D_PT_mimesh_advanced)
    runner.running = runner.Step("Poses", 0.5)
    try:
        assert "Poses" in drawn(panel.VIEW3D_PT_mimesh)
        assert not bpy.ops.mimesh.transfer.poll()
    finally:
        runner.running = None
