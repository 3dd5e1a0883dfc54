"""Actions: the target plays what mimesh gives for the evaluated source."""

import bpy
import numpy as np
import pytest
from conftest import add, add_mesh, animate_keys, evaluated, key_names, rig, shape, transfer

import mimesh
from mimesh_blender import animation
from mimesh_blender.source import rest_of


@pytest.fixture
def walker(scene, horse):
    """A horse with an armature that bends it."""
    obj = add_mesh("horse", horse)
    obj["armature"] = rig(obj)
    return obj


def near(mesh):
    """The tolerance of f32."""
    return 2e-6 * float(np.abs(mesh.vertices).max()) + 1e-7


def test_the_target_plays_what_mimesh_gives(scene, walker, horse, camel):
    target = add_mesh("camel", camel)
    frames = {f"{frame:+06d}": evaluated(walker, frame) for frame in range(1, 6)}
    assert np.abs(frames["+00005"] - horse.vertices).max() > 0.1
    rest = mimesh.Mesh(rest_of(walker), horse.faces)
    expected = mimesh.transfer(rest, mimesh.Mesh(rest_of(target), camel.faces), poses=frames, poses_are="frames")
    scene.frame_set(3)
    transfer(walker, target)
    assert scene.frame_current == 3
    assert key_names(target) == [f"rigAction.{frame:04d}" for frame in range(1, 6)]
    for frame in range(1, 6):
        np.testing.assert_allclose(evaluated(target, frame), expected.positions[frame - 1], atol=near(camel))
    # Between frames shapes are blended, before and after them the ends are held.
    scene.frame_set(2, subframe=0.5)
    np.testing.assert_allclose(evaluated(target), expected.positions[1:3].mean(axis=0), atol=2 * near(camel))
    np.testing.assert_allclose(evaluated(target, -7), expected.positions[0], atol=near(camel))
    np.testing.assert_allclose(evaluated(target, 99), expected.positions[4], atol=near(camel))


def test_constant_holds_each_frame(scene, walker, horse):
    target = add_mesh("copy", horse)
    transfer(walker, target, step=2, interpolation="CONSTANT")
    assert key_names(target) == ["rigAction.0001", "rigAction.0003", "rigAction.0005"]
    np.testing.assert_array_equal(evaluated(target, 4), evaluated(target, 3))
    np.testing.assert_allclose(evaluated(target, 3), evaluated(walker, 3), atol=1e-4)


def test_frames_of_the_scene_as_shape_keys_alone(scene, walker, horse):
    scene.frame_start, scene.frame_end = 4, 6
    target = add_mesh("copy", horse)
    transfer(walker, target, frames="SCENE", result="SHAPE_KEYS")
    assert key_names(target) == ["rigAction.0004", "rigAction.0005", "rigAction.0006"]
    assert target.data.shape_keys.animation_data is None
    np.testing.assert_array_equal(evaluated(target), rest_of(target))
    np.testing.assert_allclose(shape(target, "rigAction.0004"), evaluated(walker, 4), atol=1e-4)


def test_modifiers_that_make_vertices_are_off_meanwhile_and_on_again(scene, walker, horse):
    walker.modifiers.new("Smooth", "SUBSURF")
    off = walker.modifiers.new("Off", "SUBSURF")
    off.show_viewport = False
    target = add_mesh("copy", horse)
    transfer(walker, target)
    assert [modifier.show_viewport for modifier in walker.modifiers] == [True, True, False]
    assert any("Smooth" in message.text for message in scene.mimesh.outcome.messages)
    walker.modifiers["Smooth"].show_viewport = False
    np.testing.assert_allclose(evaluated(target, 5), evaluated(walker, 5), atol=1e-4)


def test_the_motion_of_the_object_is_said_and_can_be_included(scene, horse):
    source = add_mesh("horse", horse, with_poses=True)
    animate_keys(source, {"01": [(1, 0.0), (3, 1.0)]})
    for frame, x in ((1, 0.0), (3, 2.0)):
        source.location.x = x
        source.keyframe_insert("location", frame=frame)
    target = add_mesh("copy", horse)
    transfer(source, target, what="ACTION", on_copy=True)
    still = scene.mimesh.outcome.target
    assert any("Object Motion" in message.text for message in scene.mimesh.outcome.messages)
    np.testing.assert_allclose(evaluated(still, 3), horse.pose("01"), atol=1e-4)
    transfer(source, target, what="ACTION", object_motion=True, on_copy=False)
    np.testing.assert_allclose(evaluated(target, 3), horse.pose("01") + [2, 0, 0], atol=1e-4)


def test_shape_keys_and_an_armature_do_not_count_twice(scene, walker, horse):
    walker.shape_key_add(name="Basis", from_mix=False)
    walker.shape_key_add(name="up", from_mix=False).data.foreach_set("co", (horse.vertices + [0, 0, 1]).astype(np.float32).ravel())
    animate_keys(walker, {"up": [(1, 0.0), (5, 1.0)]})
    target = add_mesh("copy", horse)
    transfer(walker, target)
    names = key_names(target)
    assert names[0] == "up" and len(names) == 6
    for frame in (1, 3, 5):
        np.testing.assert_allclose(evaluated(target, frame), evaluated(walker, frame), atol=2e-4)


def test_the_action_before_is_kept(scene, walker, horse):
    target = add("copy", horse.vertices, horse.faces, {"mine": horse.vertices + [1, 0, 0]})
    animate_keys(target, {"mine": [(1, 0.0), (5, 1.0)]})
    old = target.data.shape_keys.animation_data.action
    transfer(walker, target)
    new = target.data.shape_keys.animation_data.action
    assert new != old and old.use_fake_user and new.name == "rigAction (copy)"
    assert any(old.name in message.text for message in scene.mimesh.outcome.messages)
    assert len(animation.curves_of(target.data.shape_keys)) == 5
    target.data.shape_keys.animation_data.action = old
    if hasattr(old, "slots"):
        target.data.shape_keys.animation_data.action_slot = old.slots[0]
    assert len(animation.curves_of(target.data.shape_keys)) == 1


def test_a_source_without_motion_is_refused(scene, horse):
    source, target = add_mesh("source", horse), add_mesh("target", horse)
    with pytest.raises(RuntimeError, match="source has neither shape keys nor an action\nHint: .*swapped"):
        transfer(source, target)


def test_a_hidden_source_is_refused(scene, walker, horse):
    target = add_mesh("copy", horse)
    walker.hide_set(True)
    with pytest.raises(RuntimeError, match="horse is hidden"):
        transfer(walker, target)


def test_nodes_that_make_vertices_are_off_meanwhile(scene, walker, horse):
    group = bpy.data.node_groups.new("double", "GeometryNodeTree")
    for direction in ("INPUT", "OUTPUT"):
        group.interface.new_socket("Geometry", in_out=direction, socket_type="NodeSocketGeometry")
    into, out = group.nodes.new("NodeGroupInput"), group.nodes.new("NodeGroupOutput")
    divide = group.nodes.new("GeometryNodeSubdivideMesh")
    group.links.new(into.outputs[0], divide.inputs[0])
    group.links.new(divide.outputs[0], out.inputs[0])
    walker.modifiers.new("Nodes", "NODES").node_group = group
    target = add_mesh("copy", horse)
    transfer(walker, target)
    assert walker.modifiers["Nodes"].show_viewport
    assert any("Nodes" in message.text for message in scene.mimesh.outcome.messages)


def test_strips_move_shape_keys_too(scene, horse):
    source, target = add_mesh("source", horse, with_poses=True), add_mesh("target", horse)
    animate_keys(source, {"01": [(1, 0.0), (3, 1.0)]})
    data = source.data.shape_keys.animation_data
    strip = data.nla_tracks.new().strips.new("strip", 1, data.action)
    if hasattr(strip, "action_slot"):
        strip.action_slot = data.action_slot
    data.action = None
    transfer(source, target)
    assert key_names(target) == [*horse.poses, "source.0001", "source.0002", "source.0003"]
    for frame in (1, 2, 3):
        np.testing.assert_allclose(evaluated(target, frame), evaluated(source, frame), atol=1e-4)
