# Written by tools/stubs.py.
from typing import Any, Literal

from ._kinds import Deformer
from ._registry import LinkedStage

class ArapSkinning(LinkedStage, Deformer):
    """Fits affine maps of handles to a pose, as rigid within regions as possible (Yang et al. 2018, eq. 5)."""

    def __init__(
        self,
        *,
        difference: Literal["uniform", "area", "none"] = ...,
        edge_weights: Literal["cotangent", "signed_cotangent", "uniform"] = ...,
        global_step: Literal["exact", "stacked"] = ...,
        regularisation: float = ...,
        tolerance: float = ...,
        max_iterations: int = ...,
        **settings: Any,
    ) -> None: ...

class LinearBlend(LinkedStage, Deformer):
    """Fits affine maps of handles to a pose by least squares."""

    def __init__(
        self,
        *,
        regularisation: float = ...,
    ) -> None: ...
