"""Runs one function of a peer on a mesh in a folder, and prints what it took, as `main.rs` does for a stage of ours.

The peer's library is loaded and its input in memory before the clock starts. Each job imports only what it uses.
"""

import json
import sys
import time
from pathlib import Path

import numpy

from meshes import Mesh, points

PHASES = {}
RESIDENT = None


class phase:
    """Measures what stands in a `with`: CPU time of all threads, and wall time."""

    def __init__(self, name):
        self.name = name

    def __enter__(self):
        global RESIDENT
        RESIDENT = RESIDENT or memory("VmRSS:")
        self.cpu, self.wall = time.process_time(), time.perf_counter()

    def __exit__(self, *_):
        PHASES[self.name] = {"cpu": time.process_time() - self.cpu, "wall": time.perf_counter() - self.wall}


def memory(name):
    """The memory of the process, bytes, by its name in /proc; the memory that a parent learns of includes its own."""
    status = Path("/proc/self/status")
    lines = status.read_text().splitlines() if status.is_file() else []
    return next((1024 * int(line.split()[1]) for line in lines if line.startswith(name)), None)


def igl_bbw(job):
    import igl

    mesh = Mesh(job["mesh"])
    vertices, triangles, handles = mesh.vertices, mesh.triangles, mesh.handles(job["handles"])
    with phase("solve"):
        weights = igl.bbw(vertices, triangles, handles, numpy.eye(len(handles)))
    weights.T.astype("<f8").tofile(job["result"])


def igl_harmonic(job):
    import igl

    mesh = Mesh(job["mesh"])
    vertices, triangles, handles = mesh.vertices, mesh.triangles, mesh.handles(job["handles"])
    with phase("solve"):
        weights = igl.harmonic(vertices, triangles, handles, numpy.eye(len(handles)), job["k"])
    weights.T.astype("<f8").tofile(job["result"])


def igl_arap(job):
    import igl

    mesh = Mesh(job["mesh"])
    vertices, triangles, pose = mesh.vertices, mesh.triangles, mesh.pose(0)
    handles = mesh.handles(job["handles"]).astype(numpy.int32)
    data = igl.ARAPData()
    data.energy = igl.ARAP_ENERGY_TYPE_SPOKES
    data.max_iter = job["iterations"]
    with phase("bind"):
        igl.arap_precomputation(vertices, triangles, 3, handles, data)
    with phase("fit"):
        posed = igl.arap_solve(pose[handles], data, vertices)
    posed.astype("<f8").tofile(job["result"])


def igl_closest(job):
    import igl

    mesh, queries = Mesh(job["mesh"]), points(job["points"])
    vertices, triangles = mesh.vertices, mesh.triangles
    with phase("find"):
        _, _, found = igl.point_mesh_squared_distance(queries, vertices, triangles)
    found.astype("<f8").tofile(job["result"])


def trimesh_closest(job):
    import trimesh

    mesh, queries = Mesh(job["mesh"]), points(job["points"])
    surface = trimesh.Trimesh(mesh.vertices, mesh.triangles, process=False)
    with phase("find"):
        found, _, _ = trimesh.proximity.closest_point(surface, queries)
    found.astype("<f8").tofile(job["result"])


def potpourri_distances(job):
    import potpourri3d

    mesh = Mesh(job["mesh"])
    vertices, triangles, handles = mesh.vertices, mesh.triangles, mesh.handles(job["handles"])
    with phase("bind"):
        solver = potpourri3d.MeshHeatMethodDistanceSolver(vertices, triangles)
    with phase("distances"):
        found = [solver.compute_distance(int(handle)) for handle in handles]
    numpy.array(found, "<f8").tofile(job["result"])


def trimesh_sumner(job):
    """Fits the target to the source, as `nonrigid_fit` does, from the same points."""
    import trimesh

    source, target = Mesh(job["source"]), Mesh(job["target"])
    of_source, of_target = source.landmarks, target.landmarks
    names = [name for name in of_source if name in of_target]
    corners = source.vertices[source.triangles[[of_source[name][0] for name in names]]]
    goals = (corners * numpy.array([of_source[name][1] for name in names])[:, :, None]).sum(1)
    landmarks = ([of_target[name][0] for name in names], numpy.array([of_target[name][1] for name in names]))
    moving = trimesh.Trimesh(target.vertices, target.triangles, process=False)
    fixed = trimesh.Trimesh(source.vertices, source.triangles, process=False)
    with phase("correspond"):
        found = trimesh.registration.nricp_sumner(
            moving, fixed, (numpy.array(landmarks[0]), landmarks[1]), goals, use_vertex_normals=True
        )
    write_map(fixed, moving, numpy.asarray(found), job["result"])


def write_map(source, target, fitted, path):
    """The map that a fit gives: under each vertex and each triangle of the target what lies nearest on the source."""
    import trimesh

    places, _, triangles = trimesh.proximity.closest_point(source, fitted)
    barycentric = trimesh.triangles.points_to_barycentric(source.triangles[triangles], places)
    _, _, partners = trimesh.proximity.closest_point(source, fitted[target.faces].mean(1))
    found = [{"Triangle": [int(t), b.tolist()]} for t, b in zip(triangles, barycentric)]
    document = {"source_triangles": len(source.faces), "partners": partners.tolist(), "points": found}
    Path(path).write_text(json.dumps(document))


def trimesh_read(job):
    import trimesh

    with phase("read"):
        mesh = trimesh.load(job["file"], process=False, maintain_order=True)
    numpy.asarray(mesh.vertices, "<f8").tofile(job["result"])


def trimesh_write(job):
    import trimesh

    mesh = Mesh(job["mesh"])
    surface = trimesh.Trimesh(mesh.vertices, mesh.triangles, process=False)
    with phase("write"):
        surface.export(job["result"])


def igl_read(job):
    import igl

    with phase("read"):
        vertices, _ = igl.read_triangle_mesh(job["file"])
    vertices.astype("<f8").tofile(job["result"])


def igl_write(job):
    import igl

    mesh = Mesh(job["mesh"])
    vertices, triangles = mesh.vertices, mesh.triangles
    with phase("write"):
        igl.write_triangle_mesh(job["result"], vertices, triangles)


if __name__ == "__main__":
    task = json.loads(Path(sys.argv[1]).read_text())
    globals()[task.pop("function")](task)
    print(json.dumps({"phases": PHASES, "resident": RESIDENT, "peak": memory("VmHWM:"), "about": None}))
