#!/usr/bin/env python3
"""Reads damaged and nonsensical files and tells how clear the answers are: `fuzz/checks/bad_files.py [--show KIND] [PROGRAM]`.

Some 1,080 files are made in a temporary folder. Meshes go to `mimesh inspect`, poses to `mimesh check`, markers to `mimesh markers
convert`, each within ten seconds and a gigabyte. An answer is

- `clear`: an error that names the file, a line or an element, and a way out; or a result with a warning;
- `accepted`: a result without a word, where the case is marked as nonsense;
- `fine`: a result without a word, where that is right;
- `vague`: an error without file, place or way out;
- `dead`: a crash, a hang, or exhausted memory.

The exit status is 1 if any is vague, accepted or dead.
"""

import argparse
import collections
import os
import re
import struct
import sys
import tempfile

import memory
import more_gltf
import more_meshes
from cases import CASES, POSES
from files import obj

memory.ADDRESSES = 1 << 30
PLACE = re.compile(r"line \d|:\d+:|\d+ \(from 0\)|\d|`[^`]+`|empty|folder|pipe|link to|device|no such|begins")


def judge(status, errors, output, name, nonsense):
    """The kind of an answer."""
    if status is None or status < 0 or status in (1, 101) or "panicked" in errors:
        return "dead"
    if status == 0:
        told = "warning" in errors or "warning" in output
        return "clear" if told else "accepted" if nonsense else "fine"
    line = next((line for line in errors.splitlines() if line.startswith("error")), "")
    message = line.split(name, 1)[-1]
    # What is missing or a folder needs no hint.
    is_plain = "no such file" in line or "is a folder" in line
    is_placed = is_plain or PLACE.search(message) and "hint" in errors
    is_clear = name in errors and is_placed and len(line) < 600
    return "clear" if is_clear else "vague"


def main():
    parser = argparse.ArgumentParser()
    default = os.path.join(os.path.dirname(__file__), "../../target/release/mimesh")
    parser.add_argument("program", nargs="?", default=default)
    parser.add_argument("--show", default="vague,accepted,dead")
    arguments = parser.parse_args()
    program, counts = os.path.abspath(arguments.program), collections.Counter()
    with tempfile.TemporaryDirectory() as folder:
        with open(os.path.join(folder, "tet.obj"), "wb") as file:
            file.write(obj())
        for name, contents, nonsense in CASES:
            # The contents of the files beside it stand under their names.
            files = contents if isinstance(contents, dict) else {"": contents}
            paths = [os.path.join(folder, beside or name) for beside in files]
            for path, content in zip(paths, files.values()):
                make(path, content)
            command = commands(program, folder, name)
            status, seconds, _, errors = memory.run(command, folder)
            with open(os.path.join(folder, "stdout")) as file:
                output = file.read()
            kind = judge(status, errors, output, name, nonsense)
            counts[kind] += 1
            if kind in arguments.show.split(","):
                first = (errors or output).strip().splitlines()
                print(f"{kind:9}{name:34}{status} {seconds:5.2f}s  {' | '.join(first[:3])[:230]}", flush=True)
            for path in paths:
                remove(path)
    print(", ".join(f"{counts[kind]} {kind}" for kind in ("clear", "fine", "vague", "accepted", "dead")))
    sys.exit(1 if counts["vague"] + counts["accepted"] + counts["dead"] else 0)


def make(path, contents):
    if contents == "pipe":
        os.mkfifo(path)
    elif contents == "folder":
        os.mkdir(path)
    elif isinstance(contents, str):
        os.symlink(contents, path)
    else:
        with open(path, "wb") as file:
            file.write(contents)


def remove(path):
    os.rmdir(path) if os.path.isdir(path) and not os.path.islink(path) else os.remove(path)


def commands(program, folder, name):
    """The command that reads a case."""
    if name.endswith(POSES):
        with open(os.path.join(folder, "run.yaml"), "w") as file:
            file.write(f"source: {{ rest: tet.obj, poses: {name} }}\ntarget: {{ rest: tet.obj }}\noutput: out.glb\n")
        return [program, "check", "run.yaml"]
    return memory.command(program, name)


main()
