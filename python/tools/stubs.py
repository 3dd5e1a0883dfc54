#!/usr/bin/env python3
"""Writes the stubs of the modules of stages (`samplers.pyi` and so on) from the registry of the installed mimesh.

    python/tools/stubs.py            writes them beside the package's sources
    python/tools/stubs.py --check    fails if those that are there are out of date
"""

from __future__ import annotations

import argparse
import json
import keyword
import sys
from pathlib import Path
from typing import Any

import mimesh
from mimesh._registry import MODULES, class_name

BASES = {cls.kind: cls.__name__ for cls in mimesh._kinds.KINDS}
PACKAGE = Path(__file__).resolve().parents[1] / "python" / "mimesh"
HEAD = "# Written by tools/stubs.py.\n"


def python_type(schema: Any) -> str:
    """The type of a setting, as a stub has it."""
    if not isinstance(schema, dict):
        return "Any"
    if "x-stage" in schema:
        return f"{BASES[schema['x-stage']]} | Mapping[str, Any]"
    if "const" in schema:
        return f"Literal[{json.dumps(schema['const'])}]"
    words = schema.get("enum")
    if words and all(isinstance(word, str) for word in words):
        return "Literal[" + ", ".join(json.dumps(word) for word in words) + "]"
    for alternatives in ("oneOf", "anyOf"):
        if alternatives in schema:
            kinds: list[str] = []
            for one in schema[alternatives]:
                kind = python_type(one)
                kinds += [kind] if kind not in kinds else []
            return "Any" if "Any" in kinds else merged(kinds)
    kind = schema.get("type")
    if isinstance(kind, list):
        return merged([python_type({**schema, "type": one}) for one in kind])
    if kind == "array":
        items = schema.get("items") if isinstance(schema.get("items"), dict) else {}
        return f"Sequence[{python_type(items)}]"
    simple = {"number": "float", "integer": "int", "boolean": "bool", "null": "None", "object": "Mapping[str, Any]"}
    if kind == "string":
        return "str | os.PathLike[str]" if schema.get("x-file") else "str"
    return simple.get(str(kind), "Any")


def merged(kinds: list[str]) -> str:
    """A union, its words in one `Literal`."""
    words = [kind[len("Literal[") : -1] for kind in kinds if kind.startswith("Literal[")]
    others = [kind for kind in kinds if not kind.startswith("Literal[") and kind != "None"]
    parts = others + ([f"Literal[{', '.join(words)}]"] if words else []) + (["None"] if "None" in kinds else [])
    return " | ".join(parts)


def stub(kind: str, entries: list[dict[str, Any]]) -> str:
    """The stub of a module."""
    classes = []
    used = {BASES[kind]}
    for entry in entries:
        settings = entry["schema"].get("properties", {})
        lines = ["        self,"]
        lines += ["        *,"] if settings else []
        for key, schema in settings.items():
            if keyword.iskeyword(key):
                continue
            declared = python_type(schema)
            if entry["defaults"].get(key) is None and "None" not in declared and declared != "Any":
                declared += " | None"
            lines.append(f"        {key}: {declared} = ...,")
            used |= {base for base in BASES.values() if f"{base} |" in declared}
        if any(keyword.iskeyword(key) for key in settings):
            lines.append("        **settings: Any,")
        doc = entry["description"].strip().split("\n\n")[0].replace("\n", " ").replace("\\", "\\\\")
        classes.append(
            f'class {class_name(entry["type"])}(LinkedStage, {BASES[kind]}):\n    """{doc}"""\n\n    def __init__(\n'
            + "\n".join(lines)
            + "\n    ) -> None: ...\n"
        )
    body = "\n".join(classes)
    imports = ["import os\n"] if "os." in body else []
    names = [name for name in ("Mapping", "Sequence") if name + "[" in body]
    imports += [f"from collections.abc import {', '.join(names)}\n"] if names else []
    names = [name for name in ("Any", "Literal") if name in body]
    imports += [f"from typing import {', '.join(names)}\n"] if names else []
    own = f"from ._kinds import {', '.join(sorted(used))}\nfrom ._registry import LinkedStage\n"
    return HEAD + "".join(imports) + ("\n" if imports else "") + own + "\n" + body


def main() -> int:
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--check", action="store_true", help="write nothing")
    arguments.add_argument("--folder", type=Path, default=PACKAGE, help="the folder of the package")
    given = arguments.parse_args()
    written = {(kind, name) for kind, name in mimesh._stages._written}
    entries = [entry for entry in mimesh.registry() if (entry["kind"], entry["type"]) not in written]
    stale = []
    for kind, module in MODULES.items():
        file = given.folder / f"{module}.pyi"
        text = stub(kind, [entry for entry in entries if entry["kind"] == kind])
        if given.check:
            stale += [file.name] if not file.exists() or file.read_text() != text else []
        else:
            file.write_text(text)
    if stale:
        print(f"out of date: {', '.join(stale)}; run python/tools/stubs.py", file=sys.stderr)
    return 1 if stale else 0


if __name__ == "__main__":
    sys.exit(main())
