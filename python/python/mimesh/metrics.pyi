# Written by tools/stubs.py.
from collections.abc import Mapping, Sequence
from typing import Any, Literal

from ._kinds import Metric
from ._registry import LinkedStage

class AreaChange(LinkedStage, Metric):
    """How much triangles grow and shrink, beyond the triangles of the source."""

    def __init__(
        self,
    ) -> None: ...

class Closure(LinkedStage, Metric):
    """Lips and eyelids that do not close or open as far as those of the source."""

    def __init__(
        self,
        *,
        pairs: Sequence[Mapping[str, Any]] = ...,
    ) -> None: ...

class ComponentGaps(LinkedStage, Metric):
    """Components that lie together at rest and drift apart in a pose."""

    def __init__(
        self,
    ) -> None: ...

class ComponentMotion(LinkedStage, Metric):
    """Distance and rotation of components against the known result."""

    def __init__(
        self,
    ) -> None: ...

class ContactSlide(LinkedStage, Metric):
    """Feet that slide: motion of the target where the source stands still on the ground."""

    def __init__(
        self,
        *,
        still: float = ...,
        height: float = ...,
        up: Literal["x", "y", "z"] = ...,
    ) -> None: ...

class EdgeStretch(LinkedStage, Metric):
    """How much edges grow and shrink, beyond the edges of the source."""

    def __init__(
        self,
    ) -> None: ...

class FlippedTriangles(LinkedStage, Metric):
    """Triangles that are folded over against their neighbours."""

    def __init__(
        self,
    ) -> None: ...

class Jitter(LinkedStage, Metric):
    """Trembling of a motion, beyond that of the source."""

    def __init__(
        self,
    ) -> None: ...

class MapCollapse(LinkedStage, Metric):
    """Places where the map takes much of the target to little of the source, at rest."""

    def __init__(
        self,
    ) -> None: ...

class MapTears(LinkedStage, Metric):
    """Neighbours on the target that take their motion from distant places of the source, at rest."""

    def __init__(
        self,
    ) -> None: ...

class MarkerFit(LinkedStage, Metric):
    """Markers in a wrong place, and left and right swapped, at rest."""

    def __init__(
        self,
    ) -> None: ...

class PointError(LinkedStage, Metric):
    """Distance of each vertex to its known position, in percent of the diagonal at rest."""

    def __init__(
        self,
    ) -> None: ...

class RestDifference(LinkedStage, Metric):
    """Rests that stand in other poses: arms stretched out on one and hanging on the other."""

    def __init__(
        self,
    ) -> None: ...

class SelfIntersections(LinkedStage, Metric):
    """Parts that run into each other: triangles that cross others in the pose but none at rest."""

    def __init__(
        self,
    ) -> None: ...

class SourceMotion(LinkedStage, Metric):
    """Parts that do not move as the source does: limbs that stay, eyelids that do not close, targets that remain at rest."""

    def __init__(
        self,
    ) -> None: ...

class Volume(LinkedStage, Metric):
    """Change of the volume, beyond that of the source."""

    def __init__(
        self,
    ) -> None: ...
