"""The zip: rules of the manifest, equal bytes, and Blender's own judgement and installation."""

import importlib.util
import os
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import bpy
import pytest

BLENDER = Path(__file__).resolve().parents[1]
SPEC = importlib.util.spec_from_file_location("build_extension", BLENDER / "build.py")
build = importlib.util.module_from_spec(SPEC)
SPEC.loader.exec_module(build)

WHEEL = os.environ.get("MIMESH_WHEEL")
CHECKER = Path(bpy.utils.system_resource("SCRIPTS")) / "addons_core/bl_pkg/cli/blender_ext.py"

INSTALL = """
import os, sys, bpy, addon_utils
addon_utils.enable("bl_pkg")
assert bpy.ops.extensions.package_install_files(filepath=sys.argv[1], repo="user_default", enable_on_install=True) == {"FINISHED"}
module = sys.modules["bl_ext.user_default.mimesh"]
assert hasattr(bpy.types, "MIMESH_OT_transfer") and hasattr(bpy.types.Scene, "mimesh")
addon_utils.disable("bl_ext.user_default.mimesh")
assert not hasattr(bpy.types, "MIMESH_OT_transfer") and not hasattr(bpy.types.Scene, "mimesh")
print("INSTALLED", module.__file__, flush=True)
# Blender as a module may hang while Python ends.
os._exit(0)
"""


def stub(folder: Path, tag: str) -> Path:
    """A file with the name of a wheel."""
    path = folder / f"mimesh-0.1.0-cp310-abi3-{tag}.whl"
    path.write_bytes(tag.encode())
    return path


def test_the_zip_names_its_wheels_and_platforms(tmp_path):
    tags = ("manylinux_2_28_x86_64", "macosx_11_0_arm64", "win_amd64", "macosx_10_12_x86_64", "manylinux_2_28_aarch64")
    made = build.build([stub(tmp_path, tag) for tag in tags], tmp_path / "out")
    with zipfile.ZipFile(made) as archive:
        manifest = tomllib.loads(archive.read("blender_manifest.toml").decode())
        assert {name.removeprefix("./") for name in manifest["wheels"]} == {n for n in archive.namelist() if n.startswith("wheels/")}
        assert {"__init__.py", "LICENSE-MIT", "LICENSE-APACHE"} <= set(archive.namelist())
        modules = {path.name for path in (BLENDER / "mimesh_blender").glob("*.py")}
        assert modules <= set(archive.namelist())
    assert manifest["platforms"] == ["linux-arm64", "linux-x64", "macos-arm64", "macos-x64", "windows-x64"]
    assert made.name == f"mimesh-{manifest['version']}.zip"
    assert build.problems(manifest) == []


def test_equal_sources_give_equal_bytes(tmp_path):
    wheel = stub(tmp_path, "win_amd64")
    first = build.build([wheel], tmp_path / "one").read_bytes()
    os.utime(wheel, (0, 10**9))
    assert build.build([wheel], tmp_path / "two").read_bytes() == first


@pytest.mark.parametrize(
    ("key", "value", "said"),
    [
        ("tagline", "Ends with a stop.", "tagline"),
        ("tagline", "x" * 65, "tagline"),
        ("id", "two__lines", "id"),
        ("version", "1.0", "version"),
        ("license", ["MIT"], "SPDX"),
        ("tags", ["Deform"], "Deform"),
        ("permissions", {"disk": "Why"}, "disk"),
        ("maintainer", "", "maintainer is missing"),
    ],
)
def test_broken_rules_are_named(key, value, said):
    manifest = tomllib.loads((BLENDER / "mimesh_blender/blender_manifest.toml").read_text())
    assert build.problems(manifest) == []
    assert any(said in problem for problem in build.problems({**manifest, key: value}))


def test_wheels_that_no_blender_takes_are_refused(tmp_path):
    with pytest.raises(SystemExit, match="no platform for the tag any"):
        build.build([stub(tmp_path, "any")], tmp_path)
    with pytest.raises(SystemExit, match="there is no mimesh-none.whl"):
        build.build([tmp_path / "mimesh-none.whl"], tmp_path)


def test_blender_finds_it_valid(tmp_path):
    made = build.build([stub(tmp_path, "manylinux_2_28_x86_64")], tmp_path)
    done = subprocess.run([sys.executable, CHECKER, "validate", made], capture_output=True, text=True)
    assert done.returncode == 0 and "Success" in done.stdout, done.stdout + done.stderr


@pytest.mark.skipif(not WHEEL, reason="MIMESH_WHEEL names no wheel of mimesh")
def test_blender_installs_it_with_its_wheel(tmp_path):
    made = build.build([Path(WHEEL)], tmp_path)
    environment = {**os.environ, "BLENDER_USER_RESOURCES": str(tmp_path / "user")}
    done = subprocess.run([sys.executable, "-c", INSTALL, made], capture_output=True, text=True, env=environment)
    assert "INSTALLED" in done.stdout, done.stdout + done.stderr
    assert list((tmp_path / "user").glob("extensions/.local/lib/python*/site-packages/mimesh/__init__.py"))
