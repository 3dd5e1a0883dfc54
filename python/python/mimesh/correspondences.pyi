# Written by tools/stubs.py.
import os
from collections.abc import Sequence
from typing import Literal

from ._kinds import Correspondence
from ._registry import LinkedStage

class FromFile(LinkedStage, Correspondence):
    """Reads a correspondence written by `keep_correspondence:`."""

    def __init__(
        self,
        *,
        path: str | os.PathLike[str] = ...,
    ) -> None: ...

class Identity(LinkedStage, Correspondence):
    """Each target triangle moves like the source triangle of the same number: for meshes of one topology."""

    def __init__(
        self,
    ) -> None: ...

class Nearest(LinkedStage, Correspondence):
    """Each target triangle moves like the source triangle closest to it at rest, among those that face the same way."""

    def __init__(
        self,
        *,
        max_distance: float = ...,
    ) -> None: ...

class NonrigidFit(LinkedStage, Correspondence):
    """Deforms the target onto the source, guided by markers and closest points, and pairs triangles that then lie together (Sumner and Popović 2004; Zhou et al. 2010, section 2.2)."""

    def __init__(
        self,
        *,
        smoothness: float = ...,
        identity: float = ...,
        proximity: float = ...,
        weighting: Literal["area", "uniform"] = ...,
        link_pairs: int | None = ...,
        closest: Sequence[float] = ...,
        steps: int = ...,
        max_distance: float = ...,
        inner_depth: float = ...,
        proxy_above: int | None = ...,
        proxy_vertices: int = ...,
        orientation: Literal["auto", "same", "fitted"] = ...,
    ) -> None: ...
