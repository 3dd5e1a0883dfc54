"""Computes with trimesh, libigl and numpy what the metrics of mimesh say of meshes, for tests/peers.rs to compare.

Reads a list of cases as JSON from standard input, each with the `triangles` of a surface, its positions at `rest` and in a
`pose`, and prints for each a mapping of figures.
"""

import json
import sys

import igl
import numpy as np
import trimesh


def percentile(values, weights, share):
    """The smallest value such that those up to it have the share of the weight."""
    order = np.argsort(values, kind="stable")
    reached = np.cumsum(weights[order])
    return values[order][min(np.searchsorted(reached, share * reached[-1] * (1 - 1e-9)), len(values) - 1)]


def changes(rest, posed):
    """Percentiles of ratios of sizes."""
    s = np.log(posed / rest)
    growth = lambda x: 100 * np.expm1(x)
    return {
        "p99": growth(percentile(np.abs(s), rest, 0.99)),
        "max": growth(np.abs(s).max()),
        "median": growth(percentile(s, rest, 0.5)),
    }


def crossing_pairs(positions, triangles):
    """Pairs of triangles without a common vertex that meet, by exact arithmetic (CGAL, through libigl)."""
    from igl.copyleft import cgal

    found = cgal.remesh_self_intersections(positions, triangles, detect_only=True)
    pairs = next(a for a in found if a.ndim == 2 and a.shape[1] == 2)
    a, b = triangles[pairs[:, 0]], triangles[pairs[:, 1]]
    apart = ~(a[:, :, None] == b[:, None, :]).any(axis=(1, 2))
    return pairs[apart]


def figures(case):
    triangles = np.array(case["triangles"], dtype=np.int64)
    rest, posed = (np.array(case[key], dtype=np.float64) for key in ("rest", "pose"))
    meshes = [trimesh.Trimesh(v, triangles, process=False) for v in (rest, posed)]
    edges = [np.linalg.norm(v[meshes[0].edges_unique[:, 0]] - v[meshes[0].edges_unique[:, 1]], axis=1) for v in (rest, posed)]
    areas = [igl.doublearea(v, triangles) / 2 for v in (rest, posed)]
    edges = {**changes(*edges), "left_out": 0}
    longest = igl.edge_lengths(rest, triangles).max(axis=1)
    thick = 2 * areas[0] / longest > 1e-5 * np.linalg.norm(np.ptp(rest, axis=0))
    areas = {**changes(areas[0][thick], areas[1][thick]), "left_out": int((~thick).sum())}
    result = {
        "components": int(igl.vertex_components(triangles).max()) + 1,
        "trimesh_components": len(trimesh.graph.connected_components(meshes[0].edges, min_len=1)),
        "edge_stretch": edges,
        "area_change": areas,
    }
    if meshes[0].is_watertight:
        result["volume"] = {
            "change": 100 * (meshes[1].volume / meshes[0].volume - 1),
            "igl_change": 100 * (igl.centroid(posed, triangles)[1] / igl.centroid(rest, triangles)[1] - 1),
        }
    if case["crossings"]:
        old = np.unique(crossing_pairs(rest, triangles))
        new = np.setdiff1d(np.unique(crossing_pairs(posed, triangles)), old)
        result["self_intersections"] = {"share": 100 * len(new) / len(triangles)}
    return result


json.dump([figures(case) for case in json.load(sys.stdin)], sys.stdout)
