"""The package itself: stubs, types, documentation, examples, notebooks."""

from __future__ import annotations

import doctest
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import mimesh

PYTHON = Path(__file__).resolve().parents[1]


def run(*command: object, cwd: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, *map(str, command)], capture_output=True, text=True, cwd=cwd, timeout=600)


def test_stubs_are_those_of_the_registry() -> None:
    folder = Path(mimesh.__file__).parent
    checked = run(PYTHON / "tools" / "stubs.py", "--check", "--folder", folder, cwd=PYTHON)
    assert checked.returncode == 0, checked.stderr


def test_the_package_and_the_examples_have_types(tmp_path) -> None:
    options = ["-m", "mypy", "--strict", "--config-file", PYTHON / "pyproject.toml", "--cache-dir", tmp_path]
    for what in (["-p", "mimesh"], sorted((PYTHON / "examples").glob("*.py"))):
        checked = run(*options, *what, cwd=tmp_path)
        assert checked.returncode == 0, checked.stdout


@pytest.mark.parametrize("example", sorted((PYTHON / "examples").glob("*.py")), ids=lambda path: path.stem)
def test_examples_run(example, tmp_path) -> None:
    ran = run(example, cwd=tmp_path)
    assert ran.returncode == 0, ran.stderr


def test_the_notebook_runs(tmp_path) -> None:
    nbformat, nbclient = pytest.importorskip("nbformat"), pytest.importorskip("nbclient")
    shutil.copy(PYTHON / "examples" / "transfer.ipynb", tmp_path)
    notebook = nbformat.read(tmp_path / "transfer.ipynb", as_version=4)
    nbclient.NotebookClient(notebook, timeout=300, kernel_name="python3", resources={"metadata": {"path": tmp_path}}).execute()
    shown = [output for cell in notebook.cells for output in cell.get("outputs", []) if "text/html" in output.get("data", {})]
    assert sum("data:image/png" in output["data"]["text/html"] for output in shown) >= 2


@pytest.mark.parametrize("page", [PYTHON / "README.md", PYTHON.parent / "README.md"], ids=["python", "repository"])
def test_the_example_of_the_readme_runs(page, tmp_path, horse, camel) -> None:
    blocks = re.findall(r"```python\n(.*?)```", page.read_text(), flags=re.DOTALL)
    assert blocks
    horse.save(tmp_path / "horse.glb"), camel.save(tmp_path / "camel.obj")
    for i, block in enumerate(blocks):
        (tmp_path / f"block_{i}.py").write_text(block)
        ran = run(tmp_path / f"block_{i}.py", cwd=tmp_path)
        assert ran.returncode == 0, f"{block}\n{ran.stderr}"


def test_examples_in_the_documentation_run() -> None:
    for module in (mimesh._mesh, mimesh._stages):
        failed, tried = doctest.testmod(module)
        assert failed == 0 and tried > 0


def test_the_documentation_has_every_name() -> None:
    # A union has no documentation of its own.
    for name in set(mimesh.__all__) - {"MeshLike"}:
        assert getattr(mimesh, name).__doc__, name
