#!/usr/bin/env python3
"""Measures how stages grow with vertices and with parts, and draws the curves.

    python3 benches/growth/growth.py                          # measures what is missing up to 300,000 vertices, and draws
    python3 benches/growth/growth.py --sizes 500000 1000000   # adds larger meshes
    python3 benches/growth/growth.py --again                  # measures all of it anew

Times are CPU seconds of the work alone on one thread, as `benches/peers/peers.py` measures them. What was measured lies in
`measured.json` beside this file, so that a later run adds to it. `docs/pictures/growth.svg` is drawn from that, and the tables are
printed.
"""

import argparse
import json
import sys
from math import log
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "peers"))
import environment  # noqa: E402
from runner import ROOT, Runner, build_program, target_folder  # noqa: E402

MEASURED, PICTURE = HERE / "measured.json", ROOT / "docs" / "pictures" / "growth.svg"
SIZES = [10_000, 30_000, 100_000, 300_000]
PARTS = [75, 300, 1200, 5000]
WEIGHT_SIZES = [2_000, 7_000, 20_000, 53_000]


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sizes", type=int, nargs="*", default=SIZES, help="vertices of source and target, about")
    parser.add_argument("--parts", type=int, nargs="*", default=PARTS, help="pebbles of a target")
    parser.add_argument("--weight-sizes", type=int, nargs="*", default=WEIGHT_SIZES, help="vertices under weights, about")
    parser.add_argument("--again", action="store_true", help="measure what was measured before")
    parser.add_argument("--draw", action="store_true", help="measure nothing")
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--folder", type=Path, help="where Python and meshes are kept; by default below cargo's target folder")
    parser.add_argument("--program", type=Path, help="a program built from benches/peers/main.rs before")
    return parser.parse_args()


def of_transfer(runner, source, target, transfer, linked, folder):
    """CPU seconds and memory of correspondence, binding and a frame."""
    files = {"source": str(source), "target": str(target)}
    links = {"proximity": {"type": "spanning_tree"}} if linked else {}
    job = {"task": "correspond", **files, **links, "correspondence": {"type": "nonrigid_fit"}, "result": str(folder / "map.json")}
    fit = runner.ours(job)
    job = {"task": "transfer", **files, **links, "map": str(folder / "map.json"), "transfer": transfer, "result": str(folder / "carried")}
    carried = runner.ours(job)
    cpu = {name: phase["cpu"] for name, phase in (fit["phases"] | carried["phases"]).items()}
    cpu["frame"] = cpu.pop("frames") / carried["about"]["frames"]
    return {**cpu, "memory": max(fit["process"]["peak"], carried["process"]["peak"])}


def by_size(runner, folder, size):
    """A horse and a camel, each of about so many vertices."""
    from meshes import make, resolution

    sides = []
    for seed, animal in enumerate(("horse", "camel")):
        path = folder / f"{animal}-{size}-few-handles"
        about = make(runner, path, 4, proportions=animal, resolution=resolution(animal, size), seed=seed)
        sides.append((path, about["vertices"]))
    return {"vertices": sides[1][1]} | of_transfer(runner, sides[0][0], sides[1][0], {"type": "gradient"}, False, folder)


def by_parts(runner, folder, pieces):
    """A horse of some 14,000 vertices and a camel of so many pebbles."""
    from meshes import make, resolution

    source, target = folder / "horse-14000-few-handles", folder / f"pebbles-{pieces}"
    make(runner, source, 4, proportions="horse", resolution=resolution("horse", 14_000))
    about = make(runner, target, 4, proportions="camel", seed=1, made_of="pebbles", pieces=pieces)
    found = of_transfer(runner, source, target, {"type": "multi_component"}, True, folder)
    return {"parts": about["components"], "vertices": about["vertices"]} | found


def by_weights(runner, folder, size):
    """Bounded biharmonic weights on one skin, on plates without bridges, and on plates with bridges."""
    from meshes import make, resolution

    skin, plates = folder / f"horse-{size}", folder / f"plates-20-{size}"
    about = make(runner, skin, 64, proportions="horse", resolution=resolution("horse", size))
    # Plates have an inner side too.
    fine = round(resolution("camel", size) * 0.7)
    of_plates = make(runner, plates, 64, proportions="camel", seed=1, made_of="plates", pieces=20, resolution=max(fine, 20))
    bridges = {"proximity": {"type": "spanning_tree"}}
    cases = {
        "skin, 12 handles": (skin, about, 12, {}),
        "skin, 64 handles": (skin, about, 64, {}),
        "20 plates, 64 handles": (plates, of_plates, 64, {}),
        "20 plates with bridges, 12 handles": (plates, of_plates, 12, bridges),
    }
    found = {}
    for name, (mesh, known, handles, links) in cases.items():
        job = {
            "task": "weights", "mesh": str(mesh), "weights": {"type": "bounded_biharmonic"}, "handles": handles, **links,
            "result": str(folder / "weights"),
        }
        phases = runner.ours(job)["phases"]
        found[name] = [known["vertices"], phases["bind"]["cpu"] + phases["solve"]["cpu"]]
    return found


def exponents(points):
    """The growth exponent over all points, and that between the last two."""
    x, y = [[log(point[axis]) for point in points] for axis in (0, 1)]
    mean = [sum(values) / len(values) for values in (x, y)]
    slope = sum((a - mean[0]) * (b - mean[1]) for a, b in zip(x, y)) / sum((a - mean[0]) ** 2 for a in x)
    return slope, (y[-1] - y[-2]) / (x[-1] - x[-2])


def curves(measured):
    """The points of every curve, a list a panel."""
    def rows(kind):
        return sorted(measured[kind].values(), key=lambda row: row.get("parts", row["vertices"]))

    stages = {"correspondence": "correspond", "binding": "bind", "a frame": "frame"}
    size = [(name, [(row["vertices"], row[key]) for row in rows("sizes")]) for name, key in stages.items()]
    parts = [
        (name, [(row["parts"], row[key]) for row in rows("parts")])
        for name, key in {**stages, "neighbours of parts": "proximity"}.items()
    ]
    names = next(iter(measured["weights"].values()), {})
    weights = [(name, sorted(tuple(found[name]) for found in measured["weights"].values())) for name in names]
    return size, parts, weights


def tell(measured):
    """Prints the tables, and the growth exponents of all curves."""
    print("\n| vertices | correspondence | binding | a frame | memory |\n|---:|---:|---:|---:|---:|")
    for row in sorted(measured["sizes"].values(), key=lambda row: row["vertices"]):
        print(f"| {row['vertices']:,} | {row['correspond']:.3g} | {row['bind']:.3g} | {row['frame']:.3g} | {row['memory'] / 1e9:.2g} GB |")
    print("\n| parts | vertices | neighbours | correspondence | binding | a frame | memory |\n|---:|---:|---:|---:|---:|---:|---:|")
    for row in sorted(measured["parts"].values(), key=lambda row: row["parts"]):
        print(
            f"| {row['parts']:,} | {row['vertices']:,} | {row['proximity']:.3g} | {row['correspond']:.3g} | {row['bind']:.3g} "
            f"| {row['frame']:.3g} | {row['memory'] / 1e9:.2g} GB |"
        )
    print("\n| curve | from | to | CPU s | exponent | between the last two |\n|---|---:|---:|---:|---:|---:|")
    for kind, panel in zip(("by vertices", "by parts", "weights"), curves(measured)):
        for name, points in panel:
            if len(points) > 1:
                over_all, last = exponents(points)
                ends = f"{points[0][0]:,} | {points[-1][0]:,} | {points[0][1]:.3g} to {points[-1][1]:.3g}"
                print(f"| {kind}: {name} | {ends} | {over_all:.2f} | {last:.2f} |")


def main():
    options = arguments()
    folder = (options.folder or target_folder() / "peers").resolve()
    folder.mkdir(parents=True, exist_ok=True)
    environment.enter(folder, ["numpy"])
    from chart import Panel, page

    measured = json.loads(MEASURED.read_text()) if MEASURED.is_file() else {}
    measured = {kind: measured.get(kind, {}) for kind in ("sizes", "parts", "weights")}
    if not options.draw:
        runner = Runner(options.program or build_program(), options.threads, 1)
        works = {"sizes": (by_size, options.sizes), "parts": (by_parts, options.parts), "weights": (by_weights, options.weight_sizes)}
        for kind, (work, amounts) in works.items():
            for amount in amounts:
                if options.again or str(amount) not in measured[kind]:
                    measured[kind][str(amount)] = work(runner, folder, amount)
                    print(kind, amount, measured[kind][str(amount)], file=sys.stderr, flush=True)
                    # What was measured is kept if a larger mesh fails.
                    MEASURED.write_text(json.dumps(measured, indent=1) + "\n")
    size, parts, weights = curves(measured)
    panels = [
        Panel("Horse to camel, one piece", "vertices of each", "CPU seconds", size),
        Panel("Horse to a camel of pebbles", "parts", "CPU seconds", parts),
        Panel("Bounded biharmonic weights", "vertices", "CPU seconds", weights),
    ]
    PICTURE.parent.mkdir(exist_ok=True)
    PICTURE.write_text(page([panel for panel in panels if panel.curves]))
    tell(measured)


if __name__ == "__main__":
    sys.exit(main())
