#!/usr/bin/env python3
"""Measures the table of docs/performance.md on real meshes, and prints it with what was measured before and what was wanted.

    python3 benches/table.py ../shared/data --markdown table.md
    python3 benches/table.py ../shared/data --before ../older/target/release/mimesh

The folder holds the meshes that tests/DATA.md lists. Every run is `mimesh run` or `mimesh keypoints` without a cache; seconds are
CPU seconds of one thread, of the stage or of the process; figures are medians. With `--before` an older program does the same work in
turn, where that is a command. `--only` takes the beginnings of rows.
"""

import argparse
import json
import os
import statistics
import struct
import subprocess
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent / "peers"))
from runner import ROOT, Runner, build_program, target_folder  # noqa: E402


class Bench:
    """Runs pipelines on the meshes of `data` with `mimesh`."""

    def __init__(self, data, mimesh, program):
        self.data, self.mimesh = data, mimesh
        self.folder = Path(tempfile.mkdtemp(prefix="mimesh-table-"))
        self.runner, self.program = None, program

    def run(self, pipeline, threads=1):
        """What a run took."""
        file = self.folder / "pipeline.yaml"
        # JSON is YAML.
        file.write_text(json.dumps(pipeline))
        command = [self.mimesh, "run", str(file), "--no-cache", "--threads", str(threads), "--json"]
        done = subprocess.run(command, capture_output=True, env={**os.environ, "RAYON_NUM_THREADS": str(threads)})
        # 3 and 4: a gate or a pose failed, which times do not depend on.
        if done.returncode not in (0, 3, 4):
            sys.exit(f"{' '.join(command)}: status {done.returncode}\n{done.stderr.decode()}")
        report = json.loads(done.stdout)
        stages = {stage["stage"] for stage in report["stages"]}

        def total(stage, clock):
            return sum(s[clock] for s in report["stages"] if s["stage"] == stage)

        return {
            "process": report["process"]["cpu_seconds"],
            "memory": report["process"]["peak_memory_bytes"],
            "cpu": {stage: total(stage, "cpu_seconds") for stage in stages},
            "wall": {stage: total(stage, "seconds") for stage in stages},
            "poses": len(report["poses"]),
        }

    def keypoints(self, pipeline):
        """CPU seconds of `mimesh keypoints`."""
        file = self.folder / "keypoints.yaml"
        file.write_text(json.dumps(pipeline))
        command = [self.mimesh, "keypoints", str(file), "--output", str(self.folder / "points.yaml"), "--force"]
        # Older programs have no `--no-cache` here.
        with tempfile.TemporaryDirectory() as cache:
            before = os.times()
            environment = {**os.environ, "RAYON_NUM_THREADS": "1", "MIMESH_CACHE": cache}
            done = subprocess.run(command, capture_output=True, env=environment)
        if done.returncode != 0:
            sys.exit(f"{' '.join(command)}: status {done.returncode}\n{done.stderr.decode()}")
        after = os.times()
        return after.children_user + after.children_system - before.children_user - before.children_system

    def imported(self, name, mesh, poses=()):
        """The folder of a mesh as bare numbers, which the program that runs one stage takes."""
        folder = self.folder / name
        if not folder.is_dir():
            job = {
                "task": "import", "format": {"type": "obj"}, "file": str(mesh), "poses": [str(pose) for pose in poses],
                "handles": {"type": "farthest_point", "count": 64}, "mesh": str(folder),
            }
            self.stage(job)
        return folder

    def stage(self, job):
        """Runs one stage, in a process of its own."""
        self.runner = self.runner or Runner(self.program or build_program(), 1, 1)
        return self.runner.ours(job)

    def weights(self, mesh, handles, name):
        """CPU seconds of binding weights to a mesh and solving for handles."""
        job = {
            "task": "weights", "mesh": str(self.imported(name, mesh)), "weights": {"type": "bounded_biharmonic"},
            "handles": handles, "result": str(self.folder / "weights"),
        }
        return self.stage(job)["work"]["cpu"]

    def animals(self):
        """Horse and camel as bare numbers, with their markers as named points."""
        horse, camel = self.data / "sumner-horse-poses", self.data / "sumner-camel-poses"
        files = [horse / "horse-reference.obj", *(horse / f"horse-{k:02}.obj" for k in range(1, 11))]
        sides = self.imported("horse", files[0], files[1:]), self.imported("camel", camel / "camel-reference.obj")
        lines = (self.data / "markers" / "horse_camel.cons").read_text().split("\n")[1:]
        pairs = [tuple(int(word) for word in line.split(",")) for line in lines if line.strip()]
        for side, folder in enumerate(sides):
            corners = struct.iter_unpack("<3I", (folder / "triangles").read_bytes())
            around = {}
            for number, corner in enumerate(corners):
                for v in corner:
                    around.setdefault(v, [number, [float(u == v) for u in corner]])
            named = {str(name): around[pair[side]] for name, pair in enumerate(pairs)}
            (folder / "landmarks.json").write_text(json.dumps(named))
        return {"source": str(sides[0]), "target": str(sides[1])}

    def correspondence(self):
        """CPU seconds of the map from horse to camel."""
        job = {"task": "correspond", **self.animals(), "correspondence": {"type": "nonrigid_fit"}, "result": str(self.folder / "map.json")}
        return self.stage(job)["work"]["cpu"]

    def pose(self, **settings):
        """CPU seconds of a pose of the horse on the camel, without files."""
        if not (self.folder / "map.json").is_file():
            self.correspondence()
        job = {
            "task": "transfer", **self.animals(), "map": str(self.folder / "map.json"),
            "transfer": {"type": "gradient", **settings}, "result": str(self.folder / "posed"),
        }
        report = self.stage(job)
        return report["phases"]["frames"]["cpu"] / report["about"]["frames"]

    def horse_to_camel(self, **settings):
        horse, camel = self.data / "sumner-horse-poses", self.data / "sumner-camel-poses"
        return {
            "source": {"rest": f"{horse}/horse-reference.obj", "poses": f"{horse}/horse-??.obj"},
            "target": {"rest": f"{camel}/camel-reference.obj"}, "markers": f"{self.data}/markers/horse_camel.cons",
            "correspondence": {"type": "nonrigid_fit"}, "transfer": {"type": "gradient"},
            "output": str(self.folder / "camel-{pose}.obj"), **settings,
        }

    def combined(self, source, poses, target, markers):
        return {
            "source": {"rest": str(source), "poses": poses}, "target": {"rest": str(target)}, "markers": str(markers),
            "proximity": {"type": "spanning_tree"}, "correspondence": {"type": "nonrigid_fit"},
            "transfer": {"type": "multi_component", "initial": {"type": "biharmonic"}},
            "output": str(self.folder / "combined-{pose}.ply"),
        }

    def landmarks(self, target, count):
        """The first pairs of a body's landmarks, as a file of markers."""
        known = json.loads((self.data / "bodies" / target / "landmarks.json").read_text())
        pairs = list(zip(known["source"], known["target"]))[:count]
        file = self.folder / f"{target}-{count}.cons"
        file.write_text("\n".join([str(len(pairs)), *(f"{a}, {b}" for a, b in pairs)]) + "\n")
        return file

    def finer(self, mesh):
        """A mesh of triangles with each cut into four, as a file."""
        lines = mesh.read_text().splitlines()
        points = [tuple(map(float, line.split()[1:4])) for line in lines if line.startswith("v ")]
        triangles = [[int(word.split("/")[0]) - 1 for word in line.split()[1:]] for line in lines if line.startswith("f ")]
        middles, cut = {}, []

        def middle(a, b):
            if (key := (min(a, b), max(a, b))) not in middles:
                middles[key] = len(points)
                points.append(tuple((x + y) / 2 for x, y in zip(points[a], points[b])))
            return middles[key]

        for a, b, c in triangles:
            ab, bc, ca = middle(a, b), middle(b, c), middle(c, a)
            cut += [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
        file = self.folder / "finer.obj"
        text = [f"v {x} {y} {z}" for x, y, z in points] + [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in cut]
        file.write_text("\n".join(text) + "\n")
        return file

    def on_stones(self, markers, nearest):
        """The pairs of a file of markers, each with the stone's vertex that is nearest to the target's."""
        stone_of = json.loads(nearest.read_text())["surface_vertex_to_stone_vertex"]
        count, *pairs = markers.read_text().split("\n")
        pairs = [[int(vertex) for vertex in pair.split(",")] for pair in pairs if pair.strip()]
        file = self.folder / "stones.cons"
        file.write_text("\n".join([count, *(f"{a}, {stone_of[b]}" for a, b in pairs)]) + "\n")
        return file

    def frames(self, output, count):
        """Frames a second of a body onto itself, on two threads. The frames are six poses, blended in turn."""
        body = self.data / "bodies" / "source"
        poses = [vertices(body / f"{name}.obj") for name in ("bow", "crouch", "kick", "reach", "stride", "twist")]
        file = self.folder / "frames.pc2"
        if not file.is_file() or file.stat().st_size != 32 + 12 * len(poses[0]) // 3 * count:
            with file.open("wb") as out:
                out.write(struct.pack("<12siiffi", b"POINTCACHE2\0", 1, len(poses[0]) // 3, 0.0, 1.0, count))
                for frame in range(count):
                    k, share = frame // 20, frame % 20 / 20
                    a, b = poses[k % 6], poses[(k + 1) % 6]
                    out.write(struct.pack(f"<{len(a)}f", *((1 - share) * x + share * y for x, y in zip(a, b))))
        pipeline = {
            "source": {"rest": f"{body}/rest.obj", "poses": str(file)}, "target": {"rest": f"{body}/rest.obj"},
            "correspondence": {"type": "identity"}, "transfer": {"type": "gradient"}, "output": str(self.folder / output),
        }
        report = self.run(pipeline, threads=2)
        return report["poses"] / report["wall"]["poses"], report["memory"] / 1e6


def vertices(file):
    lines = (line.split() for line in file.read_text().splitlines() if line.startswith("v "))
    return [float(word) for words in lines for word in words[1:4]]


def rows(bench):
    """The rows: what is done, what was measured before, a function that measures, what was wanted, whether it is a command."""
    data = bench.data
    horse, body, stones = data / "sumner-horse-poses", data / "bodies" / "source", data / "pebble-camel"
    least_squares = {"type": "gradient", "reweightings": 0}
    bare = {"metrics": []}
    many = {"transfer": {"type": "biharmonic"}, "correspondence": None}

    def animals(**settings):
        return bench.run(without_none(bench.horse_to_camel(**settings)))["process"]

    def key_points(poses):
        files = sorted(str(path) for path in two_k.parent.glob("*.obj") if path.stem != "rest")[:poses]
        return bench.keypoints({
            "source": {"rest": str(two_k), "poses": files},
            "key_points": {"type": "greedy", "max_count": 12, "threshold": 0},
        })

    def plates():
        poses = [str(body / f"{name}.obj") for name in ("bow", "crouch", "kick", "reach", "stride", "twist")]
        markers = bench.landmarks("plates-child", 20)
        return bench.run(bench.combined(body / "rest.obj", poses, data / "bodies" / "plates-child" / "rest.obj", markers))["process"]

    def pebbles():
        poses = [str(horse / f"horse-{name}.obj") for name in ("01", "03", "05", "08", "10")]
        markers = bench.on_stones(data / "markers" / "horse_camel.cons", stones / "nearest.json")
        pipeline = bench.combined(horse / "horse-reference.obj", poses, stones / "rest.obj", markers)
        return bench.run(pipeline)["process"]

    two_k, thirteen_k = data / "bodies-2k" / "source" / "rest.obj", body / "rest.obj"
    weights = "bounded biharmonic weights"
    return [
        ("horse to camel, ten poses, whole process", "3.07", animals, "1.6", True),
        ("— without metrics", "2.58", lambda: animals(**bare), "", True),
        ("— without metrics and reweighting", "1.89", lambda: animals(**bare, transfer=least_squares), "", True),
        ("correspondence of horse and camel", "1.5", bench.correspondence, "1.0", False),
        ("a pose, 21,887 v", "0.077", bench.pose, "0.015", False),
        ("— without reweighting", "0.007", lambda: bench.pose(reweightings=0), "", False),
        ("`biharmonic` horse to camel, 107 markers, ten poses", "68", lambda: animals(**many), "8", True),
        (f"{weights}, 2,161 v, 12 handles", "0.22", lambda: bench.weights(two_k, 12, "2k"), "", False),
        (f"{weights}, 2,161 v, 64 handles", "1.01", lambda: bench.weights(two_k, 64, "2k"), "", False),
        (f"{weights}, 13,348 v, 12 handles", "2.7–3.4", lambda: bench.weights(thirteen_k, 12, "13k"), "1.1", False),
        (f"{weights}, 53,386 v, 12 handles", "24.7", lambda: bench.weights(bench.finer(thirteen_k), 12, "53k"), "6", False),
        ("key points, 2,161 v, 12 of 100, one pose", "30.6", lambda: key_points(1), "5", True),
        ("key points, 2,161 v, 12 of 100, six poses", "70.9", lambda: key_points(6), "15", True),
        ("combined on a camel of 750 pebbles, 107 markers", "485", pebbles, "7", True),
        ("combined on a child in 180 plates, 20 markers", "154", plates, "5", True),
        # The program of 22 November reads no point caches.
        ("frames a second into GLB, 13,348 v, two threads (1,000 frames)", "33", lambda: bench.frames("f.glb", 1000)[0], "100", False),
        ("frames a second into PC2, 13,348 v, two threads (1,000 frames)", "", lambda: bench.frames("f-out.pc2", 1000)[0], "100", False),
    ]


def without_none(pipeline):
    return {key: value for key, value in pipeline.items() if value is not None}


def medians(measures, runs):
    """The medians of several functions that measure in turn; of one run where it takes over two minutes."""
    found = [[] for _ in measures]
    for _ in range(runs):
        for measure, values in zip(measures, found):
            begin = time.monotonic()
            if len(values) == 0 or values[0][1] < 120:
                values.append((measure(), time.monotonic() - begin))
    return [statistics.median(value for value, _ in values) for values in found]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data", type=Path)
    parser.add_argument("--runs", type=int, default=5, help="runs of each row; one where it takes over two minutes")
    parser.add_argument("--only", nargs="+", default=[""])
    parser.add_argument("--mimesh", type=Path, help="the program; by default it is built")
    parser.add_argument("--before", type=Path, help="an older program, measured in turn")
    parser.add_argument("--program", type=Path, help="a program built from benches/peers/main.rs before")
    parser.add_argument("--markdown", type=Path, help="also write the table into this file")
    options = parser.parse_args()
    mimesh = options.mimesh
    if mimesh is None:
        subprocess.run(["cargo", "build", "--release", "--locked"], cwd=ROOT, check=True)
        mimesh = target_folder() / "release" / "mimesh"
    programs = [path.resolve() for path in (mimesh, options.before) if path]
    benches = [rows(Bench(options.data.resolve(), str(path), options.program)) for path in programs]
    lines = ["| work | before | after | wanted |", "|---|---:|---:|---:|"]
    print(*lines, sep="\n", flush=True)
    for name, before, measure, wanted, is_command in benches[0]:
        if any(name.startswith(start) for start in options.only):
            others = [row[2] for bench in benches[1:] for row in bench if row[0] == name and is_command]
            after, *measured = medians([measure, *others], options.runs)
            before = f"{measured[0]:.3g}" if measured else before
            lines.append(f"| {name} | {before} | {after:.3g} | {wanted} |")
            print(lines[-1], flush=True)
    if options.markdown:
        options.markdown.write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    sys.exit(main())
