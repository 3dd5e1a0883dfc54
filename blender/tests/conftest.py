"""Objects that tests share: animals of mimesh's generator, in a scene without anything else."""

import os
import sys
from pathlib import Path

import bpy
import numpy as np
import pytest

import mimesh

BLENDER = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(BLENDER))

import mimesh_blender  # noqa: E402
from mimesh_blender import source  # noqa: E402


def pytest_sessionfinish(session, exitstatus):
    session.config.mimesh_status = int(exitstatus)


def pytest_unconfigure(config):
    # Blender as a module may crash or hang while Python ends, after classes were registered.
    sys.stdout.flush()
    os._exit(getattr(config, "mimesh_status", 1))


@pytest.fixture(scope="session")
def registered():
    mimesh_blender.register()
    yield
    mimesh_blender.unregister()


@pytest.fixture
def scene(registered):
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    return bpy.context.scene


@pytest.fixture(scope="session")
def horse() -> mimesh.Mesh:
    return upright(mimesh.generators.Quadruped(proportions="horse", frames=4, resolution=20).generate())


@pytest.fixture(scope="session")
def camel() -> mimesh.Mesh:
    return upright(mimesh.generators.Quadruped(proportions="camel", frames=4, resolution=24, seed=1).generate())


def upright(mesh: mimesh.Mesh) -> mimesh.Mesh:
    """A mesh whose Y is up, with Z up as in Blender; names of its points are dropped."""
    turn = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])
    poses = {name: mesh.pose(name) @ turn.T for name in mesh.poses}
    return mimesh.Mesh(mesh.vertices @ turn.T, mesh.faces, poses)


def add(name: str, vertices, faces, poses=None):
    """An object, with poses as shape keys."""
    data = bpy.data.meshes.new(name)
    data.from_pydata(np.asarray(vertices).tolist(), [], [list(map(int, face)) for face in faces])
    obj = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(obj)
    if poses:
        obj.shape_key_add(name="Basis", from_mix=False)
        for key, positions in poses.items():
            block = obj.shape_key_add(name=key, from_mix=False)
            block.data.foreach_set("co", np.asarray(positions, dtype=np.float32).reshape(-1))
            # Blender 5 begins with 1.
            block.value = 0.0
    return obj


def add_mesh(name: str, mesh: mimesh.Mesh, with_poses: bool = False):
    """An object of a mesh."""
    return add(name, mesh.vertices, mesh.faces, {key: mesh.pose(key) for key in mesh.poses} if with_poses else None)


def choose(source, target, **settings):
    """Sets the panel."""
    chosen = bpy.context.scene.mimesh
    chosen.source, chosen.target = source, target
    for name, value in settings.items():
        setattr(chosen, name, value)


def transfer(source, target, **settings) -> set:
    """Transfers as a script does."""
    choose(source, target, **settings)
    return bpy.ops.mimesh.transfer()


def shape(obj, key: str) -> np.ndarray:
    """The positions that a shape key holds."""
    return source.coordinates(obj.data.shape_keys.key_blocks[key].data)


def evaluated(obj, frame=None) -> np.ndarray:
    """The positions that Blender shows."""
    if frame is not None:
        bpy.context.scene.frame_set(frame)
    bpy.context.view_layer.update()
    return source.coordinates(obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).data.vertices)


def key_names(obj) -> list:
    """The names of shape keys, without the first."""
    keys = obj.data.shape_keys
    return [key.name for key in keys.key_blocks][1:] if keys else []


def animate_keys(obj, frames: dict) -> None:
    """Keyframes of shape keys: for each key pairs of frame and value."""
    for key, points in frames.items():
        block = obj.data.shape_keys.key_blocks[key]
        for frame, value in points:
            block.value = value
            block.keyframe_insert("value", frame=frame)


def rig(obj, bones: int = 3, first: int = 1, last: int = 5):
    """An armature that bends an object along Y from frame to frame, with an action."""
    data = bpy.data.armatures.new("rig")
    armature = bpy.data.objects.new("rig", data)
    bpy.context.scene.collection.objects.link(armature)
    bpy.context.view_layer.objects.active = armature
    bpy.ops.object.mode_set(mode="EDIT")
    low, high = (rest := source.rest_of(obj)).min(axis=0), rest.max(axis=0)
    middle = (low + high) / 2
    ends = np.linspace(low[1], high[1], bones + 1)
    for i in range(bones):
        bone = data.edit_bones.new(f"bone{i}")
        bone.head, bone.tail = (middle[0], ends[i], middle[2]), (middle[0], ends[i + 1], middle[2])
        if i:
            bone.parent = data.edit_bones[f"bone{i - 1}"]
    bpy.ops.object.mode_set(mode="OBJECT")
    for i in range(bones):
        group = obj.vertex_groups.new(name=f"bone{i}")
        center = (ends[i] + ends[i + 1]) / 2
        weights = np.clip(1.5 - np.abs(rest[:, 1] - center) / (ends[1] - ends[0]), 0, 1)
        for vertex in np.flatnonzero(weights > 0):
            group.add([int(vertex)], float(weights[vertex]), "REPLACE")
    modifier = obj.modifiers.new("Armature", "ARMATURE")
    modifier.object = armature
    for i in range(bones):
        bone = armature.pose.bones[f"bone{i}"]
        bone.rotation_mode = "XYZ"
        for frame, angle in ((first, 0.0), (last, 0.3)):
            bone.rotation_euler = (angle, 0, 0)
            bone.keyframe_insert("rotation_euler", frame=frame)
    return armature
