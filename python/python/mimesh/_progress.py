"""The progress of a run."""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Union


@dataclass(frozen=True)
class Progress:
    """How far a run is."""

    stage: str = ""
    """The stage under way, e.g. ``correspondence (nonrigid_fit)``, or ``poses``."""
    share: float | None = None
    """The share of the stage that is done, from 0 to 1, where it can tell."""
    poses_done: int = 0
    """Poses that are done."""
    pose_count: int = 0
    """All poses; 0 before the first is begun."""
    warnings: tuple[str, ...] = field(default=())
    """What was done so far that you have to know."""


ProgressLike = Union[Callable[[Progress], object], bool, None]
"""A function that is called with a `Progress`, or ``True`` to print it."""


class Reporter:
    """Makes a `Progress` of each report, and passes it on."""

    def __init__(self, listener: Callable[[Progress], object]) -> None:
        self._listener = listener
        self._now = Progress()

    def __call__(self, kind: str, text: str, number: float) -> None:
        now = self._now
        if kind == "stage":
            now = Progress(text, None, now.poses_done, now.pose_count, now.warnings)
        elif kind == "share":
            now = Progress(now.stage, number, now.poses_done, now.pose_count, now.warnings)
        elif kind == "poses":
            now = Progress("poses", 0.0, 0, int(number), now.warnings)
        elif kind == "pose_done":
            done = now.poses_done + 1
            now = Progress("poses", done / max(now.pose_count, 1), done, now.pose_count, now.warnings)
        else:
            now = Progress(now.stage, now.share, now.poses_done, now.pose_count, (*now.warnings, text))
        self._now = now
        self._listener(now)


def reporter(progress: ProgressLike) -> Reporter | None:
    """What the compiled part calls; ``None`` if nobody listens."""
    if progress is None or progress is False:
        return None
    return Reporter(_print if progress is True else progress)


def _print(progress: Progress) -> None:
    share = "" if progress.share is None else f" {100 * progress.share:.0f} %"
    print(f"\r{progress.stage}{share}".ljust(60), end="\n" if progress.share in (None, 1.0) else "", file=sys.stderr, flush=True)
