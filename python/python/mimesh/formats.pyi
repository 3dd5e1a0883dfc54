# Written by tools/stubs.py.
from typing import Literal

from ._kinds import Format
from ._registry import LinkedStage

class Fbx(LinkedStage, Format):
    """FBX, binary or ASCII, for reading: meshes with skins, blend shapes and clips, in metres with Y up."""

    def __init__(
        self,
    ) -> None: ...

class Glb(LinkedStage, Format):
    """Binary glTF 2.0: one file with the rest mesh, a named morph target a pose, and animations that show them."""

    def __init__(
        self,
        *,
        frames_per_second: float = ...,
        pose_normals: bool = ...,
        animation: Literal["auto", "none", "play", "clip_times"] = ...,
        unit: Literal["m", "cm", "mm", "in", "ft"] = ...,
        up: Literal["y", "z", "x"] = ...,
    ) -> None: ...

class Gltf(LinkedStage, Format):
    """glTF 2.0 as text with its numbers inside: as `glb`, a third larger, for tools that take no binary files."""

    def __init__(
        self,
        *,
        frames_per_second: float = ...,
        pose_normals: bool = ...,
        animation: Literal["auto", "none", "play", "clip_times"] = ...,
        unit: Literal["m", "cm", "mm", "in", "ft"] = ...,
        up: Literal["y", "z", "x"] = ...,
    ) -> None: ...

class Mdd(LinkedStage, Format):
    """MDD, a point cache: the vertices of a mesh at given times, without the mesh."""

    def __init__(
        self,
        *,
        frames_per_second: float = ...,
    ) -> None: ...

class Obj(LinkedStage, Format):
    """Wavefront OBJ: polygons, texture coordinates, normals, groups and materials; one file a pose."""

    def __init__(
        self,
        *,
        turn_normals: bool = ...,
    ) -> None: ...

class Off(LinkedStage, Format):
    """OFF as text: polygons, normals, texture coordinates, colours of vertices and faces; one file a pose."""

    def __init__(
        self,
    ) -> None: ...

class Pc2(LinkedStage, Format):
    """PC2, a point cache: the vertices of a mesh at evenly spaced frames, without the mesh."""

    def __init__(
        self,
        *,
        frames_per_second: float = ...,
    ) -> None: ...

class Ply(LinkedStage, Format):
    """Stanford PLY: polygons, normals, texture coordinates, colours of vertices and faces; one file a pose."""

    def __init__(
        self,
        *,
        encoding: Literal["ascii", "binary_little_endian", "binary_big_endian"] = ...,
        precision: Literal["auto", "float", "double"] = ...,
    ) -> None: ...

class Stl(LinkedStage, Format):
    """STL: binary or ASCII in, binary out with one file a pose; it holds triangles only."""

    def __init__(
        self,
    ) -> None: ...

class Usda(LinkedStage, Format):
    """USD as text, for writing: one file with the rest mesh, and a time sample of its points a pose."""

    def __init__(
        self,
        *,
        frames_per_second: float = ...,
        unit: Literal["m", "cm", "mm", "in", "ft"] = ...,
        up: Literal["y", "z", "x"] = ...,
    ) -> None: ...
