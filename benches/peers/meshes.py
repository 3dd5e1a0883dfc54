"""Meshes that mimesh makes, as folders of bare numbers. `files.rs` describes them."""

import json
from pathlib import Path

import numpy


class Mesh:
    """A mesh in a folder."""

    def __init__(self, folder):
        self.folder = Path(folder)

    @property
    def vertices(self):
        return points(self.folder / "vertices")

    @property
    def triangles(self):
        return numpy.fromfile(self.folder / "triangles", "<u4").reshape(-1, 3).astype(numpy.int64)

    @property
    def landmarks(self):
        return json.loads((self.folder / "landmarks.json").read_text())

    def handles(self, count):
        return numpy.fromfile(self.folder / "handles", "<u4")[:count].astype(numpy.int64)

    def pose(self, k):
        return points(self.folder / f"pose-{k}")

    def poses(self):
        return len(list(self.folder.glob("pose-*")))

    def diagonal(self):
        vertices = self.vertices
        return float(numpy.linalg.norm(vertices.max(0) - vertices.min(0)))


def points(path):
    """Points in a file."""
    return numpy.fromfile(path, "<f8").reshape(-1, 3)


def columns(path, count):
    """A matrix of `count` columns in a file, column by column."""
    return numpy.fromfile(path, "<f8").reshape(count, -1).T


def resolution(proportions, vertices):
    """The resolution at which an animal has about as many vertices."""
    at_60 = {"horse": 6850, "camel": 7680}[proportions]
    return max(20, round(60 * (vertices / at_60) ** 0.5))


def make(runner, folder, handles=64, **settings):
    """Makes a mesh unless the folder has it from before, and gives what is known of it."""
    generator = {"type": "quadruped", "gait": "gallop", "frames": 4, **settings}
    job = {
        "task": "make", "generator": generator, "handles": {"type": "farthest_point", "count": handles},
        "mesh": str(folder),
    }
    about, asked = Path(folder, "about.json"), Path(folder, "job.json")
    if not about.is_file() or not asked.is_file() or json.loads(asked.read_text()) != job:
        made = runner.ours(job, runs=1)
        about.write_text(json.dumps(made["about"]))
        asked.write_text(json.dumps(job))
    return json.loads(about.read_text())


def take(runner, folder, file):
    """Takes a mesh from an OBJ file, and gives what is known of it."""
    job = {
        "task": "import", "format": {"type": "obj"}, "file": str(file), "poses": [],
        "handles": {"type": "farthest_point", "count": 64}, "mesh": str(folder),
    }
    return runner.ours(job, runs=1)["about"]
