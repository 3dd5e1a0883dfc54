#!/usr/bin/env python3
"""Measures the tables of docs/benchmark.md: methods on targets whose results are known.

    python3 benches/accuracy.py ../shared/data --markdown tables.md

The folder holds the meshes that tests/DATA.md lists. Nothing is taken from a cache. `--only` names tables: animals, bodies, horse.
"""

import argparse
import json
import subprocess
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]

BODY_POSES = ("bow", "crouch", "kick", "reach", "stride", "twist")
LARGER_ANIMALS = {"detail": 60, "finer": 70, "box_detail": 60, "frames": 12, "plates": 60, "pebbles": 200}
PARTS = [{"type": "copy_displacement"}, {"type": "biharmonic"}, {"type": "multi_component"},
         {"type": "multi_component", "initial": {"type": "biharmonic"}}]
ONE_PIECE = [{"type": "copy_displacement"}, {"type": "gradient"}, {"type": "biharmonic"}]

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
        """A horse onto a camel, with all markers. The known results are those of the original authors."""
        horse, camel = self.data / "sumner-horse-poses", self.data / "sumner-camel-poses"
        return self.pipeline({
            "source": {"rest": str(horse / "horse-reference.obj"), "poses": str(horse / "horse-??.obj")},
            "targets": {"camel-107": {
                "rest": str(camel / "camel-reference.obj"), "markers": str(self.data / "markers/horse_camel.cons"),
                "truth": str(camel / "camel-{pose}.obj"),
            }},
            "correspondence": {"type": "nonrigid_fit"}, "matrix": {"transfer": ONE_PIECE},
            "output": str(self.folder / "horse/{name}/{pose}.ply"),
        })

    def landmarks(self, target, count):
        """The first pairs of a body's landmarks, as a file of markers."""
        known = json.loads((target / "landmarks.json").read_text())
        pairs = list(zip(known["source"], known["target"]))[:count]
        file = self.folder / f"{target.name}-{count}.cons"
        file.write_text("\n".join([str(len(pairs)), *(f"{a}, {b}" for a, b in pairs)]) + "\n")
        return file


def row(report):
    """A row of a table."""
    run, error = report["run"], report["metrics"]["point_error"]
    transfer = run["matrix"]["transfer"]
    method = "combined" if "initial" in transfer else transfer["type"]
    motion = report["metrics"].get("component_motion")
    part = f"{motion['worst']['offset_max']:.3f}" if motion else "-"
    average = " | ".join(f"{error['average'][name]:.3f}" for name in ("mean", "rms", "p95"))
    return (f"| {run['target']} | {method} | {report['markers']} | {average} | {error['worst']['mean']:.3f} | {part} | "
            f"{report['verdict']} | {report['seconds']:.3g} s |")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data", type=Path)
    parser.add_argument("--only", nargs="+", default=["animals", "bodies", "horse"], choices=["animals", "bodies", "horse"])
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
            tables.append("\n".join([HEADER, *map(row, getattr(bench, name)())]))
            print(tables[-1], end="\n\n", flush=True)
    if options.markdown:
        options.markdown.write_text("\n\n".join(tables) + "\n")


if __name__ == "__main__":
    main()
