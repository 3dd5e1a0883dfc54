"""Stages that are written in Python."""

from __future__ import annotations

import dataclasses
import subprocess
import sys
import textwrap
import time
from dataclasses import dataclass
from typing import Literal

import numpy as np
import pytest
import scipy.sparse
import scipy.sparse.linalg

import mimesh
from mimesh.testing import check_contract


@dataclass
class Spread(mimesh.Sampler, name="test_spread"):
    """Vertices spread evenly over a surface, straight through space."""

    count: int = mimesh.setting(20, "Number of points.", minimum=1)
    first: int = mimesh.setting(0, "The first vertex.", minimum=0)

    def sample(self, surface):
        components = surface.components
        chosen = [self.first]
        nearest = np.full(len(surface.vertices), np.inf)
        while len(chosen) < self.count:
            nearest = np.minimum(nearest, np.sqrt(((surface.vertices - surface.vertices[chosen[-1]]) ** 2).sum(axis=1)))
            # As long as a component has no point, the next is on such a one.
            without = ~np.isin(components, components[chosen])
            open_vertices = without & has_area(surface) if (without & has_area(surface)).any() else has_area(surface)
            chosen.append(int(np.argmax(np.where(open_vertices, nearest, -1.0))))
        return np.array(chosen)


def has_area(surface):
    a, b, c = (surface.vertices[surface.triangles[:, i]] for i in range(3))
    sizes = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    used = np.zeros(len(surface.vertices), dtype=bool)
    used[surface.triangles[sizes > 1e-12 * surface.diagonal**2].ravel()] = True
    return used


def cotangent_laplacian(surface):
    v, f = surface.vertices, surface.triangles.astype(np.int64)
    rows, columns, values = [], [], []
    for i in range(3):
        a, b, c = f[:, i], f[:, (i + 1) % 3], f[:, (i + 2) % 3]
        u, w = v[a] - v[c], v[b] - v[c]
        half = 0.5 * (u * w).sum(axis=1) / np.linalg.norm(np.cross(u, w), axis=1)
        rows += [a, b, a, b]
        columns += [b, a, a, b]
        values += [-half, -half, half, half]
    n = len(v)
    return scipy.sparse.csr_matrix((np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))), shape=(n, n))


class Heat(mimesh.Weights, name="test_heat"):
    """Weights that spread like heat between handles."""

    def solve(self, surface, handles, links):
        laplacian = cotangent_laplacian(surface)
        weights = np.zeros((len(surface.vertices), len(handles)))
        weights[handles, np.arange(len(handles))] = 1
        free = np.setdiff1d(np.arange(len(surface.vertices)), handles)
        solver = scipy.sparse.linalg.splu(laplacian[free][:, free].tocsc())
        weights[free] = solver.solve(-np.asarray((laplacian[free][:, handles]).todense()))
        return weights


class Shepard(mimesh.Weights, name="test_shepard"):
    """Weights by inverse distance within a component, straight through space."""

    power: float = mimesh.setting(2.0, "How fast weights fall off.", minimum=0.5, maximum=16)

    def solve(self, surface, handles, links):
        component = np.arange(surface.components.max() + 1)
        for a, b in links:
            one, other = component[surface.components[[a, b]]]
            component[component == other] = one
        group = component[surface.components]
        distance = np.linalg.norm(surface.vertices[:, None] - surface.vertices[handles], axis=2)
        distance = np.where(group[:, None] == group[handles], distance, np.inf)
        nearest = distance.min(axis=1, keepdims=True)
        with np.errstate(divide="ignore", invalid="ignore"):
            shares = np.where(distance == nearest, 1.0, (nearest / distance) ** self.power)
            weights = shares / shares.sum(axis=1, keepdims=True)
        weights[~np.isfinite(nearest[:, 0])] = 0
        weights[handles] = np.eye(len(handles))
        return weights


class Shift(mimesh.Transfer, name="test_shift"):
    """Moves the whole target by the mean displacement of the source."""

    needs_correspondence = False

    def bind(self, source, target, map, markers):
        rest, vertices = source.vertices.mean(axis=0), target.vertices
        return lambda posed: vertices + (posed.mean(axis=0) - rest)


class ByNumber(mimesh.Correspondence, name="test_by_number"):
    """Pairs triangles of one number."""

    def correspond(self, source, target, markers):
        return np.minimum(np.arange(len(target.triangles)), len(source.triangles) - 1)


class Corners(mimesh.Landmarks, name="test_corners"):
    """Pairs the vertices with the least and the greatest coordinates."""

    def propose(self, source, target, markers):
        taken = [{pair[i] for pair in markers} for i in range(2)]
        found = []
        for axis in range(3):
            for extreme in (np.argmin, np.argmax):
                pair = (int(extreme(source.vertices[:, axis])), int(extreme(target.vertices[:, axis])))
                if pair[0] not in taken[0] and pair[1] not in taken[1]:
                    taken[0].add(pair[0]), taken[1].add(pair[1])
                    found.append((*pair, 0.7))
        return found


class Growth(mimesh.Metric, name="test_growth"):
    """How much larger the result is than it should be."""

    statistics = (mimesh.Statistic("radius", "%", "How far the mean distance from the centre is off."),)
    needs_ground_truth = True

    def measure(self, surface, result, truth):
        radius = [np.linalg.norm(positions - positions.mean(axis=0), axis=1).mean() for positions in (result, truth)]
        return {"radius": 100 * abs(radius[0] - radius[1]) / surface.diagonal}


class Nearest(mimesh.Clusterer, name="test_nearest"):
    """Gives each vertex to its strongest handle."""

    def cluster(self, surface, poses, weights):
        return np.argmax(weights, axis=1)


class Rigid(mimesh.Deformer, name="test_rigid"):
    """One rigid motion for all handles."""

    def fit(self, surface, weights, regions, posed):
        rest, moved = surface.vertices.mean(axis=0), posed.mean(axis=0)
        u, _, vt = np.linalg.svd((posed - moved).T @ (surface.vertices - rest))
        turn = u @ np.diag([1, 1, np.linalg.det(u @ vt)]) @ vt
        return np.tile(np.column_stack([turn, moved - turn @ rest]), (weights.shape[1], 1, 1))


@pytest.mark.parametrize("stage", [Spread, Shepard, ByNumber, Corners, Growth, Nearest, Rigid])
def test_stages_in_python_keep_the_contracts(stage) -> None:
    check_contract(stage)


def test_what_breaks_its_contract_is_told() -> None:
    class Twice(mimesh.Sampler, name="test_twice"):
        """Gives the same vertex twice."""

        def sample(self, surface):
            return [3, 3]

    with pytest.raises(AssertionError, match="test_twice: two points at"):
        check_contract(Twice)
    # A shift alone is no rigid motion.
    with pytest.raises(AssertionError, match="test_shift"):
        check_contract(Shift)


def test_a_sampler_in_python_equals_the_same_in_rust(horse) -> None:
    linked = mimesh.samplers.FarthestPoint(count=60, metric="euclidean").sample(horse)
    surface = horse.surface
    first = int(surface.vertex_of[linked[0]])
    assert Spread(count=60, first=first).sample(horse) == linked
    # Called with a surface, it is what it is.
    own = Spread(count=60, first=first).sample(surface)
    assert isinstance(own, np.ndarray) and surface.representative[own].tolist() == linked


def test_weights_in_python_equal_the_same_in_rust(horse, grid) -> None:
    for mesh, handles in [(grid, [0, 11, 70, 143]), (mimesh.Mesh(horse.vertices, horse.faces), [5, 100, 200, 321])]:
        linked = mimesh.weights.Harmonic().solve(mesh, handles)
        written = Heat().solve(mesh, handles)
        np.testing.assert_allclose(written, linked, rtol=0, atol=1e-9)


def test_settings_are_a_dataclass_with_ranges() -> None:
    assert Spread(count=3).to_dict() == {"type": "test_spread", "count": 3, "first": 0}
    assert [field.name for field in dataclasses.fields(Shepard)] == ["power"]
    description = mimesh.describe("sampler", "test_spread")
    assert "Vertices spread evenly" in description and "count: Number of points. Default: ``20``." in description
    with pytest.raises(mimesh.UsageError, match="expected at least 1, found 0"):
        check_contract(Spread(count=0))

    @dataclass
    class Chosen(mimesh.Sampler, name="test_chosen"):
        """Takes one of few vertices."""

        which: Literal["first", "last"] = "first"

        def sample(self, surface):
            return [0 if self.which == "first" else len(surface.vertices) - 1]

    entry = next(one for one in mimesh.registry() if one["type"] == "test_chosen")
    assert entry["schema"]["properties"]["which"]["enum"] == ["first", "last"]
    with pytest.raises(mimesh.UsageError):

        class Lacking(mimesh.Sampler, name="test_lacking"):
            """Has a setting without a default."""

            count: int

    with pytest.raises(mimesh.BadDataError, match="already"):

        class Taken(mimesh.Sampler, name="farthest_point"):
            """Has a name that is taken."""


YAML = """
source: { generator: { type: quadruped, proportions: horse, gait: gallop, frames: 3, resolution: 24 } }
target: { generator: { type: quadruped, proportions: camel, gait: gallop, frames: 3, resolution: 24, seed: 1 } }
transfer: { type: biharmonic, weights: { type: test_shepard, power: 3 } }
output: [ "out/{pose}.obj" ]
"""


def test_yaml_names_them_and_their_settings_are_checked(tmp_path) -> None:
    result = mimesh.Pipeline.from_yaml(YAML).run(out=tmp_path)
    assert result.status == "done" and len(result.outputs) == 3
    told = mimesh.Pipeline.from_yaml(YAML.replace("power: 3", "pwoer: 3")).check()
    assert [one.message for one in told] == ["unknown key `pwoer`"] and told[0].line == 4
    assert told[0].hint == "did you mean `power`?"
    told = mimesh.Pipeline.from_yaml(YAML.replace("power: 3", "power: 99")).check()
    assert told[0].message == "`power`: expected 0.5 to 16, found 99"
    told = mimesh.Pipeline.from_yaml(YAML.replace("test_shepard", "test_shephard")).check()
    assert told[0].hint == "did you mean `test_shepard`?"


def test_transfers_take_them_as_objects(horse) -> None:
    moved = horse.with_vertices(horse.vertices + [0.0, 2.0, 0.0])
    result = mimesh.transfer(horse, moved, transfer=Shift(), metrics=[Growth()])
    for i in range(len(horse.poses)):
        shift = horse.surface.from_mesh(horse.pose(i)).mean(axis=0) - horse.surface.vertices.mean(axis=0)
        np.testing.assert_allclose(result.positions[i], moved.vertices + shift, atol=1e-9)
    by_number = mimesh.transfer(horse, moved, correspondence=ByNumber(), transfer="gradient", metrics=[])
    linked = mimesh.transfer(horse, moved, correspondence="identity", transfer="gradient", metrics=[])
    np.testing.assert_allclose(by_number.positions, linked.positions, atol=1e-6)


def test_metrics_in_python_stand_in_the_report(horse, tmp_path) -> None:
    text = YAML.replace("transfer:", "metrics: [{ type: test_growth }]\ntransfer:").replace("test_shepard, power: 3", "harmonic")
    report = mimesh.Pipeline.from_yaml(text).run(out=tmp_path).report
    radii = [pose["metrics"]["test_growth"]["radius"] for pose in report["poses"]]
    assert len(radii) == 3 and all(0 < radius < 5 for radius in radii)
    gate = mimesh.Pipeline.from_yaml(text + "gates: { test_growth: 1e-9 }\n").run(out=tmp_path)
    assert gate.status == "gate"
    assert report["settings"]["metrics"][0]["type"] == "test_growth" or any(
        metric["type"] == "test_growth" for metric in report["settings"]["metrics"]
    )


class Failing(mimesh.Weights, name="test_failing"):
    """Fails."""

    def solve(self, surface, handles, links):
        raise LookupError("the moon is not full")


def test_what_they_raise_comes_back_with_traceback_and_name(tmp_path) -> None:
    with pytest.raises(mimesh.Error) as raised:
        mimesh.Pipeline.from_yaml(YAML.replace("test_shepard, power: 3", "test_failing")).run(out=tmp_path)
    assert "weights `test_failing`, written in Python, raised LookupError: the moon is not full" in str(raised.value)
    cause = raised.value.__cause__
    assert isinstance(cause, LookupError)
    frames = [frame.name for frame in __import__("traceback").extract_tb(cause.__traceback__)]
    assert frames[-1] == "solve"
    assert not list(tmp_path.glob("*.obj"))


STAGES = '''
    from dataclasses import dataclass
    import numpy as np
    import mimesh

    @dataclass
    class Flat(mimesh.Weights, name="flat"):
        """The same weight for all handles."""

        sharpness: float = mimesh.setting(1.0, "How much nearer handles count more.", minimum=0)

        def solve(self, surface, handles, links):
            distance = np.linalg.norm(surface.vertices[:, None] - surface.vertices[handles], axis=2)
            weights = np.exp(-SHARP * self.sharpness * (distance / surface.diagonal) ** 2)
            weights /= weights.sum(axis=1, keepdims=True)
            weights[handles] = np.eye(len(handles))
            return weights
'''


def command(*arguments: object, cwd) -> subprocess.CompletedProcess[str]:
    line = [sys.executable, "-m", "mimesh", *map(str, arguments)]
    return subprocess.run(line, capture_output=True, text=True, cwd=cwd, timeout=300)


def test_the_command_loads_them_and_the_cache_knows_their_source(tmp_path) -> None:
    stages = tmp_path / "my_stages.py"
    stages.write_text(textwrap.dedent(STAGES).replace("SHARP", "1.0"))
    pipeline = tmp_path / "run.yaml"
    pipeline.write_text(YAML.replace("test_shepard, power: 3", "flat, sharpness: 2"))
    run = ("run", pipeline, "--python", stages, "--cache", tmp_path / "cache")
    assert "unknown weights `flat`" in command("run", pipeline, "--no-cache", cwd=tmp_path).stderr
    first = command(*run, cwd=tmp_path)
    assert first.returncode == 0, first.stderr
    one = (tmp_path / "out" / "gallop-01.obj") if (tmp_path / "out" / "gallop-01.obj").exists() else next(
        iter(sorted((tmp_path / "out").glob("*.obj")))
    )
    before = one.read_bytes()
    plan = command("plan", pipeline, "--python", stages, "--cache", tmp_path / "cache", cwd=tmp_path)
    assert "reuse" in plan.stdout
    stages.write_text(textwrap.dedent(STAGES).replace("SHARP", "50.0"))
    plan = command("plan", pipeline, "--python", stages, "--cache", tmp_path / "cache", cwd=tmp_path)
    assert "reuse" not in plan.stdout
    assert command(*run, cwd=tmp_path).returncode == 0
    assert one.read_bytes() != before
    shown = command("show", "weights", "flat", "--python", stages, cwd=tmp_path)
    assert "The same weight for all handles." in shown.stdout and "sharpness" in shown.stdout
    assert "flat" in command("list", "weights", "--python", stages, cwd=tmp_path).stdout
    assert '"const": "flat"' in command("schema", "--python", stages, cwd=tmp_path).stdout
    broken = tmp_path / "broken.py"
    broken.write_text("import mimesh\n\n1 / 0\n")
    failed = command("list", "--python", broken, cwd=tmp_path)
    assert failed.returncode == 65 and "ZeroDivisionError: division by zero" in failed.stderr
    assert f"{broken}:3" in failed.stderr and "Traceback" in failed.stderr
    missing = command("list", "--python", tmp_path / "none.py", cwd=tmp_path)
    assert missing.returncode == 66 and "none.py" in missing.stderr


def test_the_command_shows_tracebacks(tmp_path) -> None:
    stages = tmp_path / "my_stages.py"
    stages.write_text(textwrap.dedent(STAGES).replace("SHARP", "undefined_name"))
    pipeline = tmp_path / "run.yaml"
    pipeline.write_text(YAML.replace("test_shepard, power: 3", "flat"))
    failed = command("run", pipeline, "--python", stages, "--no-cache", cwd=tmp_path)
    assert failed.returncode == 65
    assert "NameError" in failed.stderr and "my_stages.py" in failed.stderr and "Traceback" in failed.stderr


def test_a_call_into_python_takes_little_time(grid, capsys) -> None:
    class Ends(mimesh.Sampler, name="test_ends"):
        """The first and the last vertex."""

        def sample(self, surface):
            return [0, len(surface.vertices) - 1]

    stage, calls = Ends(), 200
    started = time.perf_counter()
    for _ in range(calls):
        mimesh.Sampler.sample(stage, grid)
    milliseconds = 1e3 * (time.perf_counter() - started) / calls
    with capsys.disabled():
        print(f"\n  a stage in Python, called from Rust: {milliseconds:.2f} ms a call, with surface and result")
    # Far below any stage's own time, on a machine that others use as well.
    assert milliseconds < 50
