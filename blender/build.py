#!/usr/bin/env python3
"""Makes the extension: `python blender/build.py --wheel dist/*.whl --out dist` writes `dist/mimesh-VERSION.zip`.

The manifest is checked, and gets the lists of wheels and of the platforms that they are for. Equal sources and wheels give equal bytes.
"""

from __future__ import annotations

import argparse
import re
import sys
import tomllib
import zipfile
from pathlib import Path
from typing import Any

SOURCES = Path(__file__).resolve().parent / "mimesh_blender"
LICENCES = ("LICENSE-MIT", "LICENSE-APACHE")
REQUIRED = ("schema_version", "id", "version", "name", "tagline", "maintainer", "type", "license", "blender_version_min")
TAGS = {
    "3D View", "Add Curve", "Add Mesh", "Animation", "Bake", "Camera", "Compositing", "Development", "Game Engine",
    "Geometry Nodes", "Grease Pencil", "Import-Export", "Lighting", "Material", "Mesh", "Modeling", "Node", "Object", "Paint",
    "Physics", "Pipeline", "Render", "Rigging", "Scene", "Sculpt", "Sequencer", "System", "Text Editor", "Tracking", "UV",
    "User Interface",
}  # fmt: skip
PERMISSIONS = {"files", "network", "clipboard", "camera", "microphone"}
# The oldest time that a zip can hold.
EPOCH = (1980, 1, 1, 0, 0, 0)


def platform_of(wheel: str) -> str:
    """Blender's name of the platform that a wheel is for."""
    tag = wheel.removesuffix(".whl").split("-")[-1].split(".")[-1]
    kinds = {r"win_amd64": "windows-x64", r"win_arm64": "windows-arm64"}
    for start, name in (("macosx", "macos"), (r"(?:many|musl)?linux", "linux")):
        kinds[rf"{start}_.*x86_64"], kinds[rf"{start}_.*(?:arm64|aarch64)"] = f"{name}-x64", f"{name}-arm64"
    for pattern, name in kinds.items():
        if re.fullmatch(pattern, tag):
            return name
    raise SystemExit(f"{wheel}: Blender has no platform for the tag {tag}")


def problems(manifest: dict[str, Any]) -> list[str]:
    """What breaks the rules of the schema 1.0.0 of Blender's extensions."""
    found = [f"{key} is missing" for key in REQUIRED if not manifest.get(key)]
    if manifest.get("schema_version") != "1.0.0":
        found.append("schema_version: expected 1.0.0")
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9]*(_[A-Za-z0-9]+)*", manifest.get("id", "")):
        found.append("id: expected a name of Python without double or final underscores")
    for key in ("version", "blender_version_min"):
        if not re.fullmatch(r"\d+\.\d+\.\d+(-[0-9A-Za-z.-]+)?", manifest.get(key, "")):
            found.append(f"{key}: expected three numbers")
    if manifest.get("type") != "add-on":
        found.append("type: expected add-on")
    texts = {"tagline": manifest.get("tagline", ""), **manifest.get("permissions", {})}
    for key, text in texts.items():
        if not 0 < len(text) <= 64 or "\n" in text or not (text[-1].isalnum() or text[-1] in ")]}"):
            found.append(f"{key}: expected one line of at most 64 characters without punctuation at its end")
    found += [f"tags: {tag} is none of Blender's" for tag in manifest.get("tags", []) if tag not in TAGS]
    found += [f"permissions: {key} is none of Blender's" for key in manifest.get("permissions", {}) if key not in PERMISSIONS]
    found += [f"license: expected SPDX: before {one}" for one in manifest.get("license", []) if not one.startswith("SPDX:")]
    holders = manifest.get("copyright", [])
    found += [f"copyright: expected a year before {one}" for one in holders if not re.match(r"\d{4}(-\d{4})? \S", one)]
    return found


def manifest_text(wheels: list[str]) -> str:
    """The manifest of the sources with wheels and platforms; refuses one that breaks the rules."""
    text = (SOURCES / "blender_manifest.toml").read_text(encoding="utf-8")
    lists = {
        "platforms": sorted({platform_of(wheel) for wheel in wheels}),
        "wheels": [f"./wheels/{wheel}" for wheel in sorted(wheels)],
    }
    # Keys of the file itself stand before its first table.
    head, table, rest = text.partition("\n[")
    for key, values in lists.items():
        head += f"\n{key} = [\n" + "".join(f'  "{value}",\n' for value in values) + "]\n"
    text = head + table + rest
    found = problems(tomllib.loads(text))
    if found:
        raise SystemExit("blender_manifest.toml:\n" + "\n".join(f"  {problem}" for problem in found))
    return text


def build(wheels: list[Path], out: Path) -> Path:
    """Writes the zip; its path."""
    wheels = sorted({wheel.resolve() for wheel in wheels})
    missing = [wheel.name for wheel in wheels if not wheel.is_file()]
    if missing:
        raise SystemExit(f"there is no {missing[0]}")
    names = [wheel.name for wheel in wheels]
    if not names or not all(re.fullmatch(r"mimesh-.*\.whl", name) for name in names):
        raise SystemExit("expected wheels of mimesh")
    text = manifest_text(names)
    contents = {"blender_manifest.toml": text.encode()}
    contents |= {path.name: path.read_bytes() for path in SOURCES.glob("*.py")}
    contents |= {name: (SOURCES.parents[1] / name).read_bytes() for name in LICENCES}
    contents |= {f"wheels/{wheel.name}": wheel.read_bytes() for wheel in wheels}
    out.mkdir(parents=True, exist_ok=True)
    path = out / f"mimesh-{tomllib.loads(text)['version']}.zip"
    with zipfile.ZipFile(path, "w") as archive:
        for name in sorted(contents):
            info = zipfile.ZipInfo(name, EPOCH)
            info.external_attr = 0o644 << 16
            info.create_system = 3
            # Wheels are compressed already.
            info.compress_type = zipfile.ZIP_STORED if name.endswith(".whl") else zipfile.ZIP_DEFLATED
            archive.writestr(info, contents[name])
    return path


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--wheel", type=Path, nargs="+", required=True, help="wheels of mimesh, one a platform")
    parser.add_argument("--out", type=Path, default=Path("dist"), help="folder of the zip")
    arguments = parser.parse_args()
    print(build(arguments.wheel, arguments.out))


if __name__ == "__main__":
    sys.exit(main())
