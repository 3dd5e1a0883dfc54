"""A class for each stage that is linked, from what the registry says of it."""

from __future__ import annotations

import functools
import inspect
import json
import keyword
import textwrap
from typing import Any

from . import _mimesh
from ._document import Document
from ._kinds import KINDS
from ._stages import Stage

MODULES = {
    "clusterer": "clusterers",
    "correspondence": "correspondences",
    "deformer": "deformers",
    "format": "formats",
    "generator": "generators",
    "key_points": "key_points",
    "landmarks": "landmarks",
    "metric": "metrics",
    "proximity": "proximity",
    "sampler": "samplers",
    "transfer": "transfers",
    "weights": "weights",
}
"""The module that has the stages of a kind."""


def registry() -> list[dict[str, Any]]:
    """Every stage that is known: ``kind``, ``type``, ``description``, JSON ``schema`` and ``defaults`` of its settings."""
    entries: list[dict[str, Any]] = json.loads(_mimesh.registry())
    return entries


@functools.lru_cache(maxsize=1)
def _linked() -> tuple[dict[str, Any], ...]:
    return tuple(registry())


class LinkedStage(Stage):
    """A stage that is compiled into mimesh."""

    _linked = True
    _schema: dict[str, Any] = {}
    _defaults: dict[str, Any] = {}

    def __init__(self, **settings: Any) -> None:
        self._given: dict[str, Any] = Document().value(settings)
        _mimesh.check_stage(self.kind, self._json())

    @property
    def settings(self) -> dict[str, Any]:
        """The settings, with defaults."""
        return {**self._defaults, **self._given}

    def to_dict(self) -> dict[str, Any]:
        """The stage as a pipeline has it."""
        return {"type": self.type, **self._given}

    def __eq__(self, other: object) -> bool:
        return isinstance(other, LinkedStage) and type(self) is type(other) and self.settings == other.settings

    def __hash__(self) -> int:
        return hash((self.kind, self._json()))

    def __repr__(self) -> str:
        given = ", ".join(f"{key}={value!r}" for key, value in self._given.items())
        return f"{type(self).__name__}({given})"


def class_name(name: str) -> str:
    """The name of the class of a type, e.g. ``FarthestPoint`` of ``farthest_point``."""
    return "".join(part[:1].upper() + part[1:] for part in name.split("_"))


def install(names: dict[str, Any], kind: str) -> None:
    """Puts the classes of a kind into the names of a module."""
    base = next(each for each in KINDS if each.kind == kind)
    made = [_class(base, entry, names["__name__"]) for entry in _linked() if entry["kind"] == kind]
    names.update({each.__name__: each for each in made})
    names["__all__"] = sorted(each.__name__ for each in made)


def _class(base: type[Stage], entry: dict[str, Any], module: str) -> type[LinkedStage]:
    settings = entry["schema"].get("properties", {})
    named = inspect.Parameter.KEYWORD_ONLY
    defaults = entry["defaults"]
    parameters = [inspect.Parameter(key, named, default=defaults.get(key)) for key in settings if key.isidentifier() and not keyword.iskeyword(key)]
    body: dict[str, Any] = {
        "__doc__": documentation(entry),
        "__module__": module,
        "_linked": True,
        "_schema": entry["schema"],
        "_defaults": defaults,
        "type": entry["type"],
        "__signature__": inspect.Signature(parameters),
    }
    return type(class_name(entry["type"]), (LinkedStage, base), body)


def documentation(entry: dict[str, Any]) -> str:
    """The description of a stage with its settings."""
    lines = [entry["description"].strip()]
    settings = entry["schema"].get("properties", {})
    if settings:
        lines += ["", "Args:"]
    for key, schema in settings.items():
        default = entry["defaults"].get(key)
        text = " ".join(str(schema.get("description", "")).split())
        told = "" if default is None else f" Default: ``{json.dumps(default, ensure_ascii=False)}``."
        lines += textwrap.wrap(f"{key}: {text}{told}", 120, initial_indent="    ", subsequent_indent="        ")
    return "\n".join(lines)


def describe(kind: str | None = None, type: str | None = None) -> str:
    """What there is: the kinds and types of all stages, those of one kind, or the settings of one type."""
    entries = [entry for entry in registry() if kind in (None, entry["kind"]) and type in (None, entry["type"])]
    if type is not None:
        return "\n\n".join(f"{entry['kind']} {entry['type']}\n\n{documentation(entry)}" for entry in entries)
    lines: list[str] = []
    for entry in entries:
        if not lines or lines[-1] and not any(line == entry["kind"] for line in lines):
            lines += [entry["kind"]] if not lines else ["", entry["kind"]]
        lines.append(f"  {entry['type']}: {entry['description'].split(chr(10) * 2)[0].splitlines()[0]}")
    return "\n".join(lines)
