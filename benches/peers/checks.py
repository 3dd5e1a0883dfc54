"""Whether two results of one work agree. Each check gives a sentence and whether it holds."""

import numpy

from meshes import Mesh, columns, points


def energies(mesh, weights):
    """½ wᵀ L M⁻¹ L w of each column, by libigl's matrices."""
    import igl

    vertices, triangles = mesh.vertices, mesh.triangles
    laplacian = igl.cotmatrix(vertices, triangles)
    mass = igl.massmatrix(vertices, triangles, igl.MASSMATRIX_TYPE_VORONOI).diagonal()
    bent = laplacian @ weights
    return 0.5 * (bent**2 / mass[:, None]).sum(0)


def bounded(ours, peers, job, handles):
    """Each energy is at most a millionth above the peer's, within the same bounds."""
    mesh = Mesh(job["mesh"])
    ours, peers = (columns(path, handles) for path in (ours, peers))
    held = mesh.handles(handles)
    # Rounding of a solve, on both sides.
    slack = 1e-9
    is_within = ours.min() >= -slack and ours.max() <= 1 + slack
    is_held = numpy.abs(ours[held] - numpy.eye(handles)).max() <= slack
    above = (energies(mesh, ours) / energies(mesh, peers) - 1).max()
    difference = numpy.abs(ours - peers).max()
    outside = max(-peers.min(), peers.max() - 1, 0)
    said = f"energies at most {above:.1e} above, weights differ by {difference:.0e}"
    if outside > slack:
        said += f"; the peer leaves its bounds by {outside:.0e}"
    return said, bool(is_within and is_held and above <= 1e-6)


def equal_weights(tolerance):
    """Weights are equal, but for rounding in the solve of an ill-conditioned system."""

    def check(ours, peers, job, handles):
        difference = numpy.abs(columns(ours, handles) - columns(peers, handles)).max()
        return f"weights differ by {difference:.0e}", bool(difference <= tolerance)

    return check


def as_near(ours, peers, job):
    """Points found are as near as the peer's. Where several are, either may be found. trimesh misses some by a few millionths."""
    queries, diagonal = points(job["points"]), Mesh(job["mesh"]).diagonal()
    near = [numpy.linalg.norm(points(path) - queries, axis=1) / diagonal for path in (ours, peers)]
    farther, difference = (near[0] - near[1]).max(), numpy.abs(near[0] - near[1]).max()
    said = f"at most {max(farther, 0):.0e} diagonals farther, distances differ by {difference:.0e}"
    # Both compute in double precision.
    return said, bool(farther <= 1e-9 and difference <= 1e-4)


def close_distances(ours, peers, job):
    """Paths are some percent too long, and the heat method errs to both sides."""
    ours, peers = numpy.fromfile(ours, "<f8"), numpy.fromfile(peers, "<f8")
    is_far = peers > 0.05 * peers.max()
    ratio = numpy.median(ours[is_far] / peers[is_far])
    return f"distances are {ratio:.3f} times the peer's in the median", bool(abs(ratio - 1) <= 0.06)


def alike(limit):
    """Positions lie near each other where two methods differ by design."""

    def check(ours, peers, job):
        apart = numpy.linalg.norm(points(ours) - points(peers), axis=1)
        mean = 100 * apart.mean() / Mesh(job["mesh"]).diagonal()
        return f"positions {mean:.2f} % of the diagonal apart in the mean", bool(mean <= limit)

    return check


def error_of_map(runner, job, path, folder):
    """The error of poses that a map carries over by `gradient`, percent of the diagonal, against the animal's own gait."""
    carried = folder / "carried"
    transfer = {
        "task": "transfer", "source": job["source"], "target": job["target"], "map": str(path),
        "transfer": {"type": "gradient"}, "result": str(carried),
    }
    runner.ours(transfer, runs=1)
    target, squares = Mesh(job["target"]), []
    for k in range(target.poses()):
        apart = points(carried / f"pose-{k}") - target.pose(k)
        squares.append(((apart - apart.mean(0)) ** 2).sum(1).mean())
    return 100 * float(numpy.mean(squares)) ** 0.5 / target.diagonal()


def carries_as_well(runner, folder):
    """Poses carried over along our map are at most as far off as along the peer's."""

    def check(ours, peers, job):
        found = [error_of_map(runner, job, path, folder) for path in (ours, peers)]
        return f"poses off by {found[0]:.2f} % with our map, {found[1]:.2f} % with the peer's", found[0] <= 1.02 * found[1]

    return check


def equal_vertices(tolerance):
    """Vertices are equal, as far as the file holds digits."""

    def check(ours, peers, job):
        ours, peers = points(ours), points(peers)
        if ours.shape != peers.shape:
            return f"{len(ours)} and {len(peers)} vertices", False
        difference = numpy.abs(ours - peers).max()
        return f"vertices differ by {difference:.0e}", bool(difference <= tolerance)

    return check


def reads_back(ours, peers, job):
    """Both files have the vertices of the mesh, read by one reader; ours in single precision at least, the peer's in six digits."""
    import trimesh

    vertices, off = Mesh(job["mesh"]).vertices, []
    for path in (ours, peers):
        read = numpy.asarray(trimesh.load(path, process=False, maintain_order=True).vertices)
        if read.shape != vertices.shape:
            return f"{path} has {len(read)} vertices, not {len(vertices)}", False
        off.append(float(numpy.abs(read - vertices).max() / numpy.abs(vertices).max()))
    return f"vertices are off by {off[0]:.0e}, the peer's by {off[1]:.0e}", off[0] <= 1e-7 and off[1] <= 1e-5
