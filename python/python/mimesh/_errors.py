"""What goes wrong, as exceptions that say where and what to do about it."""

from __future__ import annotations

import json
import traceback
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Diagnostic:
    """One thing that is wrong."""

    kind: str
    """``bad_pipeline``, ``bad_data``, ``missing_input``, ``cannot_write``, ``busy``, ``memory``, ``usage`` or ``internal``."""
    message: str
    """What was expected and what was found."""
    hint: str | None = None
    """The way out."""
    file: str | None = None
    """The file that it is in."""
    line: int | None = None
    """Its line there, from 1."""
    column: int | None = None
    """Its first column, from 1."""
    option: str | None = None
    """The value beside the file that it is in, e.g. of ``set``."""
    text: str = ""
    """All of it, with the line of the file."""

    def __str__(self) -> str:
        return self.text or self.message


class Error(Exception):
    """Anything that mimesh refuses; the other exceptions are kinds of it."""

    diagnostics: tuple[Diagnostic, ...]
    """All that is wrong, each with its place and a way out."""

    def __init__(self, message: str = "", diagnostics: tuple[Diagnostic, ...] = ()) -> None:
        super().__init__(message)
        self.diagnostics = diagnostics

    def __str__(self) -> str:
        return str(self.args[0]) if self.args else ""


class BadPipelineError(Error):
    """A pipeline that is wrong."""


class BadDataError(Error):
    """A mesh, markers or a correspondence that cannot be worked with."""


class MissingInputError(Error, FileNotFoundError):
    """A file that is read and does not exist."""


class CannotWriteError(Error, OSError):
    """A result that cannot be written."""


class BusyError(Error):
    """Another process is at work on the same files; later it will succeed."""


class OutOfMemoryError(Error, MemoryError):
    """Work that needs more memory than the process may have."""


class UsageError(Error, ValueError):
    """Arguments or settings that nobody can work with."""


class InternalError(Error):
    """A fault of mimesh itself."""


_CLASSES: dict[str, type[Error]] = {
    "bad_pipeline": BadPipelineError,
    "bad_data": BadDataError,
    "missing_input": MissingInputError,
    "cannot_write": CannotWriteError,
    "busy": BusyError,
    "memory": OutOfMemoryError,
    "usage": UsageError,
    "internal": InternalError,
}

_KEYS = ("kind", "message", "hint", "file", "line", "column", "option", "text")


def diagnostics_of(text: str | list[dict[str, Any]]) -> list[Diagnostic]:
    """The diagnostics that JSON lists."""
    listed = json.loads(text) if isinstance(text, str) else text
    return [Diagnostic(**{key: one[key] for key in _KEYS if one.get(key) is not None}) for one in listed]


def exception_of(kind: str, message: str, diagnostics: str) -> Error:
    """The exception of diagnostics that together are of this kind; the compiled part raises it."""
    made = _CLASSES.get(kind, Error)(message, tuple(diagnostics_of(diagnostics)))
    cause = _taken_cause()
    if cause is not None:
        made.__cause__ = cause
    return made


def misuse(message: str, hint: str | None = None) -> UsageError:
    """The exception of arguments that nobody can work with."""
    text = message if hint is None else f"{message}\n  hint: {hint}"
    return UsageError(text, (Diagnostic("usage", message, hint, text=text),))


_last_cause: BaseException | None = None


def remember_cause(error: BaseException) -> None:
    """Keeps what a stage in Python raised, so that the exception of the call has it as its cause."""
    global _last_cause
    _last_cause = error


def _taken_cause() -> BaseException | None:
    global _last_cause
    cause, _last_cause = _last_cause, None
    return cause


def place_of(error: BaseException) -> str:
    """Where an exception was raised, outside of mimesh."""
    frames = traceback.extract_tb(error.__traceback__)
    own = [frame for frame in frames if not frame.filename.endswith(("mimesh/_stages.py", "mimesh/_surface.py", "<frozen importlib._bootstrap>", "<frozen importlib._bootstrap_external>"))]
    if not own:
        return ""
    return f"it was raised at {own[-1].filename}:{own[-1].lineno}, in `{own[-1].name}`"
