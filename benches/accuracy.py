#!/usr/bin/env python3
"""Measures the tables of docs/benchmark.md and docs/combined.md: methods on targets whose results are known.

    python3 benches/accuracy.py ../shared/data --markdown tables.md

The folder holds the meshes that tests/DATA.md lists. Nothing is taken from a cache. `--only` names tables: animals, bodies and horse
are of docs/benchmark.md, combined is of docs/combined.md.
"""

import argparse
import json
import math
import subprocess
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]

BODY_POSES = ("bow", "crouch", "kick", "reach", "stride", "twist")
LARGER_ANIMALS = {"detail": 60, "finer": 70, "box_detail": 60, "frames": 12, "plates": 60, "pebbles": 200}
PARTS = [{"type": "copy_displacement"}, {"type": "biharmonic"}, {"type": "multi_component"},
         {"type": "multi_component", "initial": {"type": "biharmonic"}}]
ONE_PIECE = [{"type": "copy_displacement"}, {"type": "gradient"}, {"type": "biharmonic"}]
TABLES = ("animals", "bodies", "horse", "combined")
EXPRESSIONS = ("browInnerUp_L", "cheekPuff_L", "eyeBlink_L", "eyeBlink_R", "eyeLookUp_L", "jawOpen", "mouthPucker", "mouthSmile_L",
               "mouthSmile_R")

HEADER = """| case | method | clicks | mean | rms | p95 | worst pose | worst component | verdict | time |
| --- | --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |"""


class Bench:
    """Runs pipelines with `mimesh`, on the meshes of `data`."""

    def __init__(self, data, mimesh, folder):
        self.data, self.mimesh, self.folder = data, mimesh, folder

    def run(self, file, *settings):
        """The reports of all runs of a file."""
        settings = [word for setting in settings for word in ("--set", setting)]
        command = [self.mimesh, "run", file, "--no-cache", "--json", "--out", self.folder / "out", *settings]
        done = subprocess.run(command, capture_output=True, text=True)
        # A verdict or a run that failed is in the table; without a table the run did not begin.
        if not done.stdout:
            raise SystemExit(f"{' '.join(map(str, command))}: status {done.returncode}\n{done.stderr}")
        return [row["report"] for row in json.loads(done.stdout)["runs"]]

    def pipeline(self, contents):
        file = self.folder / "pipeline.yaml"
        file.write_text(json.dumps(contents))
        return self.run(file)

    def animals(self):
        """Those of pipelines/benchmark.yaml, larger, and `gradient` on the targets of one piece."""
        parts = ("plates", "pebbles", "boxes")

        def animal(proportions, gait, resolution, **more):
            return {"generator": {"type": "quadruped", "proportions": proportions, "gait": gait, "resolution": resolution, "frames": 12, **more}}

        one_piece = self.pipeline({
            "source": animal("horse", "gallop", 60),
            "targets": {
                "camel": animal("camel", "gallop", 70, seed=1),
                "giraffe": {"source": animal("horse", "walk", 60), **animal("giraffe", "walk", 60, seed=2)},
            },
            "correspondence": {"type": "nonrigid_fit"}, "matrix": {"transfer": [{"type": "gradient"}]},
            "output": str(self.folder / "animals/{name}/result.glb"),
        })
        every = self.run(ROOT / "pipelines" / "benchmark.yaml", f"variables={json.dumps(LARGER_ANIMALS)}")
        is_of_parts = lambda report: report["run"]["matrix"]["transfer"]["type"] == "multi_component"  # noqa: E731
        others = [report for report in every if report["run"]["target"] in parts or not is_of_parts(report)]
        return sorted(one_piece + others, key=lambda report: ("camel", "giraffe", *parts).index(report["run"]["target"]))

    def bodies(self):
        """A body onto others, in one piece and in plates, with the first 10 and 20 of the landmarks."""
        folder = self.data / "bodies"
        reports = []
        for targets, methods in (
            (("plates-child", "plates-heavy"), PARTS), (("target-child", "target-giant", "target-heavy"), ONE_PIECE),
        ):
            linked = {"proximity": {"type": "spanning_tree"}} if methods is PARTS else {}
            reports += self.pipeline({
                "source": {"rest": str(folder / "source/rest.obj"), "poses": [str(folder / f"source/{pose}.obj") for pose in BODY_POSES]},
                "targets": {
                    f"{name}-{count}": {
                        "rest": str(folder / name / "rest.obj"), "markers": str(self.landmarks(folder / name, count)),
                        "truth": str(folder / name / "truth-{pose}.ply"),
                    }
                    for name in targets for count in (10, 20)
                },
                "correspondence": {"type": "nonrigid_fit"}, **linked, "matrix": {"transfer": methods},
                "output": str(self.folder / "bodies/{name}/{pose}.ply"),
            })
        return reports

    def horse(self):
        """A horse onto a camel, with 20 markers and with all. The known results are those of the original authors."""
        horse, camel = self.data / "sumner-horse-poses", self.data / "sumner-camel-poses"
        every = hand_picked(self.data)
        few = spread([vertices(horse / "horse-reference.obj")[a] for a, _ in every], 20)
        return self.pipeline({
            "source": {"rest": str(horse / "horse-reference.obj"), "poses": str(horse / "horse-??.obj")},
            "targets": {
                f"camel-{len(pairs)}": {
                    "rest": str(camel / "camel-reference.obj"), "markers": str(self.markers(f"camel-{len(pairs)}", pairs)),
                    "truth": str(camel / "camel-{pose}.obj"),
                } for pairs in ([every[k] for k in few], every)
            },
            "correspondence": {"type": "nonrigid_fit"}, "matrix": {"transfer": ONE_PIECE},
            "output": str(self.folder / "horse/{name}/{pose}.ply"),
        })

    def combined(self):
        """`biharmonic`, `multi_component` and both together, with 10 to 64 markers and with key points."""
        bodies = self.data / "bodies"
        body = {"rest": str(bodies / "source/rest.obj"), "poses": [str(bodies / f"source/{pose}.obj") for pose in BODY_POSES]}
        chosen = self.key_points(body)
        for name in ("plates-child", "plates-heavy"):
            partner = json.loads((bodies / name / "partner-of-source-vertex.json").read_text())
            files = {f"{name}, {count}": self.landmarks(bodies / name, count) for count in (10, 20, 64)}
            files[f"{name}, key points"] = self.markers(f"{name}-chosen", [(v, partner[v]) for v in chosen])
            yield from self.parts(body, bodies / name / "rest.obj", files, bodies / name / "truth-{pose}.ply")
        horse, stones = self.data / "sumner-horse-poses", self.data / "pebble-camel"
        stone_of = json.loads((stones / "nearest.json").read_text())["surface_vertex_to_stone_vertex"]
        pairs = [(a, stone_of[b]) for a, b in hand_picked(self.data)]
        order = spread([vertices(horse / "horse-reference.obj")[a] for a, _ in pairs], 64)
        files = {f"stones, {count}": self.markers(f"stones-{count}", [pairs[k] for k in order[:count]]) for count in (10, 20, 64)}
        # Those whose results are known: 01, 03, 05, 08 and 10.
        gallop = {"rest": str(horse / "horse-reference.obj"), "poses": str(horse / "horse-[01][01358].obj")}
        yield from self.parts(gallop, stones / "rest.obj", files, stones / "truth-camel-{pose}.ply")
        yield from self.faces()

    def faces(self):
        """A face of 56 components, which gives nine expressions to another identity. The model adds displacements."""
        face = self.data / "ict-facekit"
        neutral, target = vertices(face / "generic_neutral_mesh.obj"), vertices(face / "identity000.obj")
        faces = [line for line in (face / "identity000.obj").read_text().splitlines() if line.startswith("f ")]
        for name in EXPRESSIONS:
            moved = [[z + x - y for x, y, z in zip(*points)] for points in zip(vertices(face / f"{name}.obj"), neutral, target)]
            # Corners without texture and normal.
            bare = ["f " + " ".join(corner.split("/")[0] for corner in line.split()[1:]) for line in faces]
            (self.folder / f"truth-{name}.obj").write_text("\n".join([f"v {x} {y} {z}" for x, y, z in moved] + bare) + "\n")
        order = spread(neutral, 64, 0)
        files = {f"ict, {count}": self.markers(f"ict-{count}", [(v, v) for v in order[:count]]) for count in (10, 20, 30, 64)}
        source = {"rest": str(face / "generic_neutral_mesh.obj"), "poses": [str(face / f"{name}.obj") for name in EXPRESSIONS]}
        return self.parts(source, face / "identity000.obj", files, self.folder / "truth-{pose}.obj")

    def parts(self, source, target, markers, truth):
        """The reports of three methods with each file of markers."""
        return self.pipeline({
            "source": source,
            "targets": {name: {"rest": str(target), "markers": str(file), "truth": str(truth)} for name, file in markers.items()},
            "correspondence": {"type": "nonrigid_fit"}, "proximity": {"type": "spanning_tree"},
            "matrix": {"transfer": [method for method in PARTS if method["type"] != "copy_displacement"]},
            "output": str(self.folder / "parts/{name}/{pose}.ply"),
        })

    def key_points(self, source):
        """The vertices of the 20 points that `mimesh keypoints` chooses."""
        file = self.folder / "keypoints.yaml"
        file.write_text(json.dumps({"source": source, "key_points": {"type": "greedy", "max_count": 20, "threshold": 0}}))
        command = [self.mimesh, "keypoints", file, "--output", self.folder / "points.yaml", "--no-cache", "--json"]
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode != 0:
            raise SystemExit(f"{' '.join(map(str, command))}: status {done.returncode}\n{done.stderr}")
        return json.loads(done.stdout)["points"]

    def landmarks(self, target, count):
        """The first pairs of a body's landmarks, as a file of markers."""
        known = json.loads((target / "landmarks.json").read_text())
        return self.markers(f"{target.name}-{count}", list(zip(known["source"], known["target"]))[:count])

    def markers(self, name, pairs):
        file = self.folder / f"{name}.cons"
        file.write_text("\n".join([str(len(pairs)), *(f"{a}, {b}" for a, b in pairs)]) + "\n")
        return file


def vertices(file):
    lines = (line.split() for line in file.read_text().splitlines() if line.startswith("v "))
    return [[float(word) for word in words[1:4]] for words in lines]


def hand_picked(data):
    """The 107 pairs of horse and camel."""
    lines = (data / "markers/horse_camel.cons").read_text().split("\n")[1:]
    return [tuple(int(word) for word in line.split(",")) for line in lines if line.strip()]


def spread(points, count, first=None):
    """The first points in farthest-point order, which begins with `first`, else with the one that is farthest from their mean."""
    mean = [sum(axis) / len(points) for axis in zip(*points)]
    first = max(range(len(points)), key=lambda k: math.dist(points[k], mean)) if first is None else first
    chosen, distance = [first], [float("inf")] * len(points)
    while len(chosen) < count:
        distance = [min(d, math.dist(point, points[chosen[-1]])) for d, point in zip(distance, points)]
        chosen.append(max(range(len(points)), key=distance.__getitem__))
    return chosen


def digits(percent):
    return f"{percent:.3f}" if percent >= 0.1 else f"{percent:.4f}"


def row(report):
    """A row of a table."""
    run, error = report["run"], report["metrics"]["point_error"]
    transfer = run["matrix"]["transfer"]
    method = "combined" if "initial" in transfer else transfer["type"]
    motion = report["metrics"].get("component_motion")
    part = f"{motion['worst']['offset_max']:.3f}" if motion else "-"
    average = " | ".join(digits(error["average"][name]) for name in ("mean", "rms", "p95"))
    return (f"| {run['target']} | {method} | {report['markers']} | {average} | {digits(error['worst']['mean'])} | {part} | "
            f"{report['verdict']} | {report['seconds']:.3g} s |")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data", type=Path)
    parser.add_argument("--only", nargs="+", default=TABLES, choices=TABLES)
    parser.add_argument("--mimesh", type=Path, help="the program; by default it is built")
    parser.add_argument("--markdown", type=Path, help="also write the tables into this file")
    options = parser.parse_args()
    if not options.mimesh:
        subprocess.run(["cargo", "build", "--release", "--locked"], cwd=ROOT, check=True)
    mimesh = (options.mimesh or ROOT / "target" / "release" / "mimesh").resolve()
    tables = []
    with tempfile.TemporaryDirectory(prefix="mimesh-accuracy-") as folder:
        bench = Bench(options.data.resolve(), mimesh, Path(folder))
        for name in options.only:
            lines = [HEADER]
            print(HEADER)
            for report in getattr(bench, name)():
                lines.append(row(report))
                print(lines[-1], flush=True)
            tables.append("\n".join(lines))
    if options.markdown:
        options.markdown.write_text("\n\n".join(tables) + "\n")


if __name__ == "__main__":
    main()
