"""What users read: refusals, errors of mimesh, verdicts."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

LEVELS = ("good", "doubtful", "bad")


class Refusal(Exception):
    """Something that cannot be done, with a way out."""

    def __init__(self, message: str, hint: str = "") -> None:
        super().__init__(message)
        self.message = message
        self.hint = hint

    def __str__(self) -> str:
        return f"{self.message}\nHint: {self.hint}" if self.hint else self.message


class Cancelled(Exception):
    """The user has cancelled the work."""


def text_of(error: BaseException) -> str:
    """An error as one text that can be read in a report of Blender."""
    diagnostics = getattr(error, "diagnostics", None)
    if diagnostics:
        return "\n".join(_text_of_diagnostic(diagnostic) for diagnostic in diagnostics)
    if isinstance(error, (Refusal, MemoryError)):
        return str(error) or "there is not enough memory"
    return f"{type(error).__name__}: {error}"


def _text_of_diagnostic(diagnostic: Any) -> str:
    # Files and lines are those of a pipeline that the user never sees.
    return f"{diagnostic.message}\nHint: {diagnostic.hint}" if diagnostic.hint else diagnostic.message


def listed(names: Iterable[str], most: int = 6) -> str:
    """Names in one line; long lists end with the number of those left out."""
    names = list(names)
    shown = ", ".join(names[:most])
    return shown if len(names) <= most else f"{shown} and {len(names) - most} more"


def counted(count: int, thing: str) -> str:
    """A number with its noun."""
    return f"{count} {thing}" if count == 1 else f"{count} {thing}s"


def reason_text(verdict: dict[str, Any]) -> str:
    """The statistic that is farthest beyond its limit."""
    reasons = verdict.get("reasons", [])
    if not reasons:
        return ""
    worst = max(reasons, key=_excess)
    name = f"{worst['metric']}: {worst['figure']}".replace("_", " ")
    return f"{name} {worst['value']:.3g}, limit {worst['limit']:.3g}"


def severity(verdict: dict[str, Any]) -> tuple[int, float]:
    """What orders poses from the best to the worst."""
    level = verdict.get("level", "good")
    reasons = verdict.get("reasons", [])
    return (LEVELS.index(level) if level in LEVELS else 0, max(map(_excess, reasons), default=0.0))


def _excess(reason: dict[str, Any]) -> float:
    value, limit = abs(float(reason["value"])), abs(float(reason["limit"]))
    return value / limit if limit else value
