"""Stages: objects with settings, which pipelines and transfers take and which can be called alone."""

from __future__ import annotations

import dataclasses
import functools
import hashlib
import importlib.util
import inspect
import json
import os
import sys
import traceback
import types
import typing
from collections.abc import Callable
from typing import Any, ClassVar

from . import _mimesh
from ._document import Document
from ._errors import misuse, remember_cause

#: The classes that are written in Python, by kind and name.
_written: dict[tuple[str, str], type[Stage]] = {}

#: Whether failures are printed, as the command line wants them.
_prints_failures = False


class Stage:
    """A stage of a pipeline: settings, and what they do.

    A subclass with a ``name`` is a stage of that name. Its settings are the fields of its dataclass, each with a default:

    >>> from dataclasses import dataclass
    >>> import mimesh
    >>> @dataclass
    ... class EveryNth(mimesh.Sampler, name="every_nth"):
    ...     "Takes every n-th vertex."
    ...     step: int = mimesh.setting(10, "How many vertices apart.", minimum=1)
    ...     def sample(self, surface):
    ...         return range(0, len(surface.vertices), self.step)
    """

    kind: ClassVar[str] = ""
    """The kind of stage, as pipelines call it."""
    type: ClassVar[str] = ""
    """The ``type`` in YAML."""
    _methods: ClassVar[tuple[str, ...]] = ()

    def __init_subclass__(cls, *, name: str | None = None, **arguments: Any) -> None:
        super().__init_subclass__(**arguments)
        name = name if name is not None else cls.__dict__.get("type")
        if name is None or "_linked" in cls.__dict__:
            return
        cls.type = name
        base: Any = next(parent for parent in cls.__mro__[1:] if "_methods" in parent.__dict__)
        for method in base._methods:
            own = cls.__dict__.get(method)
            if own is not None and not hasattr(own, "_is_dispatching"):
                setattr(cls, method, _dispatching(own, getattr(base, method)))
        # A class that is made anew, as by `@dataclass(slots=True)`, is one already.
        made = cls if "__dataclass_fields__" in cls.__dict__ else dataclasses.dataclass(cls)
        register(made)

    @property
    def settings(self) -> dict[str, Any]:
        """The settings, with defaults."""
        return {field.name: getattr(self, field.name) for field in dataclasses.fields(self)}  # type: ignore[arg-type]

    def to_dict(self) -> dict[str, Any]:
        """The stage as a pipeline has it."""
        return {"type": self.type, **self.settings}

    def _json(self) -> str:
        return json.dumps(Document().value(self.to_dict()))


def _dispatching(own: Callable[..., Any], of_base: Callable[..., Any]) -> Callable[..., Any]:
    """A method of a stage in Python, which for meshes is called as every stage is: with surfaces, and in the mesh's numbering."""
    from ._mesh import Mesh

    @functools.wraps(own)
    def method(self: Any, *arguments: Any, **named: Any) -> Any:
        if arguments and isinstance(arguments[0], Mesh):
            return of_base(self, *arguments, **named)
        return own(self, *arguments, **named)

    method._is_dispatching = True  # type: ignore[attr-defined]
    return method


def setting(default: Any, doc: str, *, minimum: float | None = None, maximum: float | None = None) -> Any:
    """A setting of a stage in Python: its default, what it means, and the range of a number."""
    metadata = {"doc": doc, "minimum": minimum, "maximum": maximum}
    if isinstance(default, (list, dict, set)):
        return dataclasses.field(default_factory=lambda: type(default)(default), metadata=metadata)
    return dataclasses.field(default=default, metadata=metadata)


_JSON_TYPES: dict[Any, str] = {bool: "boolean", int: "integer", float: "number", str: "string", list: "array", dict: "object"}


def _schema_of_type(hint: Any) -> dict[str, Any]:
    origin = typing.get_origin(hint)
    if origin is typing.Literal:
        return {"type": "string", "enum": list(typing.get_args(hint))}
    if origin in (typing.Union, types.UnionType):
        parts = [_schema_of_type(part) for part in typing.get_args(hint) if part is not type(None)]
        if len(parts) == 1 and "type" in parts[0]:
            words = {"enum": [*parts[0]["enum"], None]} if "enum" in parts[0] else {}
            return {**parts[0], "type": [parts[0]["type"], "null"], **words}
        return {}
    if origin in (list, tuple) or hint in (list, tuple):
        return {"type": "array"}
    if origin is dict:
        return {"type": "object"}
    name = _JSON_TYPES.get(hint)
    return {} if name is None else {"type": name}


def _schema(cls: type[Stage]) -> tuple[dict[str, Any], dict[str, Any]]:
    """The JSON Schema of the settings of a class, and their defaults."""
    module = sys.modules.get(cls.__module__)
    try:
        hints = typing.get_type_hints(cls, vars(module) if module else None, {"Any": Any, "ClassVar": ClassVar})
    except NameError:
        hints = {}
    properties: dict[str, Any] = {}
    defaults: dict[str, Any] = {}
    for field in dataclasses.fields(cls):  # type: ignore[arg-type]
        if field.default is not dataclasses.MISSING:
            default = field.default
        elif field.default_factory is not dataclasses.MISSING:
            default = field.default_factory()
        else:
            raise misuse(f"the setting `{field.name}` of {cls.__name__} has no default", f"`{field.name}: … = …`")
        hint = hints.get(field.name, type(default))
        schema = {"description": field.metadata.get("doc") or f"{field.name.replace('_', ' ').capitalize()}."}
        schema.update(_schema_of_type(hint))
        limits = {key: field.metadata[key] for key in ("minimum", "maximum") if field.metadata.get(key) is not None}
        properties[field.name] = {**schema, **limits}
        defaults[field.name] = Document().value(default)
    doc = inspect.cleandoc(cls.__dict__.get("__doc__") or "")
    # The text that `dataclass` makes of the fields describes nothing.
    if not doc or doc.startswith(f"{cls.__name__}("):
        doc = f"The {cls.kind} `{cls.type}`, written in Python."
    return {"description": doc, "type": "object", "properties": properties, "additionalProperties": False}, defaults


def register(cls: type[Stage]) -> None:
    """Makes a class known by its name; one that had the name before gives way to it."""
    schema, defaults = _schema(cls)
    _mimesh.register_stage(cls.kind, cls.type, json.dumps(schema), json.dumps(defaults))
    _written[cls.kind, cls.type] = cls


def instance(kind: str, name: str, settings: str) -> Stage:
    """An object of the class that is registered as ``name``; the compiled part asks for it."""
    cls = _written.get((kind, name))
    if cls is None:
        raise misuse(f"no {kind} `{name}` is registered", "import the module that defines it first")
    given: dict[str, Any] = json.loads(settings)
    for field in dataclasses.fields(cls):  # type: ignore[arg-type]
        value = given.get(field.name)
        # YAML has `2` where a float is meant.
        if isinstance(value, int) and isinstance(field.default, float):
            given[field.name] = float(value)
        elif isinstance(value, float) and isinstance(field.default, int) and value.is_integer():
            given[field.name] = int(value)
    return cls(**given)


def report_failure(kind: str, name: str, error: BaseException) -> None:
    """Keeps what a stage raised for the exception of the call, and shows it on the command line."""
    remember_cause(error)
    if _prints_failures:
        print(f"{kind} `{name}`:", file=sys.stderr)
        traceback.print_exception(type(error), error, error.__traceback__)
        sys.stderr.flush()


def print_failures() -> None:
    """Shows what stages raise with their tracebacks, for the command line."""
    global _prints_failures
    _prints_failures = True


def load_file(path: str | os.PathLike[str]) -> None:
    """Runs a file that defines stages."""
    file = os.path.abspath(path)
    if not os.path.isfile(file):
        raise FileNotFoundError(f"no such file: {os.fspath(path)}")
    name = f"mimesh_stages_{hashlib.sha256(file.encode()).hexdigest()[:12]}"
    spec = importlib.util.spec_from_file_location(name, file)
    if spec is None or spec.loader is None:
        raise misuse(f"{os.fspath(path)} is no file of Python", "name a file that ends with .py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    try:
        spec.loader.exec_module(module)
    except Exception as error:
        if _prints_failures:
            traceback.print_exception(type(error), error, error.__traceback__)
        raise


def sources_hash() -> str:
    """The hash of the sources of all stages that are written in Python."""
    hasher = hashlib.sha256()
    for (kind, name), cls in sorted(_written.items()):
        hasher.update(f"{kind} {name}\0".encode())
        hasher.update(_source(cls))
    return hasher.hexdigest()


def _source(cls: type[Stage]) -> bytes:
    """The file that defines a class; of one that was typed in, its text or its code."""
    try:
        file = inspect.getsourcefile(cls)
        if file is not None and os.path.isfile(file):
            with open(file, "rb") as opened:
                return opened.read()
        return inspect.getsource(cls).encode()
    except (OSError, TypeError):
        code = [value.__code__ for value in vars(cls).values() if inspect.isfunction(value)]
        return b"\0".join(c.co_code + repr(c.co_consts).encode() for c in code)
