# Written by tools/stubs.py.
from typing import Literal

from ._kinds import Clusterer
from ._registry import LinkedStage

class RotationKmeans(LinkedStage, Clusterer):
    """Regions of vertices that the same handles move and that turn alike in the poses: k-means on W′ (Yang et al. 2018)."""

    def __init__(
        self,
        *,
        rotation_weight: float = ...,
        stretch_weight: float = ...,
        regions: int | None = ...,
        start: Literal["handles", "plus_plus"] = ...,
        restarts: int = ...,
        max_iterations: int = ...,
        seed: int = ...,
    ) -> None: ...

class WeightKmeans(LinkedStage, Clusterer):
    """Regions of vertices that the same handles move: k-means on the rows of W (Jacobson et al. 2012)."""

    def __init__(
        self,
        *,
        regions: int | None = ...,
        start: Literal["handles", "plus_plus"] = ...,
        restarts: int = ...,
        max_iterations: int = ...,
        seed: int = ...,
    ) -> None: ...
