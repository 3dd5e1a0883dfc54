"""Settings and results, which are saved with the scene."""

import bpy
from bpy.props import BoolProperty, CollectionProperty, EnumProperty, IntProperty, PointerProperty, StringProperty


def _is_mesh(_settings: bpy.types.PropertyGroup, candidate: bpy.types.Object) -> bool:
    return candidate.type == "MESH"


class MimeshMessage(bpy.types.PropertyGroup):
    """One line that the panel shows."""

    text: StringProperty()


class MimeshPose(bpy.types.PropertyGroup):
    """A pose among the worst."""

    key: StringProperty(description="The shape key of the target that holds the pose")
    is_frame: BoolProperty()
    frame: IntProperty()
    level: StringProperty()
    reason: StringProperty()


class MimeshOutcome(bpy.types.PropertyGroup):
    """What the last transfer gave."""

    target: PointerProperty(type=bpy.types.Object)
    verdict: StringProperty()
    summary: StringProperty()
    messages: CollectionProperty(type=MimeshMessage)
    worst: CollectionProperty(type=MimeshPose)


class MimeshSettings(bpy.types.PropertyGroup):
    """Settings of the panel."""

    source: PointerProperty(
        name="Source",
        description="The object that gives its motion; left empty, the other selected mesh",
        type=bpy.types.Object,
        poll=_is_mesh,
    )
    target: PointerProperty(
        name="Target",
        description="The object that takes the motion; left empty, the active mesh",
        type=bpy.types.Object,
        poll=_is_mesh,
    )
    what: EnumProperty(
        name="Transfer",
        items=(
            ("AUTO", "What the Source Has", "Shape keys, the action, or both"),
            ("SHAPE_KEYS", "Shape Keys", "Each shape key of the source, by its name"),
            ("ACTION", "Action", "The shape of the source at each frame, as armature, keys and modifiers give it"),
            ("BOTH", "Both", "Shape keys, and the motion of the source"),
        ),
        default="AUTO",
    )
    frames: EnumProperty(
        name="Frames",
        items=(
            ("ACTION", "Action", "The range of the source's action"),
            ("SCENE", "Scene", "The range of the scene"),
        ),
        default="ACTION",
    )
    step: IntProperty(name="Step", description="Take every so many frames", default=1, min=1, soft_max=10)
    landmarks: EnumProperty(
        name="Landmarks",
        items=(
            ("AUTO", "Automatic", "Points that correspond are found by shape"),
            ("EMPTIES", "Empties", "Empties NAME.source and NAME.target, or children of the objects with equal names"),
            ("GROUPS", "Vertex Groups", "The middle of vertex groups that have equal names"),
        ),
        default="AUTO",
    )
    result: EnumProperty(
        name="Frames As",
        items=(
            ("ACTION", "Action", "A shape key for each frame, and an action that plays them"),
            ("SHAPE_KEYS", "Shape Keys", "A shape key for each frame, without animation"),
        ),
        default="ACTION",
    )
    interpolation: EnumProperty(
        name="Between Frames",
        items=(
            ("LINEAR", "Linear", "Blend from frame to frame"),
            ("CONSTANT", "Constant", "Hold each frame until the next"),
        ),
        default="LINEAR",
    )
    on_copy: BoolProperty(name="On a Copy", description="Leave the target alone and write into a copy of it")
    replace: BoolProperty(
        name="Replace",
        description="Overwrite shape keys of the target that have the same names; else new ones get a number",
    )
    method: EnumProperty(
        name="Method",
        items=(
            ("AUTO", "Automatic", "Chosen by the meshes"),
            ("gradient", "Gradient", "For a connected target: each triangle turns and stretches as its partner does"),
            ("biharmonic", "Biharmonic", "From a dozen landmarks, without a dense correspondence"),
            ("multi_component", "Many Pieces", "For targets of many loose parts, which keep together"),
            ("copy_displacement", "Displacement", "Vertices move as their nearest points do; for nearly equal shapes"),
        ),
        default="AUTO",
    )
    object_motion: BoolProperty(
        name="Object Motion",
        description="Include the motion of the source as an object, e.g. a root that walks; else only its shape changes",
    )
    threads: IntProperty(name="Threads", description="0 takes all", default=0, min=0, max=1024)
    outcome: PointerProperty(type=MimeshOutcome)


_CLASSES = (MimeshMessage, MimeshPose, MimeshOutcome, MimeshSettings)


def register() -> None:
    for one in _CLASSES:
        bpy.utils.register_class(one)
    bpy.types.Scene.mimesh = PointerProperty(type=MimeshSettings)


def unregister() -> None:
    del bpy.types.Scene.mimesh
    for one in reversed(_CLASSES):
        bpy.utils.unregister_class(one)
