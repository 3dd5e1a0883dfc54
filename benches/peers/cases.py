"""The works that are compared: a job of ours, the jobs of peers, and how their results are compared."""

from dataclasses import dataclass
from typing import Callable

import numpy

import checks
from meshes import Mesh, make, resolution, take


@dataclass
class Case:
    """One work on one mesh."""

    work: str
    mesh: str
    ours: dict
    # Name of the peer, its job, the check of its result. A check has the two files and our job.
    peers: list[tuple[str, dict, Callable]]
    # What a reader must know to judge the ratio.
    note: str = ""


def skin(runner, folder, proportions, vertices, handles=64):
    """An animal of about so many vertices, and how many it has."""
    settings = {"proportions": proportions, "resolution": resolution(proportions, vertices), "seed": int(proportions == "camel")}
    path = folder / f"{proportions}-{vertices}"
    return path, make(runner, path, handles, **settings)["vertices"]


def weights(mesh, vertices, counts):
    """Weights of handles, against libigl."""
    kinds = [
        ("bounded biharmonic weights", {"type": "bounded_biharmonic", "normalize": "none"}, {"function": "igl_bbw"}, checks.bounded),
        ("biharmonic weights", {"type": "biharmonic"}, {"function": "igl_harmonic", "k": 2}, checks.equal_weights(1e-5)),
        ("harmonic weights", {"type": "harmonic"}, {"function": "igl_harmonic", "k": 1}, checks.equal_weights(1e-8)),
    ]
    for name, stage, peer, check in kinds:
        for count in counts:
            ours = {"task": "weights", "mesh": str(mesh), "weights": stage, "handles": count}
            theirs = {**peer, "mesh": str(mesh), "handles": count}
            # The count is bound now, since the loop goes on.
            agree = lambda a, b, job, count=count, check=check: check(a, b, job, count)
            yield Case(f"{name}, {count} handles", f"{vertices:,} v", ours, [("libigl", theirs, agree)])


def plates(runner, folder, size):
    """Bounded weights of a camel in 20 plates, of which each has handles, against libigl."""
    mesh = folder / f"plates-20-{size}"
    # Plates have an inner side too.
    fine = max(round(resolution("camel", size) * 0.7), 20)
    made = make(runner, mesh, 64, proportions="camel", seed=1, made_of="plates", pieces=20, resolution=fine)
    ours = {"task": "weights", "mesh": str(mesh), "weights": {"type": "bounded_biharmonic", "normalize": "none"}, "handles": 64}
    agree = lambda a, b, job: checks.bounded(a, b, job, 64)
    peer = ("libigl", {"function": "igl_bbw", "mesh": str(mesh), "handles": 64}, agree)
    yield Case("bounded biharmonic weights of 20 plates, 64 handles", f"{made['vertices']:,} v", ours, [peer])


def deform(runner, folder, size):
    """As rigid as possible, with 64 handles where a pose has them."""
    mesh, vertices = skin(runner, folder, "horse", size)
    ours = {
        "task": "deform", "mesh": str(mesh), "handles": 64, "weights": {"type": "biharmonic"},
        "clusterer": {"type": "weight_kmeans"}, "deformer": {"type": "arap_skinning", "difference": "none"},
    }
    theirs = {"function": "igl_arap", "mesh": str(mesh), "handles": 64, "iterations": 20}
    note = "ours moves the maps of 64 handles until the energy stands still, libigl all vertices in 20 iterations"
    yield Case("as rigid as possible", f"{vertices:,} v", ours, [("libigl", theirs, checks.alike(3.0))], note)


def distances(runner, folder, size):
    """Distances along the surface from 12 vertices."""
    mesh, vertices = skin(runner, folder, "horse", size)
    ours = {"task": "distances", "mesh": str(mesh), "handles": 12}
    theirs = {"function": "potpourri_distances", "mesh": str(mesh), "handles": 12}
    note = "ours are shortest paths along edges and across pairs of triangles, potpourri3d's solutions of the heat equation"
    yield Case("distances from 12 vertices", f"{vertices:,} v", ours, [("potpourri3d", theirs, checks.close_distances)], note)


def closest(runner, folder, results, size):
    """The closest point of a mesh for as many points beside it as it has vertices."""
    mesh, vertices = skin(runner, folder, "horse", size)
    queries, shape = results / "queries", Mesh(mesh)
    moved = numpy.random.default_rng(0).normal(scale=0.02 * shape.diagonal(), size=(vertices, 3))
    (shape.vertices + moved).astype("<f8").tofile(queries)
    files = {"mesh": str(mesh), "points": str(queries)}
    peers = [
        ("libigl", {"function": "igl_closest", **files}, checks.as_near),
        ("trimesh", {"function": "trimesh_closest", **files}, checks.as_near),
    ]
    yield Case("closest points", f"{vertices:,} v", {"task": "closest", **files}, peers)


def correspondence(runner, folder, results, size):
    """The fit of a camel to a horse, from the same named points."""
    source, _ = skin(runner, folder, "horse", size)
    target, vertices = skin(runner, folder, "camel", size)
    files = {"source": str(source), "target": str(target)}
    ours = {"task": "correspond", **files, "correspondence": {"type": "nonrigid_fit"}}
    theirs = {"function": "trimesh_sumner", **files}
    agree = checks.carries_as_well(runner, results)
    yield Case("correspondence", f"{vertices:,} v", ours, [("trimesh nricp_sumner", theirs, agree)])


def files(runner, folder, results, size):
    """Reading and writing files on the disk."""
    mesh, vertices = skin(runner, folder, "horse", size)
    for kind, igl_takes in (("obj", True), ("ply", True)):
        written = results / f"horse-{size}.{kind}"
        ours = {"task": "write", "mesh": str(mesh), "format": {"type": kind}, "result": str(written)}
        peers = [
            (name, {"function": f"{prefix}_write", "mesh": str(mesh), "suffix": f".{kind}"}, checks.reads_back)
            for name, prefix in (("trimesh", "trimesh"), ("libigl", "igl"))
        ]
        yield Case(f"writing {kind.upper()}", f"{vertices:,} v", ours, peers)
        ours = {"task": "read", "format": {"type": kind}, "file": str(written)}
        peers = [
            (name, {"function": f"{prefix}_read", "file": str(written)}, checks.equal_vertices(1e-12))
            for name, prefix in (("trimesh", "trimesh"), ("libigl", "igl"))
        ]
        yield Case(f"reading {kind.upper()}", f"{vertices:,} v", ours, peers)


def all_cases(runner, folder, results, sizes, counts, only, files_of_meshes):
    """The cases in the order of the table: a work at a time, by size. Meshes are made in `folder` when they are needed."""
    for number, file in enumerate(files_of_meshes):
        mesh = folder / f"file-{number}"
        yield from weights(mesh, take(runner, mesh, file)["vertices"], counts)
    if files_of_meshes:
        return
    works = {
        "weights": lambda size: weights(*skin(runner, folder, "horse", size), counts),
        "plates": lambda size: plates(runner, folder, size),
        "deform": lambda size: deform(runner, folder, size),
        "distances": lambda size: distances(runner, folder, size),
        "closest": lambda size: closest(runner, folder, results, size),
        "correspondence": lambda size: correspondence(runner, folder, results, size),
        "files": lambda size: files(runner, folder, results, size),
    }
    for name, work in works.items():
        for size in sizes:
            if not only or name in only:
                yield from work(size)
