"""Pipelines from Python and from the command line."""

from __future__ import annotations

import hashlib
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import mimesh

PIPELINE = """
source:
  generator: { type: quadruped, proportions: horse, gait: gallop, frames: 3, resolution: 30 }
target:
  generator: { type: quadruped, proportions: camel, gait: gallop, frames: 3, resolution: 34, seed: 1 }
correspondence: { type: nonrigid_fit }
transfer: { type: gradient }
output: [ "out/{pose}.obj", out/all.glb, out/report.html ]
"""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "gallop.yaml"
    path.write_text(PIPELINE)
    return path


def command(*arguments: object, cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
    line = [sys.executable, "-m", "mimesh", *map(str, arguments)]
    return subprocess.run(line, capture_output=True, text=True, cwd=cwd, timeout=300)


def hashes(folder: Path) -> dict[str, str]:
    files = [path for path in folder.iterdir() if path.suffix in (".obj", ".glb")]
    return {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in sorted(files)}


def test_a_run_writes_the_bytes_that_the_command_line_writes(file, tmp_path) -> None:
    ran = command("run", file, "--no-cache", "--out", tmp_path / "cli")
    assert ran.returncode == 0, ran.stderr
    result = mimesh.Pipeline.from_file(file).run(out=tmp_path / "python")
    assert result.status == "done" and result.verdict == result.report["verdict"]
    assert hashes(tmp_path / "python") == hashes(tmp_path / "cli") != {}
    assert {path.name for path in result.outputs} == {path.name for path in (tmp_path / "cli").iterdir()} - {"run.json"}
    written = json.loads((tmp_path / "python" / "run.json").read_text())
    assert written["poses"][0]["metrics"] == result.report["poses"][0]["metrics"]
    in_cli = json.loads((tmp_path / "cli" / "run.json").read_text())
    assert [pose["metrics"] for pose in in_cli["poses"]] == [pose["metrics"] for pose in written["poses"]]


def test_a_text_and_a_mapping_are_pipelines_too(file, tmp_path, monkeypatch, horse, camel) -> None:
    monkeypatch.chdir(tmp_path)
    by_text = mimesh.Pipeline.from_yaml(PIPELINE).run(set=["output=[text/all.glb]"])
    assert [path.name for path in by_text.outputs] == ["all.glb"]
    by_mapping = mimesh.Pipeline.from_dict(
        {
            "source": {"rest": horse},
            "target": {"rest": mimesh.Mesh(camel.vertices, camel.faces)},
            "correspondence": mimesh.correspondences.Nearest(),
            "transfer": {"type": "copy_displacement"},
            "output": ["mapping/{pose}.ply"],
        }
    ).run()
    assert len(by_mapping.outputs) == len(horse.poses) and all(path.exists() for path in by_mapping.outputs)


def test_a_good_pipeline_has_no_diagnostics_and_a_plan(file, tmp_path) -> None:
    pipeline = mimesh.Pipeline.from_file(file)
    assert pipeline.check() == []
    plan = pipeline.plan(cache=tmp_path / "cache")
    assert [step["stage"] for step in plan["steps"]] == ["correspondence", "transfer", "poses"]
    assert {step["action"] for step in plan["steps"]} == {"run"}
    pipeline.run(cache=tmp_path / "cache")
    again = pipeline.plan(cache=tmp_path / "cache")
    assert {step["action"] for step in again["steps"]} == {"reuse"}


def test_mistakes_have_places_and_hints(file) -> None:
    file.write_text(PIPELINE.replace("gradient }", "gradiant }").replace("resolution: 30", "resolution: 1"))
    told = mimesh.Pipeline.from_file(file).check()
    by_line = {one.line: one for one in told}
    assert set(by_line) == {3, 7}
    assert (by_line[7].column, by_line[7].kind, by_line[7].file) == (19, "bad_pipeline", str(file))
    assert by_line[7].message == "unknown transfer `gradiant`" and by_line[7].hint == "did you mean `gradient`?"
    with pytest.raises(mimesh.BadPipelineError) as refused:
        mimesh.Pipeline.from_file(file).run()
    assert list(refused.value.diagnostics) == told
    assert "gallop.yaml:7:19" in str(refused.value)


def test_ways_out_are_words_of_python(file, tmp_path) -> None:
    told = mimesh.Pipeline.from_file(file).check(set=["transfer.typ=gradient"])
    assert told[0].option == "transfer.typ=gradient"
    assert all("--" not in (one.hint or "") for one in told)
    commands = {"type": "external", "command": ["true"]}
    with pytest.raises(mimesh.Error) as refused:
        mimesh.Pipeline.from_yaml(PIPELINE).run(set=[f"markers={json.dumps(commands)}"], out=tmp_path)
    assert "allow_commands=True" in str(refused.value)


def test_several_runs_and_their_failures(file, tmp_path) -> None:
    text = PIPELINE.replace("out/", "out/{matrix}/") + "matrix: { transfer.type: [gradient, copy_displacement] }\n"
    file.write_text(text)
    result = mimesh.Pipeline.from_file(file).run(out=tmp_path / "runs")
    assert [run["name"] for run in result.runs] and len(result.reports) == 2 and len(result.table) == 3
    with pytest.raises(mimesh.Error, match="2 runs"):
        _ = result.report
    assert set(mimesh.Pipeline.from_file(file).plan()) == {run["name"] for run in result.runs}


def test_the_exceptions_are_those_of_python_too(tmp_path) -> None:
    assert issubclass(mimesh.MissingInputError, FileNotFoundError)
    assert issubclass(mimesh.CannotWriteError, OSError)
    assert issubclass(mimesh.OutOfMemoryError, MemoryError)
    assert issubclass(mimesh.UsageError, ValueError)
    for kind in ("BadPipelineError", "BadDataError", "BusyError", "InternalError"):
        assert issubclass(getattr(mimesh, kind), mimesh.Error)
    with pytest.raises(mimesh.MissingInputError):
        mimesh.Pipeline.from_file(tmp_path / "none.yaml").run()
    locked = tmp_path / "file"
    locked.write_text("")
    with pytest.raises(mimesh.CannotWriteError):
        mimesh.Pipeline.from_yaml(PIPELINE).run(out=locked / "below")


def test_the_command_has_every_subcommand(tmp_path) -> None:
    assert "mimesh" in command("--version").stdout
    listed = json.loads(command("list", "sampler", "--json").stdout)
    assert "farthest_point" in [one["type"] for one in listed]
    assert command("run", tmp_path / "none.yaml").returncode == 66
    assert command("nonsense").returncode == 2


def test_known_results_are_metrics_of_the_mesh(camel) -> None:
    moved = camel.vertices + np.array([0.1, 0.0, 0.0])
    exact = mimesh.metrics.PointError().measure(camel, moved, truth=moved)
    assert exact["mean"] == 0
    off = mimesh.metrics.PointError().measure(camel, camel.vertices, truth=moved)
    diagonal = np.linalg.norm(np.ptp(camel.vertices, axis=0))
    assert off["placed"] == pytest.approx(10 / diagonal, rel=1e-9)
