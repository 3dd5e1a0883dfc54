"""The stages that are a part of mimesh, called one by one."""

from __future__ import annotations

import inspect
import keyword

import numpy as np
import pytest

import mimesh


def test_every_stage_has_a_class_with_its_settings_and_words() -> None:
    entries = mimesh.registry()
    assert len(entries) > 40
    from mimesh._registry import MODULES, class_name
    from mimesh._stages import _written

    for entry in entries:
        if (entry["kind"], entry["type"]) in _written:
            continue
        cls = getattr(getattr(mimesh, MODULES[entry["kind"]]), class_name(entry["type"]))
        assert (cls.kind, cls.type) == (entry["kind"], entry["type"])
        assert entry["description"].splitlines()[0] in cls.__doc__
        settings = [key for key in entry["schema"].get("properties", {}) if not keyword.iskeyword(key)]
        assert list(inspect.signature(cls).parameters) == settings
        for setting in entry["schema"].get("properties", {}):
            assert f"{setting}:" in cls.__doc__


def test_settings_have_defaults_and_are_refused_with_the_words_of_the_registry() -> None:
    sampler = mimesh.samplers.FarthestPoint(count=12)
    assert sampler.settings == {"count": 12, "seed": 0, "metric": "geodesic"}
    assert sampler.to_dict() == {"type": "farthest_point", "count": 12}
    assert repr(sampler) == "FarthestPoint(count=12)" and sampler == mimesh.samplers.FarthestPoint(count=12)
    for settings, words in [
        ({"count": 0}, "`count`: expected at least 1, found 0"),
        ({"count": "many"}, "`count`: expected a whole number, 0 or more, found the string \"many\""),
        ({"cuont": 3}, "unknown key `cuont`"),
        ({"metric": "straight"}, "`metric`"),
    ]:
        with pytest.raises(mimesh.UsageError) as refused:
            mimesh.samplers.FarthestPoint(**settings)
        assert words in str(refused.value)
        assert refused.value.diagnostics
    with pytest.raises(ValueError, match="weights"):
        mimesh.transfers.Biharmonic(weights={"type": "none_such"})
    nested = mimesh.transfers.Biharmonic(weights=mimesh.weights.Harmonic(bridge=1.0))
    assert nested.settings["weights"] == {"type": "harmonic", "bridge": 1.0}


def test_descriptions_are_text() -> None:
    assert "farthest_point: Vertices spread evenly" in mimesh.describe("sampler")
    assert "count: Number of points. Default: ``100``." in mimesh.describe("sampler", "farthest_point")
    assert {"sampler", "transfer", "metric"} <= {line for line in mimesh.describe().splitlines()}


def test_samplers_give_points_of_the_mesh(horse) -> None:
    points = mimesh.samplers.FarthestPoint(count=20, metric="euclidean").sample(horse)
    assert len(set(points)) == 20 and all(0 <= point < len(horse.vertices) for point in points)
    # Each is the farthest from those before.
    chosen = horse.vertices[points]
    for k in range(1, 20):
        distance = np.linalg.norm(horse.vertices[:, None] - chosen[:k], axis=2).min(axis=1)
        assert distance[points[k]] == pytest.approx(distance.max(), rel=1e-12)
    inside = mimesh.samplers.PoissonDisk().sample(horse.surface)
    assert inside


def test_points_count_as_the_file_does() -> None:
    # Two triangles whose common edge is there twice, as at a seam of textures.
    vertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 1, 0], [1, 0, 0], [1, 1, 0], [9, 9, 9]]
    mesh = mimesh.Mesh(vertices, [[0, 1, 2], [3, 4, 5]])
    assert len(mesh.surface.vertices) == 4
    assert mesh.surface.vertex_of.tolist() == [0, 1, 2, 2, 1, 3, -1]
    points = mimesh.samplers.FarthestPoint(count=4).sample(mesh)
    assert sorted(points) == [0, 1, 2, 5]
    weights = mimesh.weights.Harmonic().solve(mesh, [0, 5])
    assert weights.shape == (7, 2)
    np.testing.assert_allclose(weights[:6].sum(axis=1), 1, atol=1e-12)
    np.testing.assert_array_equal(weights[[1, 2]], weights[[4, 3]])
    np.testing.assert_array_equal(weights[6], 0)
    with pytest.raises(ValueError, match="vertex 6"):
        mimesh.weights.Harmonic().solve(mesh, [0, 6])


def test_weights_keep_their_laws(grid) -> None:
    handles = [0, 11, 143, 70]
    for stage in (mimesh.weights.Harmonic(), mimesh.weights.BoundedBiharmonic(), mimesh.weights.GeodesicFalloff()):
        weights = stage.solve(grid, handles)
        np.testing.assert_allclose(weights.sum(axis=1), 1, atol=1e-9)
        np.testing.assert_array_equal(weights[handles], np.eye(4))


def test_a_transfer_in_two_phases_is_that_of_the_pipeline(horse) -> None:
    target = horse.with_vertices(horse.vertices * [1.0, 1.2, 0.9])
    map = mimesh.correspondences.Identity().correspond(horse, target)
    np.testing.assert_array_equal(map.triangles, np.arange(len(horse.faces)))
    bound = mimesh.transfers.Gradient().bind(horse, target, map)
    result = mimesh.transfer(horse, target, correspondence="identity", transfer="gradient", metrics=[])
    for i in range(len(horse.poses)):
        np.testing.assert_allclose(bound.transfer(horse.pose(i)), result.positions[i], rtol=0, atol=1e-9)
    np.testing.assert_allclose(bound.transfer(horse.vertices), target.vertices, atol=1e-9)
    with pytest.raises(mimesh.BadDataError):
        mimesh.transfers.Gradient().bind(horse, target)


def test_the_other_kinds(horse, camel, grid) -> None:
    pairs = mimesh.landmarks.Extremities().propose(horse, camel)
    assert pairs and all(0 <= sure <= 1 for _, _, sure in pairs)
    two = mimesh.Mesh(
        np.concatenate([grid.vertices, grid.vertices + [0, 0, 1.0]]), np.concatenate([grid.faces, grid.faces + 144])
    )
    (link,) = mimesh.proximity.SpanningTree().link(two)
    gaps = np.linalg.norm(two.vertices[:144, None] - two.vertices[None, 144:], axis=2)
    assert link.components == (0, 1) and link.distance == pytest.approx(gaps.min(), rel=1e-12)
    weights = mimesh.weights.Harmonic().solve(grid.surface, [0, 143])
    labels = mimesh.clusterers.WeightKmeans().cluster(grid.surface, [], weights)
    assert labels.shape == (144,) and labels.max() <= 1
    shift = np.array([0.3, 0.1, -0.2])
    maps = mimesh.deformers.LinearBlend().fit(grid.surface, weights, labels, grid.surface.vertices + shift)
    np.testing.assert_allclose(maps, np.tile(np.column_stack([np.eye(3), shift]), (2, 1, 1)), atol=1e-6)
    chosen = mimesh.key_points.Given(points=[3, 40]) if "points" in mimesh.key_points.Given().settings else None
    assert chosen is None or chosen.choose(horse) == [3, 40]


def test_landmarks_are_used_as_markers(horse, camel) -> None:
    result = mimesh.transfer(horse, mimesh.Mesh(camel.vertices, camel.faces), markers=mimesh.landmarks.Extremities())
    assert any(stage["stage"] == "landmarks" for stage in result.report["stages"])
