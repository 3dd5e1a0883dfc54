#!/usr/bin/env python3
"""Compares mimesh with libigl, trimesh and potpourri3d: CPU time, wall time and memory on the same meshes, in one run.

    python3 benches/peers/peers.py --markdown peers.md --json peers.json

It makes a Python of its own with these libraries, builds the program that runs one stage (`main.rs`), makes meshes with mimesh, and
runs each job in a process of its own, ours and the peers' in turn. Clocks run in that process, on the work alone: program and
libraries are loaded and the input is in memory before, and results are written after. Memory is the most that the process had, less
what it had before the work. Every number is a median.

Results are compared too. The exit status is 1 if any do not agree.
"""

import argparse
import json
import platform
import sys
import tempfile
from importlib import metadata
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import environment  # noqa: E402
from runner import Runner, build_program, target_folder  # noqa: E402

PACKAGES = ["libigl", "trimesh", "potpourri3d", "scipy", "rtree"]


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sizes", type=int, nargs="+", default=[2_000, 13_000, 53_000], help="vertices of the meshes, about")
    parser.add_argument("--handles", type=int, nargs="+", default=[12, 64], help="handles of weights, at most 64")
    parser.add_argument("--only", nargs="+", help="weights, plates, deform, distances, closest, correspondence, files")
    parser.add_argument("--files", type=Path, nargs="+", default=[], help="OBJ files of one component: compare weights on them alone")
    parser.add_argument("--runs", type=int, default=5, help="runs of each job; one where it takes over two minutes")
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--markdown", type=Path, help="also write the table into this file")
    parser.add_argument("--json", type=Path, help="write all numbers into this file")
    parser.add_argument("--folder", type=Path, help="where Python and meshes are kept; by default below cargo's target folder")
    parser.add_argument("--program", type=Path, help="a program built from main.rs before; by default it is built")
    return parser.parse_args()


def compare(runner, case, folder):
    """Runs a case on both sides and checks the results; a row for each peer."""
    ours = {**case.ours}
    ours.setdefault("result", str(folder / "ours"))
    mine = runner.ours(ours)
    for name, job, check in case.peers:
        theirs = {**job, "result": str(folder / f"peer{job.get('suffix', '')}")}
        report = runner.peer(theirs)
        said, agrees = check(ours["result"], theirs["result"], ours)
        yield {
            "work": case.work, "mesh": case.mesh, "peer": name, "ours": mine, "theirs": report, "agreement": said,
            "agrees": agrees, "note": case.note,
            "ratios": {
                what: report["work"][what] / max(mine["work"][what], 1e-9) for what in ("cpu", "wall", "memory")
            },
        }


def seconds(value):
    return f"{value:.3g}" if value < 100 else f"{value:.0f}"


def megabytes(value):
    return f"{value / 1e6:.3g}" if value < 1e8 else f"{value / 1e6:.0f}"


HEADER = (
    "| work | mesh | peer | CPU s: ours | peer | wall s: ours | peer | MB: ours | peer | CPU ratio | wall | memory | results |\n"
    "|---|---|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|---|"
)


def line(row):
    """A row of the table."""
    mine, theirs, ratios = row["ours"]["work"], row["theirs"]["work"], row["ratios"]
    numbers = [
        seconds(mine["cpu"]), seconds(theirs["cpu"]), seconds(mine["wall"]), seconds(theirs["wall"]),
        megabytes(mine["memory"]), megabytes(theirs["memory"]), f"**{ratios['cpu']:.3g}**", f"{ratios['wall']:.3g}",
        f"{ratios['memory']:.2g}",
    ]
    agreement = row["agreement"] if row["agrees"] else f"**do not agree**: {row['agreement']}"
    return f"| {row['work']} | {row['mesh']} | {row['peer']} | {' | '.join(numbers)} | {agreement} |"


def main():
    options = arguments()
    folder = (options.folder or target_folder() / "peers").resolve()
    folder.mkdir(parents=True, exist_ok=True)
    environment.enter(folder, PACKAGES)
    from cases import all_cases

    program = options.program or build_program()
    runner = Runner(program, options.threads, options.runs)
    versions = {name: metadata.version(name) for name in ("libigl", "trimesh", "potpourri3d")}
    about = ", ".join([f"{name} {version}" for name, version in versions.items()] + [f"Python {platform.python_version()}"])
    print(f"{about}; {options.threads} thread(s), medians of {options.runs}; ratios are the peer's over ours\n\n{HEADER}", flush=True)
    rows, notes = [], {}
    with tempfile.TemporaryDirectory() as results:
        for case in all_cases(runner, folder, Path(results), options.sizes, options.handles, options.only, options.files):
            for row in compare(runner, case, Path(results)):
                rows.append(row)
                print(line(row), flush=True)
            if case.note:
                notes[case.work] = case.note
    print("", *(f"{work}: {note}" for work, note in notes.items()), sep="\n")
    if options.markdown:
        options.markdown.write_text("\n".join([HEADER, *map(line, rows), ""]))
    if options.json:
        document = {"versions": versions, "threads": options.threads, "rows": rows}
        options.json.write_text(json.dumps(document, indent=1) + "\n")
    apart = [row for row in rows if not row["agrees"]]
    for row in apart:
        print(f"{row['work']}, {row['mesh']}: not as {row['peer']} has it: {row['agreement']}", file=sys.stderr)
    return 1 if apart else 0


if __name__ == "__main__":
    sys.exit(main())
