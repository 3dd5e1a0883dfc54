# Written by tools/stubs.py.
from typing import Literal

from ._kinds import Generator
from ._registry import LinkedStage

class Quadruped(LinkedStage, Generator):
    """A procedural four-legged animal with a gait, for trying things and for tests: no file is needed."""

    def __init__(
        self,
        *,
        proportions: Literal["horse", "camel", "giraffe"] = ...,
        gait: Literal["gallop", "walk", "none"] = ...,
        frames: int = ...,
        made_of: Literal["skin", "pebbles", "plates", "boxes"] = ...,
        pieces: int | None = ...,
        resolution: int = ...,
        size: float = ...,
        seed: int = ...,
    ) -> None: ...
