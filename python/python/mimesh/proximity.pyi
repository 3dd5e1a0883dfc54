# Written by tools/stubs.py.
from collections.abc import Sequence
from typing import Literal

from ._kinds import Proximity
from ._registry import LinkedStage

class SpanningTree(LinkedStage, Proximity):
    """Links components by a minimum spanning tree over their distances, and others as close (Zhou et al. 2010, section 2.1)."""

    def __init__(
        self,
        *,
        epsilon_factor: float = ...,
        pairs: Literal["spread", "all"] = ...,
        max_pairs: int = ...,
        add: Sequence[Sequence[int | str]] = ...,
        forbid: Sequence[Sequence[int | str]] = ...,
        weld: Sequence[Sequence[int | str]] = ...,
    ) -> None: ...
