"""Deformation transfer between triangle meshes: a target takes the poses of a source.

>>> import mimesh
>>> result = mimesh.transfer("horse.glb", "camel.obj")        # doctest: +SKIP
>>> result.save("camel.glb")                                  # doctest: +SKIP

Meshes are `Mesh`, files, arrays or meshes of other libraries. `Pipeline` runs what a YAML file declares. Whatever is refused is an
`Error`, whose `diagnostics` say where, what, and what to do about it.
"""

import atexit as _atexit
from typing import TYPE_CHECKING, Any

from . import _mimesh
from ._convert import MeshLike, as_mesh, from_bpy, from_meshio, from_trimesh, to_bpy, to_meshio, to_trimesh
from ._errors import (
    BadDataError,
    BadPipelineError,
    BusyError,
    CannotWriteError,
    Diagnostic,
    Error,
    InternalError,
    MissingInputError,
    OutOfMemoryError,
    UsageError,
)
from ._kinds import (
    BoundTransfer,
    Clusterer,
    Correspondence,
    Deformer,
    Format,
    Generator,
    KeyPoints,
    Landmarks,
    Metric,
    Proximity,
    Sampler,
    Statistic,
    Transfer,
    Weights,
)
from ._mesh import Mesh, load, save
from ._pipeline import Pipeline, RunResult
from ._progress import Progress
from ._registry import MODULES as _MODULES
from ._registry import describe, registry
from ._stages import Stage, setting
from ._surface import Link, Surface, TriangleMap
from ._transfer import TransferResult, transfer

if TYPE_CHECKING:
    from . import (
        clusterers,
        correspondences,
        deformers,
        formats,
        generators,
        key_points,
        landmarks,
        metrics,
        proximity,
        samplers,
        testing,
        transfers,
        weights,
    )

_mimesh.set_identity(_mimesh.__file__)
# Work that was interrupted may be under way still.
_atexit.register(_mimesh.discard_all)


def __getattr__(name: str) -> Any:
    # Modules of stages ask the whole registry, so they wait until somebody wants them.
    if name in _MODULES.values() or name == "testing":
        import importlib

        return importlib.import_module(f"{__name__}.{name}")
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


__all__ = [
    "BadDataError",
    "BadPipelineError",
    "BoundTransfer",
    "BusyError",
    "CannotWriteError",
    "Clusterer",
    "Correspondence",
    "Deformer",
    "Diagnostic",
    "Error",
    "Format",
    "Generator",
    "InternalError",
    "KeyPoints",
    "Landmarks",
    "Link",
    "Mesh",
    "MeshLike",
    "Metric",
    "MissingInputError",
    "OutOfMemoryError",
    "Pipeline",
    "Progress",
    "Proximity",
    "RunResult",
    "Sampler",
    "Stage",
    "Statistic",
    "Surface",
    "Transfer",
    "TransferResult",
    "TriangleMap",
    "UsageError",
    "Weights",
    "as_mesh",
    "clusterers",
    "correspondences",
    "deformers",
    "describe",
    "formats",
    "from_bpy",
    "from_meshio",
    "from_trimesh",
    "generators",
    "key_points",
    "landmarks",
    "load",
    "metrics",
    "proximity",
    "registry",
    "samplers",
    "save",
    "setting",
    "testing",
    "to_bpy",
    "to_meshio",
    "to_trimesh",
    "transfer",
    "transfers",
    "weights",
]
