# Written by tools/stubs.py.
from collections.abc import Mapping, Sequence
from typing import Any, Literal

from ._kinds import Clusterer, Deformer, Proximity, Transfer, Weights
from ._registry import LinkedStage

class Biharmonic(LinkedStage, Transfer):
    """Moves the target by a few handles, whose maps are found on the source (Yang et al. 2018)."""

    def __init__(
        self,
        *,
        weights: Weights | Mapping[str, Any] | None = ...,
        source_proximity: Proximity | Mapping[str, Any] | None = ...,
        clusterer: Clusterer | Mapping[str, Any] | None = ...,
        deformer: Deformer | Mapping[str, Any] | None = ...,
        frame: Literal["fitted", "source"] = ...,
        orientation: Literal["auto", "same", "fitted"] = ...,
        reconstruction: Literal["gradients", "blend"] = ...,
        residual: bool = ...,
        learn_from: int = ...,
    ) -> None: ...

class Blend(LinkedStage, Transfer):
    """Several transfers, each for a part of the target: the body by one, the face by another."""

    def __init__(
        self,
        *,
        parts: Sequence[Mapping[str, Any]] = ...,
        border: float = ...,
    ) -> None: ...

class Chain(LinkedStage, Transfer):
    """Transfers one after the other: what one makes of the target is the pose that the next gives to it."""

    def __init__(
        self,
        *,
        transfers: Sequence[Transfer | Mapping[str, Any]] = ...,
    ) -> None: ...

class CopyDisplacement(LinkedStage, Transfer):
    """Adds to each target vertex the displacement of its source point, turned and scaled to the target: x̃ = x + s R (ũ − u)."""

    def __init__(
        self,
        *,
        orientation: Literal["auto", "same", "fitted"] = ...,
    ) -> None: ...

class Gradient(LinkedStage, Transfer):
    """Carries the deformation gradients of the source to the target (Sumner and Popović 2004)."""

    def __init__(
        self,
        *,
        sampling: Literal["points", "triangles"] = ...,
        weighting: Literal["area", "uniform"] = ...,
        reweightings: int = ...,
        tolerance: float = ...,
        continuation: Literal["rotations", "gradients"] = ...,
        placement: Mapping[str, Any] | Literal["motion", "markers", "rest"] = ...,
        orientation: Literal["auto", "same", "fitted"] = ...,
    ) -> None: ...

class MultiComponent(LinkedStage, Transfer):
    """Moves a target of many components as one: deformation gradients within components, gaps between them (Zhou et al. 2010)."""

    def __init__(
        self,
        *,
        term_weights: Mapping[str, Any] = ...,
        initial: Transfer | Mapping[str, Any] | None = ...,
        trust: float = ...,
        gaps: Literal["follow", "turn", "length", "tetrahedra"] = ...,
        rigid: Sequence[int | str] = ...,
        orphans: Literal["rigid", "soft"] = ...,
        sequence: bool = ...,
        plants: Sequence[Mapping[str, Any]] = ...,
        sampling: Literal["points", "triangles"] = ...,
        continuation: Literal["rotations", "gradients"] = ...,
        max_steps: int = ...,
        tolerance: float = ...,
        placement: Mapping[str, Any] | Literal["motion", "markers", "rest"] = ...,
        orientation: Literal["auto", "same", "fitted"] = ...,
    ) -> None: ...
