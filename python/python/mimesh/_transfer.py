"""From two meshes to the poses of the target."""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

import numpy as np

from . import _display, _mimesh
from ._convert import MeshLike, as_mesh
from ._document import CacheLike, Document, job, text_of
from ._errors import Diagnostic, diagnostics_of, misuse
from ._mesh import Mesh, PosesLike, Positions
from ._progress import ProgressLike, reporter


class TransferResult:
    """The target in the poses of the source."""

    def __init__(self, data: _mimesh.TransferData) -> None:
        self._data = data
        told = json.loads(data.report())
        self.report: dict[str, Any] = told["report"]
        """The report of the run: choices, markers, statistics and verdicts of the poses, times."""
        self.failed: list[Diagnostic] = diagnostics_of(told["failed_poses"])
        """Why poses are missing, if any is."""
        for of_files in ("outputs", "place", "inputs"):
            self.report.pop(of_files, None)
        self.poses: tuple[str, ...] = tuple(data.names())
        """The names of the poses."""
        self.positions: Positions = np.asarray(data.positions())
        """Positions in all poses, p × n × 3: the memory of the result itself, which cannot be written."""

    @property
    def target(self) -> Mesh:
        """The target at rest."""
        return Mesh._of(self._data.target())

    @property
    def mesh(self) -> Mesh:
        """The target with its new poses."""
        return self.target.with_poses(dict(zip(self.poses, self.positions)))

    @property
    def verdict(self) -> str | None:
        """``good``, ``doubtful`` or ``bad``, as the report says."""
        verdict: str | None = self.report.get("verdict")
        return verdict

    @property
    def warnings(self) -> list[str]:
        """What looks wrong or was left out."""
        warnings: list[str] = self.report.get("warnings", [])
        return warnings

    def save(self, path: str | os.PathLike[str]) -> list[Path]:
        """Writes the target with its new poses; with ``{pose}`` in the name a file a pose. The files that were written."""
        return [Path(file) for file in self._data.save(path)]

    def animation(
        self, frames_per_second: float = 12.0, *, view: str = "three_quarter", up: str = "y", size: int = 320
    ) -> bytes:
        """A PNG that plays the poses, at most 24 of them; browsers and notebooks show it as any picture."""
        shown = [self.positions[i] for i in _display.evenly_spaced(len(self.poses))]
        return _display.animation(self.target, shown, frames_per_second, view, up, size)

    def _repr_html_(self) -> str:
        return _display.as_html(self.animation(), repr(self)[1:-1])

    def __repr__(self) -> str:
        verdict = f", {self.verdict}" if self.verdict else ""
        return f"<mimesh.TransferResult: {len(self.poses)} poses of {self.positions.shape[1]} vertices{verdict}>"


def transfer(
    source: MeshLike,
    target: MeshLike,
    *,
    poses: PosesLike | str | os.PathLike[str] | None = None,
    clip: str | Sequence[str] | None = None,
    markers: Any = None,
    poses_are: Literal["frames", "shapes"] | None = None,
    progress: ProgressLike = None,
    threads: int | None = None,
    cache: CacheLike = False,
    set: Sequence[str] = (),
    roots: Sequence[str | os.PathLike[str]] = (),
    allow_commands: bool = False,
    **settings: Any,
) -> TransferResult:
    """Gives the poses of one mesh to another; all that you do not say is chosen by the meshes.

    Args:
        source: The mesh that gives its motion: a file, a `Mesh`, a pair of vertices and faces, or a mesh of trimesh, meshio or
            Blender.
        target: The mesh that takes the motion.
        poses: The poses of the source: an array of p × n × 3, a mapping of names to positions, meshes or files in a list, or a glob
            of files. Left out, those that come with the source.
        clip: A clip that gives the poses, by its name in the file of the source.
        markers: Corresponding points: pairs of vertices of source and target, a file of them, or a stage of `mimesh.landmarks`.
            Left out, they are found by shape where they are needed.
        poses_are: Whether the poses are ``frames`` of one motion, or ``shapes`` that stand alone. Left out, names tell.
        progress: A function that is called with a `Progress`, or ``True`` to print it.
        threads: Threads to use; results do not depend on their number. Left out, all.
        cache: Whether results of stages are cached for the next call: ``True`` for the user's own folder, or a folder.
        set: Other values of the pipeline, e.g. ``["target.mirrored=x"]``.
        roots: Folders whose files meshes may open, beside their own.
        allow_commands: Whether stages may run programs that settings name.
        **settings: Slots of the pipeline: ``transfer``, ``correspondence``, ``proximity``, ``metrics``, ``shapes`` and so on. A
            stage is an object of `mimesh.transfers` and the like, its type as a string, or a mapping with ``type``.

    Raises:
        mimesh.Error: With all that is wrong; the class says of which kind it is.
    """
    document = Document()
    values: dict[str, Any] = {
        "source": _source(document, source, poses, clip, poses_are),
        "target": _target(document, target),
    }
    for slot, value in settings.items():
        is_type = isinstance(value, str) and slot in ("transfer", "correspondence", "proximity") and value != "auto"
        values[slot] = {"type": value} if is_type else document.value(value)
    with tempfile.TemporaryDirectory(prefix="mimesh-") as folder:
        if markers is not None:
            values["markers"] = _markers(document, markers, folder)
        asked = job(
            "transfer",
            text_of(values),
            set=set,
            out=folder,
            roots=roots,
            allow_commands=allow_commands,
            threads=threads,
            cache=cache,
        )
        return TransferResult(_mimesh.transfer(asked, list(document.meshes.items()), reporter(progress)))


def _is_path(value: Any) -> bool:
    return isinstance(value, (str, os.PathLike))


def _source(document: Document, source: Any, poses: Any, clip: Any, poses_are: str | None) -> dict[str, Any]:
    extra = {} if poses_are is None else {"poses_are": poses_are}
    are_files = _is_path(poses) or (isinstance(poses, (list, tuple)) and all(_is_path(pose) for pose in poses))
    if clip is not None:
        if not _is_path(source):
            raise misuse("clip: only a file has clips", "give the source as a path, or its poses by `poses`")
        file = {"file": os.fspath(poses)} if _is_path(poses) else {}
        return {"rest": os.fspath(source), "poses": {**file, "clip": document.value(clip)}, **extra}
    if _is_path(source) and (poses is None or are_files):
        named = {} if poses is None else {"poses": document.value(poses)}
        return {"rest": os.fspath(source), **named, **extra}
    mesh = as_mesh(source)
    if poses is not None:
        mesh = mesh.with_poses([poses] if _is_path(poses) else poses)
    return {"generator": document.generator(mesh, at_rest=False), **extra}


def _target(document: Document, target: Any) -> dict[str, Any]:
    if _is_path(target):
        return {"rest": os.fspath(target)}
    return {"generator": document.generator(as_mesh(target), at_rest=True)}


def _markers(document: Document, markers: Any, folder: str) -> Any:
    """Markers as a pipeline has them; pairs of vertices are written into a file."""
    if _is_path(markers) or isinstance(markers, Mapping) or hasattr(markers, "to_dict"):
        return document.value(markers)
    pairs = np.asarray(markers)
    if pairs.ndim != 2 or pairs.shape[1] != 2 or not np.issubdtype(pairs.dtype, np.integer):
        raise misuse("markers: expected pairs of vertices of source and target, or a file", "e.g. `markers=[(12, 40), (7, 3)]`")
    file = Path(folder) / "markers.cons"
    file.write_text(f"{len(pairs)}\n" + "".join(f"{a}, {b}\n" for a, b in pairs.tolist()))
    return os.fspath(file)
