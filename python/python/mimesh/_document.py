"""Pipelines as the compiled part reads them: text, and meshes of memory beside it."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from typing import Any, Union

import numpy as np

from . import _mimesh
from ._convert import as_mesh
from ._errors import misuse
from ._mesh import Mesh

CacheLike = Union[bool, str, "os.PathLike[str]"]
"""Whether results of stages are cached: ``True`` for the user's own folder, or a folder."""


class Document:
    """The text of a pipeline, with the meshes of memory that it names."""

    def __init__(self) -> None:
        self.meshes: dict[str, _mimesh.MeshData] = {}

    def value(self, value: Any) -> Any:
        """A value of Python as JSON: stages as their settings, paths as text, arrays as lists."""
        if hasattr(value, "to_dict") and hasattr(value, "kind"):
            return self.value(value.to_dict())
        if isinstance(value, Mapping):
            return {str(key): self.value(inner) for key, inner in value.items()}
        if isinstance(value, (list, tuple)):
            return [self.value(inner) for inner in value]
        if isinstance(value, os.PathLike):
            return os.fspath(value)
        if isinstance(value, np.ndarray):
            return value.tolist()
        if isinstance(value, np.generic):
            return value.item()
        if value is None or isinstance(value, (str, int, float, bool)):
            return value
        raise misuse(f"expected a value of YAML or a stage, found {type(value).__name__}")

    def side(self, side: Any, *, at_rest: bool) -> Any:
        """The source or target of a pipeline, whose rest may be a mesh of memory."""
        if not isinstance(side, Mapping):
            return self.value(side)
        settings = dict(side)
        rest = settings.get("rest")
        if rest is None or isinstance(rest, (str, os.PathLike, Mapping)):
            return self.value(settings)
        del settings["rest"]
        return {"generator": self.generator(as_mesh(rest), at_rest=at_rest), **self.value(settings)}

    def generator(self, mesh: Mesh, *, at_rest: bool) -> dict[str, Any]:
        """The generator that gives a mesh of memory."""
        content = mesh._data.content_hash()
        self.meshes[content] = mesh._data
        return {"type": "in_memory", "content": content, "at_rest": at_rest}

    def pipeline(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """A whole pipeline, as a mapping."""
        text = {str(key): value for key, value in values.items()}
        for key, at_rest in (("source", False), ("target", True)):
            if key in text:
                text[key] = self.side(text[key], at_rest=at_rest)
        return {key: value if key in ("source", "target") else self.value(value) for key, value in text.items()}


def text_of(values: Mapping[str, Any]) -> str:
    """A mapping as text, a key a line, so that messages can show the lines."""
    lines = [f"{json.dumps(key)}: {json.dumps(value, ensure_ascii=False)}" for key, value in values.items()]
    return "\n".join(lines) + "\n"


def job(
    file: str,
    text: str | None,
    *,
    set: Sequence[str] = (),
    out: str | os.PathLike[str] | None = None,
    roots: Sequence[str | os.PathLike[str]] = (),
    allow_commands: bool = False,
    threads: int | None = None,
    cache: CacheLike = False,
) -> str:
    """What is asked of the compiled part, as JSON."""
    if isinstance(set, str):
        raise misuse("set: expected a list of settings, found a string", f'`set=["{set}"]`')
    if threads is not None and not 1 <= threads <= 1024:
        raise misuse(f"threads: expected a whole number from 1 to 1024, found {threads}")
    folder = None if isinstance(cache, bool) else os.fspath(cache)
    return json.dumps(
        {
            "file": file,
            "text": text,
            "set": list(set),
            "out": None if out is None else os.fspath(out),
            "roots": [os.fspath(root) for root in roots],
            "allow_commands": allow_commands,
            "threads": threads or 0,
            "is_cached": cache is not False,
            "cache": folder,
        }
    )
