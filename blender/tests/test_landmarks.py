"""Landmarks from empties and vertex groups."""

import bpy
import numpy as np
import pytest
from conftest import add_mesh, choose, shape, transfer

import mimesh
from mimesh_blender import landmarks
from mimesh_blender.source import polygons_of, rest_of


@pytest.fixture
def pair(scene, horse, camel):
    return add_mesh("horse", horse, with_poses=True), add_mesh("camel", camel)


def empty(name, at, parent=None):
    obj = bpy.data.objects.new(name, None)
    bpy.context.scene.collection.objects.link(obj)
    obj.location = at
    obj.parent = parent
    return obj


@pytest.fixture(scope="module")
def points(horse, camel):
    """Vertices of horse and camel at the ends of both along several directions, which correspond well enough."""

    def extremes(mesh):
        x, y, z = mesh.vertices.T
        ends = (z, -z, y, -y, x + y - z, x - y - z, -x + y - z, -x - y - z)
        return [int(np.argmax(values)) for values in ends]

    return list(zip(extremes(horse), extremes(camel)))


def test_empties_by_name_lie_on_the_surfaces(pair, points, horse, camel):
    source, target = pair
    source.location, source.scale = (0, 0, 7), (1, 3, 1)
    for i, (a, b) in enumerate(points):
        empty(f"point{i}.source", horse.vertices[a] * [1, 3, 1] + [0, 0, 7])
        empty(f"point{i}.target", camel.vertices[b])
    bpy.context.view_layer.update()
    found = landmarks.from_empties(bpy.context.scene, source, target, horse, camel)
    for side, mesh, which in ((found._source, horse, 0), (found._target, camel, 1)):
        for place, ends in zip(side, points):
            at = np.array(place["barycentric"]) @ mesh.vertices[mesh.faces[place["triangle"]]]
            np.testing.assert_allclose(at, mesh.vertices[ends[which]], atol=1e-5)
    assert transfer(source, target, landmarks="EMPTIES") == {"FINISHED"}
    assert found.names == [f"point{i}" for i in range(len(points))]
    assert np.abs(shape(target, "01") - camel.vertices).max() > 0.05


def test_children_of_equal_names_are_pairs(pair, points, horse, camel):
    source, target = pair
    for i, (a, b) in enumerate(points):
        empty(f"point{i}", horse.vertices[a], source)
        empty(f"point{i}", camel.vertices[b], target)
    bpy.context.view_layer.update()
    found = landmarks.from_empties(bpy.context.scene, source, target, horse, camel)
    assert found.names == [f"point{i}" for i in range(len(points))] and not found.messages


def test_an_empty_without_a_partner_is_named(pair):
    for name in ("nose.source", "tail.target", "ear.source", "ear.target"):
        empty(name, (0, 0, 0))
    with pytest.raises(RuntimeError, match=r"no empty on the target \(camel\) for nose; no empty on the source \(horse\) for tail\nHint: "):
        transfer(*pair, landmarks="EMPTIES")
    assert pair[1].data.shape_keys is None


def test_no_empties_and_few_are_refused(pair):
    with pytest.raises(RuntimeError, match="there are no empties"):
        transfer(*pair, landmarks="EMPTIES")
    for side in ("source", "target"):
        empty(f"nose.{side}", (0, 0, 0))
    with pytest.raises(RuntimeError, match="there are only 1 landmark"):
        transfer(*pair, landmarks="EMPTIES")


def test_an_empty_far_from_the_surface_is_said(pair, points, horse, camel):
    for i, (a, b) in enumerate(points):
        empty(f"point{i}.source", horse.vertices[a] + ([0, 0, 9] if i == 0 else [0, 0, 0]))
        empty(f"point{i}.target", camel.vertices[b])
    bpy.context.view_layer.update()
    found = landmarks.from_empties(bpy.context.scene, *pair, horse, camel)
    assert found.messages == ["far from the surface of horse at rest: point0.source"]


def test_vertex_groups_of_equal_names_are_pairs(pair, points):
    source, target = pair
    for i, ends in enumerate(points):
        for obj, vertex in zip(pair, ends):
            obj.vertex_groups.new(name=f"point{i}").add([vertex], 1.0, "REPLACE")
    source.vertex_groups.new(name="alone").add([0], 1.0, "REPLACE")
    assert transfer(source, target, landmarks="GROUPS") == {"FINISHED"}
    assert any(message.text.endswith("left out: alone") for message in bpy.context.scene.mimesh.outcome.messages)
    found = landmarks.from_groups(source, target, np.zeros((len(source.data.vertices), 3)), np.zeros((len(target.data.vertices), 3)))
    assert [place["vertex"] for place in found._target] == [b for _, b in points]


def test_no_common_group_is_refused(pair):
    with pytest.raises(RuntimeError, match="no vertex group of equal name"):
        transfer(*pair, landmarks="GROUPS")


def test_landmarks_found_by_shape_become_empties_to_be_corrected(pair, horse, camel):
    choose(*pair)
    pair[0].location = (0, 0, 5)
    assert bpy.ops.mimesh.find_landmarks() == {"FINISHED"}
    assert bpy.context.scene.mimesh.landmarks == "EMPTIES"
    bpy.context.view_layer.update()
    found = landmarks.from_empties(bpy.context.scene, *pair, horse, camel)
    assert len(found.names) >= 4 and not found.messages
    expected = mimesh.landmarks.Extremities().propose(*(mimesh.Mesh(rest_of(obj), polygons_of(obj)) for obj in pair))
    assert len(expected) == len(found.names)
    for place, point in zip(found._source, expected):
        vertices = [horse.vertices[horse.faces[triangle]] for triangle in (place["triangle"], point[0][0])]
        np.testing.assert_allclose(place["barycentric"] @ vertices[0], point[0][1] @ vertices[1], atol=1e-4)
    with pytest.raises(RuntimeError, match="there are empties as landmarks already\nHint: Delete"):
        bpy.ops.mimesh.find_landmarks()
    assert bpy.ops.mimesh.transfer() == {"FINISHED"}
