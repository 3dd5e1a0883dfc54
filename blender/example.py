"""Transfers a file's motion onto another file's mesh, without a window:

    blender --background --python blender/example.py -- source.glb target.obj out.blend [--clip NAME] [--picture out.png]

Writes the scene as .blend, and the target with its motion as .glb beside it. With the module `bpy` it is
`python blender/example.py source.glb target.obj out.blend`.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
import traceback
from pathlib import Path

import bpy
import mathutils

try:
    sys.path.insert(0, str(Path(__file__).resolve().parent))
    import mimesh_blender
except ImportError:
    sys.exit("expected mimesh_blender beside this file")


def load(path: Path) -> bpy.types.Object:
    """The mesh of a file as one object; where it has several, the one with the most vertices."""
    before = set(bpy.data.objects)
    if path.suffix.lower() in (".glb", ".gltf"):
        bpy.ops.import_scene.gltf(filepath=str(path))
    else:
        # Files may have any axis up; what counts is that source and target stand alike.
        readers = {".obj": bpy.ops.wm.obj_import, ".ply": bpy.ops.wm.ply_import, ".stl": bpy.ops.wm.stl_import}
        if path.suffix.lower() not in readers:
            sys.exit(f"{path}: expected .glb, .gltf, .obj, .ply or .stl")
        readers[path.suffix.lower()](filepath=str(path))
    meshes = [obj for obj in bpy.data.objects if obj not in before and obj.type == "MESH"]
    if not meshes:
        sys.exit(f"{path}: there is no mesh")
    return max(meshes, key=lambda obj: len(obj.data.vertices))


def choose_clip(obj: bpy.types.Object, clip: str | None) -> None:
    """Makes a clip the active action of the shape keys or the armature of an object."""
    if clip is None:
        return
    owners = [obj.data.shape_keys, *(modifier.object for modifier in obj.modifiers if modifier.type == "ARMATURE")]
    for owner in filter(None, owners):
        for action in bpy.data.actions:
            # The importer adds the name of the object.
            if action.name == clip or action.name.startswith(f"{clip}_"):
                data = owner.animation_data_create()
                data.action = action
                # Blender has slots since 4.4, and only some fit.
                if hasattr(data, "action_suitable_slots"):
                    data.action_slot = next(iter(data.action_suitable_slots), None)
                return
    sys.exit(f"there is no clip {clip}; clips: {', '.join(action.name for action in bpy.data.actions)}")


def look_at(obj: bpy.types.Object) -> None:
    """A camera and a sun that show an object from the front and the side."""
    scene = bpy.context.scene
    evaluated = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
    corners = [evaluated.matrix_world @ mathutils.Vector(corner) for corner in evaluated.bound_box]
    middle = sum(corners, mathutils.Vector()) / len(corners)
    size = max((corner - middle).length for corner in corners)
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    sun = bpy.data.objects.new("sun", bpy.data.lights.new("sun", "SUN"))
    away = mathutils.Vector((1.0, -1.0, 0.45)).normalized()
    camera.location = middle + 3.2 * size * away
    camera.rotation_euler = sun.rotation_euler = away.to_track_quat("Z", "Y").to_euler()
    camera.data.clip_end = 10 * size
    sun.data.energy = 3.0
    for made in (camera, sun):
        scene.collection.objects.link(made)
    scene.camera = camera


def render(target: bpy.types.Object, path: Path) -> None:
    """A small picture of the target in the middle of the scene's frames."""
    scene = bpy.context.scene
    for obj in scene.objects:
        obj.hide_render = obj != target
    scene.frame_set((scene.frame_start + scene.frame_end) // 2)
    look_at(target)
    scene.world = scene.world or bpy.data.worlds.new("world")
    scene.render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.use_denoising = 32, False
    scene.render.resolution_x = scene.render.resolution_y = 480
    scene.render.filepath = str(path.resolve())
    bpy.ops.render.render(write_still=True)


def main(arguments: list[str]) -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("source", type=Path)
    parser.add_argument("target", type=Path)
    parser.add_argument("out", type=Path, help="a .blend; the .glb is written beside it")
    parser.add_argument("--clip", help="a clip of the source, by its name")
    parser.add_argument("--step", type=int, default=1, help="take every so many frames")
    parser.add_argument("--picture", type=Path, help="a .png of the middle frame")
    options = parser.parse_args(arguments)

    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    is_installed = hasattr(bpy.types.Scene, "mimesh")
    if not is_installed:
        mimesh_blender.register()
    source, target = load(options.source), load(options.target)
    choose_clip(source, options.clip)
    scene, settings = bpy.context.scene, bpy.context.scene.mimesh
    settings.source, settings.target, settings.step = source, target, options.step
    begun = time.perf_counter()
    bpy.ops.mimesh.transfer()
    print(f"transferred in {time.perf_counter() - begun:.1f} s: {settings.outcome.summary}, {settings.outcome.verdict}")
    action = target.data.shape_keys.animation_data and target.data.shape_keys.animation_data.action
    if action:
        scene.frame_start, scene.frame_end = map(round, action.frame_range)

    bpy.ops.wm.save_as_mainfile(filepath=str(options.out.resolve()))
    for obj in scene.objects:
        obj.select_set(obj == target)
    bpy.ops.export_scene.gltf(filepath=str(options.out.with_suffix(".glb").resolve()), use_selection=True, export_morph_normal=False)
    if options.picture:
        render(target, options.picture)
    if not is_installed:
        mimesh_blender.unregister()


def leave(status: int) -> None:
    """Ends Python. As a module of Python, Blender may crash or hang while Python ends, so it is not asked to."""
    if bpy.app.binary_path:
        sys.exit(status)
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(status)


if __name__ == "__main__":
    try:
        main(sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else sys.argv[1:])
    except SystemExit as end:
        if isinstance(end.code, str):
            print(end.code, file=sys.stderr)
        leave(1 if isinstance(end.code, str) else end.code or 0)
    except Exception:
        traceback.print_exc()
        leave(1)
    leave(0)
