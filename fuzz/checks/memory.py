#!/usr/bin/env python3
"""Largest memory a byte of input for each reader: `fuzz/checks/memory.py [--size BYTES] [--only NAME] [PROGRAM]`.

Each case is read by `mimesh inspect`, or as markers, within ten seconds and a gigabyte. Memory is what the process takes
beyond what it takes for a tetrahedron. The exit status is 1 if a case hangs, dies, or takes more than 1024 bytes a byte and 192 MB.
"""

import argparse
import os
import resource
import subprocess
import sys
import tempfile
import time

from bombs import BOMBS
from files import obj, pc2

SECONDS, ADDRESSES = 10, 4 << 30
MAX_RATIO, FREE = 1024, 192 << 20
MARKERS = (".json", ".csv", ".pp", ".pts", ".fcsv")


def command(program, name):
    """The command that reads a file."""
    meshes = ["--source", "tet.obj", "--target", "tet.obj", "--force"]
    if name.endswith((".yaml", ".cons")):
        return [program, "markers", "convert", name, "out.cons", *meshes]
    if name.endswith(MARKERS):
        return [program, "markers", "convert", name, name, "out.yaml", *meshes]
    return [program, "inspect", name]


def run(arguments, folder):
    """Exit status (None if it took too long), seconds, peak memory and error output of a command."""
    limit = lambda: resource.setrlimit(resource.RLIMIT_AS, (ADDRESSES, ADDRESSES))
    start = time.monotonic()
    with open(os.path.join(folder, "stdout"), "w") as out, open(os.path.join(folder, "stderr"), "w+") as errors:
        process = subprocess.Popen(arguments, cwd=folder, stdout=out, stderr=errors, preexec_fn=limit)
        status = None
        while time.monotonic() < start + SECONDS:
            pid, code, usage = os.wait4(process.pid, os.WNOHANG)
            if pid:
                status = os.waitstatus_to_exitcode(code)
                break
            time.sleep(0.005)
        else:
            process.kill()
            _, _, usage = os.wait4(process.pid, 0)
        process.returncode = 0
        errors.seek(0)
        return status, time.monotonic() - start, usage.ru_maxrss * 1024, errors.read()


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program", nargs="?", default=os.path.join(os.path.dirname(__file__), "../../target/release/mimesh"))
    parser.add_argument("--size", type=int, default=400_000)
    parser.add_argument("--only", default="")
    arguments = parser.parse_args()
    program, bad = os.path.abspath(arguments.program), []
    with tempfile.TemporaryDirectory() as folder:
        with open(os.path.join(folder, "tet.obj"), "wb") as file:
            file.write(obj())
        _, _, least, _ = run([program, "inspect", "tet.obj"], folder)
        print(f"{'case':32}{'bytes':>9}{'memory':>10}{'a byte':>8}{'seconds':>9}  outcome")
        for bomb in BOMBS:
            if arguments.only not in bomb.__name__:
                continue
            name, contents = bomb(arguments.size)
            with open(os.path.join(folder, name), "wb") as file:
                file.write(contents)
            status, seconds, peak, errors = run(command(program, name), folder)
            grown = max(0, peak - least)
            dead = status is None or status < 0 or status in (1, 101)
            excess = grown > FREE + MAX_RATIO * len(contents)
            outcome = "hangs" if status is None else "dead" if dead else "too much" if excess else f"exit {status}"
            bad += [bomb.__name__] if dead or excess else []
            line = next((line for line in errors.splitlines() if line.startswith("error")), "")
            print(f"{bomb.__name__:32}{len(contents):9}{grown / 1e6:8.0f}MB{grown / len(contents):8.0f}{seconds:9.2f}  {outcome} {line[:90]}",
                  flush=True)
            os.remove(os.path.join(folder, name))
    if bad:
        sys.exit(f"{len(bad)} bad: {', '.join(bad)}")


if __name__ == "__main__":
    main()
