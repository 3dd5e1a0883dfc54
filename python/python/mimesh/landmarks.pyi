# Written by tools/stubs.py.
from collections.abc import Mapping, Sequence
from typing import Any

from ._kinds import Correspondence, Landmarks, Sampler
from ._registry import LinkedStage

class External(LinkedStage, Landmarks):
    """The pairs that a program answers, which is run with the files of both meshes; it needs `--allow-commands`."""

    def __init__(
        self,
        *,
        command: Sequence[str] = ...,
        time_limit: float = ...,
    ) -> None: ...

class Extremities(LinkedStage, Landmarks):
    """The ends of limbs such as legs, arms, necks and tails, and points between them; points at the same place for shapes without limbs that lie alike, as faces. Fits forwards and backwards tell how sure they are."""

    def __init__(
        self,
        *,
        sampler: Sampler | Mapping[str, Any] | None = ...,
        sources: int = ...,
        min_limb: float = ...,
        limits: Mapping[str, Any] = ...,
        points_per_limb: int = ...,
        max_distance: float = ...,
        points_between: int = ...,
        fit: Correspondence | Mapping[str, Any] | None = ...,
        fit_vertices: int = ...,
    ) -> None: ...

class Given(LinkedStage, Landmarks):
    """The points that were clicked, and no others."""

    def __init__(
        self,
    ) -> None: ...
