"""Files that ask for much more than they are: each of about `size` bytes, by its name."""

import base64
import json
import math
import struct
import zlib

from files import *


def grid(count):
    """About `count` vertices and twice as many triangles of a square."""
    n = max(2, math.isqrt(count))
    vertices = [(i % n, i // n, 0) for i in range(n * n)]
    quads = [(i * n + j, i * n + j + 1, (i + 1) * n + j, (i + 1) * n + j + 1) for i in range(n - 1) for j in range(n - 1)]
    return vertices, [t for a, b, c, d in quads for t in ((a, b, d), (a, d, c))]


def circle(count):
    """Points on a circle."""
    return [(math.cos(i), math.sin(i), 0) for i in range(count)]


def many_faces_on_an_edge(size):
    n = size // 36
    return "edge.obj", obj([(0, 0, 0), (1, 0, 0), *((i, 1, i) for i in range(n))], [(0, 1, 2 + i) for i in range(n)])


def boundaries_at_one_place(size):
    n = size // 60
    up = [(3 * i, 3 * i + 1, 3 * i + 2) for i in range(n)]
    turn = [(a, c, b) if i % 2 else (a, b, c) for i, (a, b, c) in enumerate(up)]
    return "place.obj", obj(flat([[(0, 0, 0), (1, 0, 0), (0, 1, i)] for i in range(n)]), turn)


def one_hub(size):
    n = size // 36
    return "hub.obj", obj([(0, 0, 5), *circle(n)], [(0, 1 + i, 1 + (i + 1) % n) for i in range(n)])


def hub_with_normals(size):
    n = size // 80
    text = [f"v {x} {y} {z}" for x, y, z in [(0, 0, 5), *circle(n)]]
    text += [f"vn 0 {i} 1" for i in range(n)]
    text += [f"f 1//{i + 1} {i + 2}//{i + 1} {(i + 1) % n + 2}//{i + 1}" for i in range(n)]
    return "normals.obj", "\n".join(text).encode()


def one_polygon(size):
    n = size // 28
    return "polygon.obj", obj([(round(x, 6), round(y, 6), z) for x, y, z in circle(n)], [range(n)])


def repeated_corner(size):
    return "corner.obj", obj() + b"f" + b" 1" * (size // 2)


def many_names(size):
    text = [f"o {i}\ng {i}\nusemtl {i}\nf 1 2 3" for i in range(size // 36)]
    return "names.obj", obj() + "\n".join(text).encode()


def groups_times_parts(size):
    n = size // 40
    text = "g " + " ".join(map(str, range(n))) + "\n" + "usemtl a\nf 1 2 3\nusemtl b\nf 1 2 3\n" * n
    return "groups.obj", obj() + text.encode()


def forward_references(size):
    return "forward.obj", b"f 1/1/1 2/1/1 3/1/1\n" * (size // 20) + obj() + b"vt 0 0\nvn 0 0 1\n"


def nested_components(size):
    n = size // 130
    vertices, faces = [], []
    for i in range(n):
        s, first = n - i, len(vertices)
        vertices += [(-s, -s, -s), (3 * s, -s, -s), (-s, 3 * s, -s), (-s, -s, 3 * s)]
        faces += [tuple(first + v for v in (face if i % 2 else face[::-1])) for face in FACES]
    return "nested.obj", obj(vertices, faces)


def off_lines(size):
    n = size // 8
    return "lines.off", f"OFF\n3 {n} 0\n0\n0\n0\n1\n0\n0\n0\n1\n0\n".encode() + b"3\n0\n1\n2\n" * n


def ply_bytes(size):
    n = size // 4
    xyz = "property uchar x\nproperty uchar y\nproperty uchar z"
    face = "property list uint uchar vertex_indices"
    return "bytes.ply", ply_header("binary_little_endian", n, 1, xyz, face) + bytes(range(256)) * (3 * n // 256) + bytes(
        3 * n % 256) + struct.pack("<I", n) + bytes([0, 1, 2]) * (n // 3) + bytes(n % 3)


def ply_strip(size):
    xyz = "property uchar x\nproperty uchar y\nproperty uchar z"
    header = ply_header("binary_little_endian", 4, 1, xyz, "property list uint uchar vertex_indices")
    n = size // 3 * 3
    strip = struct.pack("<I", n) + bytes([0, 1, 2]) * (n // 3)
    return "strip.ply", header.replace(b"element face", b"element tristrips") + bytes([0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1]) + strip


def ply_elements(size):
    n = size // 40
    lines = "".join(f"element nothing{i} {size // 2}\n" for i in range(n))
    return "elements.ply", ply_header("ascii", 4, 4).replace(b"end_header", lines.encode() + b"end_header") + ply_text()[
        len(ply_header("ascii", 4, 4)):] + b"\n" * (size // 2)


def ply_text_numbers(size):
    n = size // 6
    return "numbers.ply", ply_header("ascii", n, 1) + b"0 0 1\n" * n + b"3 0 1 2\n"


def stl_words(size):
    facet = b"facet outer vertex 0 0 0 vertex 0 1 0 vertex 1 0 0 endloop endfacet\n"
    return "words.stl", b"solid\n" + facet * (size // len(facet)) + b"endsolid\n"


def stl_corners(size):
    n = size // 50
    return "corners.stl", stl_binary([(i, i % 7, i % 3) for i in range(3 * n)], [(3 * i, 3 * i + 1, 3 * i + 2) for i in range(n)])


def nodes_of_a_mesh(size):
    gltf = tetrahedron(*grid(size // 96))
    n = size // 24
    gltf.json["nodes"], gltf.json["scenes"] = [{"mesh": 0}] * n, [{"nodes": list(range(n))}]
    return "nodes.glb", gltf.glb()


def primitives_of_an_accessor(size):
    gltf = tetrahedron(*grid(size // 96))
    gltf.json["meshes"][0]["primitives"] *= size // 2 // 52
    return "primitives.glb", gltf.glb()


def colours_of_a_primitive(size):
    gltf = tetrahedron(*grid(size // 120))
    count = gltf.json["accessors"][0]["count"]
    primitive = gltf.json["meshes"][0]["primitives"][0]
    primitive["attributes"]["COLOR_0"] = gltf.accessor(gltf.view(bytes(4 * count)), "VEC4", count, 5121, normalized=True)
    primitive["indices"] = gltf.indices(FACES[:1])
    gltf.json["meshes"][0]["primitives"] *= size // 2 // 70
    return "colours.glb", gltf.glb()


def targets_of_an_accessor(size):
    gltf = tetrahedron(*grid(size // 96))
    position = gltf.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"]
    gltf.json["meshes"][0]["primitives"][0]["targets"] = [{"POSITION": position}] * (size // 2 // 16)
    return "targets.glb", gltf.glb()


def accessors_of_a_view(size):
    gltf = tetrahedron(*grid(size // 96))
    count = gltf.json["accessors"][0]["count"]
    targets = [{"POSITION": gltf.accessor(0, "VEC3", count)} for _ in range(size // 2 // 100)]
    gltf.json["meshes"][0]["primitives"][0]["targets"] = targets
    return "views.glb", gltf.glb()


def sparse_accessors_of_a_view(size):
    gltf = tetrahedron(*grid(size // 96))
    count = gltf.json["accessors"][0]["count"]
    at = gltf.view(struct.pack(f"<{count}I", *range(count)))
    sparse = {"count": count, "indices": {"bufferView": at, "componentType": 5125}, "values": {"bufferView": 0}}
    targets = [{"POSITION": gltf.accessor(None, "VEC3", count, sparse=sparse)} for _ in range(size // 2 // 180)]
    gltf.json["meshes"][0]["primitives"][0]["targets"] = targets
    return "sparse.glb", gltf.glb()


def zeros_without_data(size):
    gltf = tetrahedron()
    n = size // 140
    for _ in range(n):
        position = gltf.accessor(None, "VEC3", 65536)
        gltf.json["meshes"][0]["primitives"].append({"attributes": {"POSITION": position}})
    return "zeros.glb", gltf.glb()


def weights_of_nodes(size):
    gltf = tetrahedron()
    n = size // 3 // 12
    gltf.json["meshes"][0]["weights"] = [0.5] * (size // 3 // 5)
    gltf.json["nodes"] = [{"mesh": 0}] * n
    gltf.json["scenes"] = [{"nodes": [0]}]
    return "weights.glb", gltf.glb()


def nodes_without_anything(size):
    gltf = tetrahedron()
    gltf.json["nodes"] += [{}] * (size // 4)
    return "empty-nodes.glb", gltf.glb()


def brackets(size):
    text = json.dumps(tetrahedron().json)[:-1] + ', "extras": [' + "[]," * (size // 3) + "0] }"
    return "brackets.gltf", text.encode()


def chain_of_nodes(size):
    gltf = tetrahedron()
    n = size // 24
    gltf.json["nodes"] = [{"children": [i + 1]} for i in range(n)] + [{"mesh": 0, "name": "end"}]
    return "chain.glb", gltf.glb()


def chain_of_empties(size):
    gltf = tetrahedron()
    n = size // 40
    gltf.json["nodes"] = [{"children": [i + 1], "name": f"n{i}"} for i in range(n)] + [{"mesh": 0, "name": "end"}]
    return "chain-of-empties.glb", gltf.glb()


def deep_json(size):
    return "deep.gltf", b'{"asset":' + b"[" * size


def keys_times_nodes(size):
    n = size // 3 // 16
    gltf = animated(range(n), [(0, 0, i) for i in range(n)])
    gltf.json["nodes"] += [{}] * (size // 3 // 4)
    return "keys.glb", gltf.glb()


def channels_of_a_sampler(size):
    n = size // 2 // 16
    gltf = animated(range(n), [(0, 0, i) for i in range(n)])
    gltf.json["animations"][0]["channels"] *= size // 2 // 60
    return "channels.glb", gltf.glb()


def views_times_buffers(size):
    gltf = tetrahedron()
    text = json.loads(gltf.gltf())
    text["bufferViews"] += [{"buffer": 1, "byteLength": 1}] * (size // 80)
    text["buffers"] += [{"byteLength": 0}] * (size // 40)
    return "buffers.gltf", json.dumps(text).encode()


def equal_names(size):
    gltf = tetrahedron()
    n = size // 50
    names = ["a"] * n + [f"a-{i}" for i in range(n)]
    position = gltf.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"]
    gltf.json["meshes"][0]["extras"] = {"targetNames": names}
    gltf.json["meshes"][0]["primitives"][0]["targets"] = [{"POSITION": position}] * (2 * n)
    return "equal-names.glb", gltf.glb()


def weights_at_one_place(size):
    n = size // 60
    gltf = skinned()
    attributes = gltf.json["meshes"][0]["primitives"][0]["attributes"]
    attributes["POSITION"] = gltf.floats("VEC3", [*TETRAHEDRON[:3], *[(0, 0, 1)] * n])
    attributes["JOINTS_0"] = gltf.accessor(gltf.view(bytes([0, 1, 0, 0] * (n + 3))), "VEC4", n + 3, 5121)
    attributes["WEIGHTS_0"] = gltf.floats("VEC4", [(i, n + 3 - i, 0, 0) for i in range(n + 3)])
    return "place.glb", gltf.glb()


def meshopt_zeros(size):
    """Vertices in whose blocks every byte group is of zeros: the densest that the codec allows."""
    n = size // 16 * 256
    stream = bytes([0xA0]) + bytes(size) + bytes(32)
    gltf = tetrahedron()
    view = gltf.view(stream)
    settings = {"buffer": 0, "byteOffset": gltf.json["bufferViews"][view]["byteOffset"], "byteLength": len(stream),
                "byteStride": 256, "count": n, "mode": "ATTRIBUTES"}
    gltf.json["bufferViews"].append(
        {"buffer": 0, "byteLength": 256 * n, "extensions": {"EXT_meshopt_compression": settings}})
    return "meshopt.glb", gltf.glb()


def pc2_points(size):
    n = size // 12
    return "points.pc2", pc2(n, 1, bytes(12 * n))


def mdd_times(size):
    n = size // 16
    return "times.mdd", mdd(n, 1, range(n), bytes(12 * n))


def fbx_nodes(size):
    text = "; FBX 7.4.0 project file\nFBXHeaderExtension: {\nFBXVersion: 7400\n}\nObjects: {\n"
    text += "".join(f'Model: {i}, "Model::", "Null" {{ }}\n' for i in range(1, size // 32)) + "}\n"
    return "nodes.fbx", text.encode()


def fbx_deflated(size):
    """A binary FBX with arrays of zeros, compressed a thousandfold."""
    data = zlib.compress(bytes(size * 1000 // 8 * 8), 9)
    array = b"d" + struct.pack("<III", size * 1000 // 8, 1, len(data)) + data

    def node(name, properties, children, at):
        head = 13 + len(name)
        inner = b""
        for child in children:
            inner += child(at + head + len(properties) + len(inner))
        inner += bytes(13) if children else b""
        end = at + head + len(properties) + len(inner)
        return struct.pack("<IIIB", end, 1 if properties else 0, len(properties), len(name)) + name + properties + inner

    number = b"L" + struct.pack("<q", 5)
    vertices = lambda at: node(b"Vertices", array, [], at)
    geometry = lambda at: node(b"Geometry", number, [vertices], at)
    return "deflated.fbx", b"Kaydara FBX Binary  \0\x1a\0" + struct.pack("<I", 7400) + node(
        b"Objects", b"", [geometry], 27) + bytes(13)


def markers_yaml(size):
    return "markers.yaml", b"markers:\n" + b"- {source: 1, target: 1}\n" * (size // 25)


def markers_anchors(size):
    levels = "".join(f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 9)}]\n" for i in range(1, 12))
    return "anchors.yaml", ("a0: &a0 [1]\n" + levels + "markers: *a11\n").encode()


def points_json(size):
    return "points.json", b"[" + b"[0.5,0.5,0.5]," * (size // 14) + b"[1.5,1.5,1.5]]"


def points_csv(size):
    return "points.csv", b"".join(b"p%d,0,0,0\n" % i for i in range(size // 13))


def points_pp(size):
    return "points.pp", b"<PickedPoints>" + b'<point x="0" y="0" z="0"/>' * (size // 26) + b"</PickedPoints>"


def points_entities(size):
    levels = "".join(f'<!ENTITY a{i} "{f"&a{i - 1};" * 9}">' for i in range(1, 12))
    text = f'<!DOCTYPE PickedPoints [<!ENTITY a0 "aaaaaaaaa">{levels}]><PickedPoints><point name="&a11;" x="0" y="0" z="0"/></PickedPoints>'
    return "entities.pp", text.encode()


BOMBS = [value for key, value in list(globals().items()) if callable(value) and value.__module__ == __name__
         and key not in ("grid", "circle")]
