"""A pipeline with targets whose names mean something to shells, and what `mimesh run` makes of it."""

import os
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

import pytest

MIMESH = str(Path(os.environ.get("MIMESH", "target/release/mimesh")).resolve())
FRAMES = 12
CHUNK = 5
# Each name would do something if a script took it for more than a name.
TARGETS = ["camel", "$(touch stolen)", "a 'b' \"c\"", "`touch stolen`; x & y", "-n"]

PIPELINE = """
source: { generator: { type: quadruped, proportions: horse, gait: gallop, resolution: 12, frames: %d } }
targets:
%s
correspondence: { type: nonrigid_fit }
transfer: { type: gradient }
output: ["out/{target}/all.glb", "out/{target}/all.pc2", "out/{target}/{pose}.obj"]
"""


@dataclass
class Project:
    """A folder with a pipeline."""

    folder: Path

    def mimesh(self, *words: str, status: int | None = 0) -> subprocess.CompletedProcess[str]:
        done = subprocess.run([MIMESH, *words], cwd=self.folder, capture_output=True, text=True)
        assert status is None or done.returncode == status, f"{words}: {done.returncode}\n{done.stdout}\n{done.stderr}"
        return done

    def results(self) -> dict[str, bytes]:
        """All results but the reports, which hold times."""
        files = (file for file in (self.folder / "out").rglob("*") if file.is_file() and file.name != "run.json")
        return {str(file.relative_to(self.folder)): file.read_bytes() for file in files}

    def take(self) -> dict[str, bytes]:
        """The results, which are then removed."""
        results = self.results()
        shutil.rmtree(self.folder / "out", ignore_errors=True)
        return results

    def nothing_ran(self) -> None:
        """Checks that no name was taken for a command."""
        assert not list(self.folder.rglob("stolen")), "a name was run as a command"


@pytest.fixture(scope="session")
def whole(tmp_path_factory: pytest.TempPathFactory) -> tuple[Project, dict[str, bytes]]:
    """The project, and the results of a run that is not split."""
    project = Project(tmp_path_factory.mktemp("farm $(touch stolen)"))
    quoted = ("  '" + name.replace("'", "''") + "'" for name in TARGETS)
    generator = "generator: { type: quadruped, proportions: camel, resolution: 12, seed: %d }"
    targets = "\n".join(f"{name}: {{ {generator % seed} }}" for seed, name in enumerate(quoted))
    (project.folder / "herd.yaml").write_text(PIPELINE % (FRAMES, targets))
    project.mimesh("run", "herd.yaml", "--no-cache", "--quiet")
    expected = project.take()
    assert len(expected) == len(TARGETS) * (FRAMES + 2)
    return project, expected


@pytest.fixture
def project(whole: tuple[Project, dict[str, bytes]]) -> Project:
    """The project without results."""
    project = whole[0]
    project.take()
    shutil.rmtree(project.folder / "herd-job", ignore_errors=True)
    return project


@pytest.fixture
def expected(whole: tuple[Project, dict[str, bytes]]) -> dict[str, bytes]:
    """The results of a run that is not split."""
    return whole[1]
