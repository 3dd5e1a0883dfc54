# Written by tools/stubs.py.
from collections.abc import Sequence
from typing import Literal

from ._kinds import Sampler
from ._registry import LinkedStage

class FarthestPoint(LinkedStage, Sampler):
    """Vertices spread evenly over a surface, each the farthest from those before."""

    def __init__(
        self,
        *,
        count: int = ...,
        seed: int = ...,
        metric: Literal["geodesic", "euclidean"] = ...,
    ) -> None: ...

class Given(LinkedStage, Sampler):
    """The vertices that the settings list."""

    def __init__(
        self,
        *,
        vertices: Sequence[int] = ...,
    ) -> None: ...

class PoissonDisk(LinkedStage, Sampler):
    """Random points that keep a distance from each other (sample elimination, Yuksel 2015)."""

    def __init__(
        self,
        *,
        count: int = ...,
        seed: int = ...,
        oversampling: float = ...,
        at_vertices: bool = ...,
    ) -> None: ...
