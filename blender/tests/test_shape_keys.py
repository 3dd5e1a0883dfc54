"""Shape keys: names, positions, what is there already."""

import bpy
import numpy as np
import pytest
from conftest import add, add_mesh, animate_keys, evaluated, key_names, shape, transfer

from mimesh_blender.source import rest_of


def size(mesh) -> float:
    return float(np.linalg.norm(np.ptp(mesh.vertices, axis=0)))


def test_a_copy_takes_the_same_shapes(scene, horse):
    source, target = add_mesh("source", horse, with_poses=True), add_mesh("target", horse)
    assert transfer(source, target) == {"FINISHED"}
    assert key_names(target) == list(horse.poses)
    for name in horse.poses:
        # f32 and the solver's tolerance.
        np.testing.assert_allclose(shape(target, name), horse.pose(name), atol=1e-5 * size(horse))
    np.testing.assert_array_equal(rest_of(target), rest_of(source))
    assert scene.mimesh.outcome.verdict == "good"


def test_a_turned_copy_takes_turned_shapes(scene, horse):
    angle = 0.7
    turn = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
    source = add_mesh("source", horse, with_poses=True)
    target = add("target", 3 * horse.vertices @ turn.T + [5, 1, 2], horse.faces)
    transfer(source, target, method="gradient")
    for name in horse.poses:
        expected = 3 * horse.pose(name) @ turn.T + [5, 1, 2]
        np.testing.assert_allclose(shape(target, name), expected, atol=3e-3 * size(horse))


def test_how_objects_stand_and_are_scaled_changes_nothing(scene, horse, camel):
    source, target = add_mesh("source", horse, with_poses=True), add_mesh("target", camel)
    transfer(source, target)
    expected = [shape(target, name) for name in horse.poses]
    target.shape_key_clear()
    source.location, source.rotation_euler, source.scale = (4, 5, 6), (1, 2, 3), (0.01, 0.01, 0.01)
    target.rotation_euler = (0, 0, 1)
    bpy.context.view_layer.update()
    transfer(source, target)
    for name, positions in zip(horse.poses, expected):
        np.testing.assert_array_equal(shape(target, name), positions)


def test_a_mesh_under_an_uneven_scale_is_taken_as_it_looks(scene, horse):
    scale = np.array([2.0, 0.5, 1.0])
    source = add("source", horse.vertices / scale, horse.faces, {name: horse.pose(name) / scale for name in horse.poses})
    source.scale = scale
    target = add_mesh("target", horse)
    bpy.context.view_layer.update()
    transfer(source, target)
    for name in horse.poses:
        np.testing.assert_allclose(shape(target, name), horse.pose(name), atol=1e-5 * size(horse))
    # And the other way round.
    source.shape_key_clear()
    transfer(target, source)
    for name in horse.poses:
        np.testing.assert_allclose(shape(source, name) * scale, horse.pose(name), atol=2e-5 * size(horse))


def test_a_scale_of_nothing_is_refused(scene, horse):
    source, target = add_mesh("source", horse, with_poses=True), add_mesh("target", horse)
    target.scale = (1, 0, 1)
    bpy.context.view_layer.update()
    with pytest.raises(RuntimeError, match="target is scaled to nothing on an axis\nHint: "):
        transfer(source, target)
    assert target.data.shape_keys is None


def test_polygons_of_any_size_are_taken(scene):
    # A hexagonal prism: two n-gons and six quads.
    turns = np.arange(6) * np.pi / 3
    ring = np.column_stack([np.cos(turns), np.sin(turns)])
    vertices = np.concatenate([np.column_stack([ring, np.full(6, z)]) for z in (0.0, 2.0)])
    faces = [list(range(5, -1, -1)), list(range(6, 12))] + [[i, (i + 1) % 6, 6 + (i + 1) % 6, 6 + i] for i in range(6)]
    tall = vertices * [1, 1, 1.5]
    source, target = add("source", vertices, faces, {"tall": tall}), add("target", vertices + [3, 0, 0], faces)
    transfer(source, target)
    assert [len(polygon.vertices) for polygon in target.data.polygons] == [len(face) for face in faces]
    heights = np.ptp(shape(target, "tall"), axis=0)
    np.testing.assert_allclose(heights, [2, np.sqrt(3), 3], rtol=1e-4)


def test_loose_vertices_are_kept_and_follow(scene, horse):
    source = add_mesh("source", horse, with_poses=True)
    target = add("target", np.concatenate([horse.vertices, horse.vertices[:1]]), horse.faces)
    transfer(source, target)
    expected = np.concatenate([horse.pose("01"), horse.pose("01")[:1]])
    np.testing.assert_allclose(shape(target, "01"), expected, atol=1e-5 * size(horse))


def test_keys_that_are_there_are_kept_unless_replaced(scene, horse):
    source = add_mesh("source", horse, with_poses=True)
    target = add("target", horse.vertices, horse.faces, {"01": horse.vertices + [0, 0, 1], "mine": horse.vertices + [1, 0, 0]})
    target.data.shape_keys.key_blocks["01"].driver_add("value")
    transfer(source, target)
    assert key_names(target) == ["01", "mine", "01.001", "02", "03", "04"]
    np.testing.assert_allclose(shape(target, "01"), horse.vertices + [0, 0, 1], atol=1e-5)
    assert any("01 is 01.001" in message.text for message in scene.mimesh.outcome.messages)
    target.shape_key_remove(target.data.shape_keys.key_blocks["01.001"])
    transfer(source, target, replace=True)
    assert key_names(target) == ["01", "mine", "02", "03", "04"]
    np.testing.assert_allclose(shape(target, "01"), horse.pose("01"), atol=1e-5 * size(horse))
    np.testing.assert_allclose(shape(target, "mine"), horse.vertices + [1, 0, 0], atol=1e-5)
    assert len(target.data.shape_keys.animation_data.drivers) == 1


def test_a_key_relative_to_another_gives_its_own_difference(scene, horse):
    base, more = horse.vertices + [0, 0, 1], horse.pose("01") + [0, 0, 1]
    source = add("source", horse.vertices, horse.faces, {"base": base, "more": more})
    blocks = source.data.shape_keys.key_blocks
    blocks["more"].relative_key = blocks["base"]
    target = add_mesh("target", horse)
    transfer(source, target)
    np.testing.assert_allclose(shape(target, "more"), horse.pose("01"), atol=1e-5 * size(horse))


def test_a_vertex_group_limits_a_key(scene, horse):
    source, target = add_mesh("source", horse, with_poses=True), add_mesh("target", horse)
    half = source.vertex_groups.new(name="half")
    half.add(list(range(len(horse.vertices))), 0.5, "REPLACE")
    source.data.shape_keys.key_blocks["01"].vertex_group = "half"
    transfer(source, target, method="copy_displacement")
    expected = horse.vertices + 0.5 * (horse.pose("01") - horse.vertices)
    np.testing.assert_allclose(shape(target, "01"), expected, atol=1e-5 * size(horse))


def test_sliders_curves_and_drivers_come_along(scene, horse):
    source, target = add_mesh("source", horse, with_poses=True), add_mesh("target", horse)
    blocks = source.data.shape_keys.key_blocks
    blocks["02"].slider_min, blocks["02"].slider_max = -1.0, 2.0
    animate_keys(source, {"01": [(1, 0.0), (10, 1.0)], "02": [(1, 0.5), (10, -0.5)]})
    source["smile"] = 0.25
    variable = (driver := blocks["03"].driver_add("value").driver).variables.new()
    driver.type, variable.name = "SUM", "smile"
    variable.targets[0].id, variable.targets[0].data_path = source, '["smile"]'
    target["smile"] = 0.75
    old = bpy.data.actions.new("old")
    target.shape_key_add(name="Basis", from_mix=False)
    target.data.shape_keys.animation_data_create().action = old
    transfer(source, target)
    new = target.data.shape_keys.key_blocks
    assert (new["02"].slider_min, new["02"].slider_max) == (-1.0, 2.0)
    for frame in (1, 4, 10):
        evaluated(target, frame)
        for name in ("01", "02"):
            assert new[name].value == pytest.approx(blocks[name].value, abs=1e-6)
    assert (blocks["03"].value, new["03"].value) == (pytest.approx(0.25), pytest.approx(0.75))
    np.testing.assert_allclose(evaluated(target, 4) - evaluated(source, 4), 0.5 * (horse.pose("03") - horse.vertices), atol=1e-4)
    names = [obj.data.shape_keys.animation_data.action.name for obj in (source, target)]
    assert old.use_fake_user and names[1] == f"{names[0]} (target)"


def test_a_copy_of_the_target_leaves_it_alone(scene, horse):
    source, target = add_mesh("source", horse, with_poses=True), add_mesh("target", horse)
    transfer(source, target, on_copy=True)
    assert target.data.shape_keys is None
    made = scene.mimesh.outcome.target
    assert made != target and made.data != target.data and key_names(made) == list(horse.poses)


def test_half_a_mesh_is_said(scene, horse):
    source, target = add_mesh("source", horse, with_poses=True), add_mesh("target", horse)
    target.modifiers.new("Mirror", "MIRROR")
    transfer(source, target)
    assert [message.text.split(",")[0] for message in scene.mimesh.outcome.messages] == ["target is mirrored by a modifier"]
