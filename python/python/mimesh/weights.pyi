# Written by tools/stubs.py.
from typing import Literal

from ._kinds import Weights
from ._registry import LinkedStage

class Biharmonic(LinkedStage, Weights):
    """The smoothest weights, which may leave 0 to 1: unbounded biharmonic, fast for many choices of handles."""

    def __init__(
        self,
        *,
        bridge: float = ...,
        clamp: bool = ...,
    ) -> None: ...

class BoundedBiharmonic(LinkedStage, Weights):
    """The smoothest weights between 0 and 1: bounded biharmonic weights (Jacobson et al. 2011; Yang et al. 2018, eq. 1)."""

    def __init__(
        self,
        *,
        normalize: Literal["rows", "exact", "none"] = ...,
        solver: Literal["automatic", "active_sets", "interior_point"] = ...,
        tolerance: float = ...,
        max_iterations: int = ...,
        bridge: float = ...,
    ) -> None: ...

class GeodesicFalloff(LinkedStage, Weights):
    """Weights by inverse distance along the surface: cheap, a baseline."""

    def __init__(
        self,
        *,
        power: float = ...,
    ) -> None: ...

class Harmonic(LinkedStage, Weights):
    """Harmonic weights: spread like heat between handles, with a spike at each."""

    def __init__(
        self,
        *,
        bridge: float = ...,
    ) -> None: ...
