#!/usr/bin/env python3
"""Compares what runs take of memory with the least `--memory` that lets them run.

    python3 benches/memory.py target/release/mimesh

A run is made once without a limit, which gives its largest resident memory. Then the least limit is found by bisection. Their ratio
should be between 1/1.5 and 1.5: a run is refused if it does not fit, and only then.
"""

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

STEPS = 6


def quadruped(animal, resolution, **more):
    return {"generator": {"type": "quadruped", "proportions": animal, "gait": "gallop", "resolution": resolution, **more}}


def pipelines():
    fit = {"correspondence": {"type": "nonrigid_fit"}}
    for resolution in (100, 200, 300):
        yield f"gradient, resolution {resolution}", {
            "source": quadruped("horse", resolution, frames=4), "target": quadruped("camel", resolution, seed=1), **fit,
            "transfer": {"type": "gradient"}, "output": "out/{pose}.ply",
        }
    yield "gradient, 200 poses", {
        "source": quadruped("horse", 60, frames=200), "target": quadruped("camel", 60, seed=1), **fit,
        "transfer": {"type": "gradient"}, "output": "out/all.pc2",
    }
    for resolution in (60, 120):
        yield f"biharmonic, resolution {resolution}", {
            "source": quadruped("horse", resolution, frames=4), "target": quadruped("camel", resolution, seed=1),
            "transfer": {"type": "biharmonic"}, "output": "out/{pose}.ply",
        }
    for pieces in (300, 2000):
        yield f"multi_component, {pieces} pebbles", {
            "source": quadruped("horse", 80, frames=4), "target": quadruped("camel", 80, seed=1, made_of="pebbles", pieces=pieces),
            "proximity": {"type": "spanning_tree"}, **fit, "transfer": {"type": "multi_component"}, "output": "out/{pose}.ply",
        }


def run(mimesh, folder, limit=None):
    """Status and largest resident memory of a run, and what it said."""
    command = [mimesh, "run", "p.yaml", "--no-cache", "--quiet", *(["--memory", str(limit)] if limit else [])]
    process = subprocess.Popen(command, cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    said = process.stderr.read().decode()
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    return process.returncode, usage.ru_maxrss * 1024, said


def main():
    mimesh, only = str(Path(sys.argv[1]).resolve()), sys.argv[2:]
    print("| run | largest, MB | least limit, MB | ratio | what is refused below |\n|---|---:|---:|---:|---|")
    wrong = []
    for name, pipeline in pipelines():
        if only and not any(name.startswith(start) for start in only):
            continue
        with tempfile.TemporaryDirectory() as folder:
            Path(folder, "p.yaml").write_text(json.dumps(pipeline))
            status, peak, said = run(mimesh, folder)
            if status not in (0, 3):
                sys.exit(f"{name}: status {status}\n{said}")
            low, high, refusal = peak // 4, 2 * peak, ""
            for _ in range(STEPS):
                middle = (low + high) // 2
                status, _, said = run(mimesh, folder, middle)
                if status not in (0, 3, 71):
                    sys.exit(f"{name}: status {status} with --memory {middle}\n{said}")
                if status == 71:
                    low, refusal = middle, said.splitlines()[0].removeprefix("error: ")
                else:
                    high = middle
            ratio = high / peak
            print(f"| {name} | {peak / 1e6:.0f} | {high / 1e6:.0f} | {ratio:.2f} | {refusal} |", flush=True)
            if not 1 / 1.5 <= ratio <= 1.5:
                wrong.append(name)
    if wrong:
        sys.exit(f"not within 1.5: {', '.join(wrong)}")


if __name__ == "__main__":
    main()
