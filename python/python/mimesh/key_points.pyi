# Written by tools/stubs.py.
from collections.abc import Mapping
from typing import Any, Literal

from ._kinds import Clusterer, Deformer, KeyPoints, Proximity, Sampler, Weights
from ._registry import LinkedStage

class Given(LinkedStage, KeyPoints):
    """The points of a sampler as they come, whatever the poses: `sampler: { type: given, vertices: […] }` for your own."""

    def __init__(
        self,
        *,
        sampler: Sampler | Mapping[str, Any] | None = ...,
        max_count: int = ...,
    ) -> None: ...

class Greedy(LinkedStage, KeyPoints):
    """Adds the candidate that helps most, then exchanges points while that helps (Yang et al. 2018, algorithm 1)."""

    def __init__(
        self,
        *,
        threshold: float = ...,
        min_count: int = ...,
        max_count: int = ...,
        error: Literal["mean", "frobenius"] = ...,
        exhaustive: bool = ...,
        shortlist: int = ...,
        max_rounds: int = ...,
        first: int = ...,
        sampler: Sampler | Mapping[str, Any] | None = ...,
        weights: Weights | Mapping[str, Any] | None = ...,
        ranking: Weights | Mapping[str, Any] | None = ...,
        ranking_vertices: int | None = ...,
        proximity: Proximity | Mapping[str, Any] | None = ...,
        clusterer: Clusterer | Mapping[str, Any] | None = ...,
        deformer: Deformer | Mapping[str, Any] | None = ...,
    ) -> None: ...
