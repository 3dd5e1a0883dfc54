"""Damaged and nonsensical files: name, contents, and whether a result without a word is wrong.

Contents that are a string are the target of a link, `pipe` or `folder`.
"""

import json
import math
import struct

from files import *

POSES = (".pc2", ".mdd")
CASES = []


def add(name, contents, nonsense=True):
    CASES.append((name, contents, nonsense))


def cut(stem, ending, contents):
    """Files cut at sixteenths; some of a text are whole all the same."""
    for part in range(16):
        add(f"{stem}-cut-{part}.{ending}", contents[:len(contents) * part // 16], nonsense=False)


def replaced(stem, ending, contents, *pairs):
    for i, (old, new) in enumerate(pairs):
        assert old in contents, (stem, old)
        add(f"{stem}-{i}.{ending}", contents.replace(old, new, 1))


def changed(stem, make, *changes):
    """glTFs of `make`, each with a change of its JSON."""
    for i, change in enumerate(changes):
        gltf = make()
        change(gltf.json)
        add(f"{stem}-{i}.glb", gltf.glb())


def no_meshes():
    for ending in ("obj", "ply", "stl", "off", "glb", "gltf", "fbx", *(pose[1:] for pose in POSES)):
        add(f"empty.{ending}", b"")
        add(f"zeros.{ending}", bytes(200))
        add(f"text.{ending}", b"this is a letter, not a mesh\n" * 9)
        add(f"latin.{ending}", "Größe und Höhe\n".encode("latin-1") * 9)
        add(f"noise.{ending}", bytes((i * i * 7 + i // 3) % 256 for i in range(999)))
        add(f"pipe.{ending}", "pipe")
        add(f"folder.{ending}", "folder")
        add(f"device.{ending}", "/dev/zero")
        add(f"random.{ending}", "/dev/urandom")
        add(f"nowhere.{ending}", "/nowhere")


def objs():
    text = obj()
    cut("mesh", "obj", text)
    replaced("mesh", "obj", text, (b"v 1 0 0", b"v 1 0"), (b"v 1 0 0", b"v nan 0 0"), (b"v 1 0 0", b"v 1e308 0 0"),
             (b"v 1 0 0", b"v 1e999 0 0"), (b"v 1 0 0", b"v 1,5 0 0"), (b"v 1 0 0", b"v inf 0 0"), (b"f 1 3 2", b"f 0 3 2"),
             (b"f 1 3 2", b"f 1 3 9"), (b"f 1 3 2", b"f 1 3 -9"), (b"f 1 3 2", b"f 1.0 3 2"), (b"f 1 3 2", b"f 1/1 3/1 2/1"),
             (b"f 1 3 2", b"f 1//1 3//1 2//1"), (b"f 1 3 2", b"f 1 3"), (b"f 1 3 2", b"f a b c"),
             (b"f 1 3 2", b"f 99999999999999999999 1 2"), (b"f 1 3 2", b"vt nan 0\nf 1/1 3/1 2/1"),
             (b"f 1 3 2", b"vt\nf 1/1 3/1 2/1"), (b"f 1 3 2", b"vn 0 0\nf 1//1 3//1 2//1"), (b"f 1 3 2", b"mtllib gone.mtl\nf 1 3 2"),
             (b"f 1 3 2", b"mtllib /dev/zero\nf 1 3 2"), (b"f 1 3 2", b"f " + b"9" * 3000 + b" 1 2"))


def plys():
    text, binary = ply_text(), ply_binary()
    cut("text", "ply", text)
    cut("binary", "ply", binary)
    replaced("text", "ply", text, (b"element vertex 4", b"element vertex 3"), (b"element vertex 4", b"element vertex 5"),
             (b"element face 4", b"element face 3"), (b"element face 4", b"element face 5"), (b"element vertex 4", b"element vertex -4"),
             (b"element vertex 4", b"element vertex 4.5"), (b"element vertex 4", b"element vertex 99999999999"),
             (b"property float x", b"property float a"), (b"property float x", b"property banana x"),
             (b"property float x", b"property float y"), (b"end_header", b"end_header\nend_header"), (b"format ascii", b"format morse"),
             (b"format ascii 1.0\n", b""), (b"1 0 0", b"nan 0 0"), (b"1 0 0", b"1e300 0 0"), (b"1 0 0", b"one 0 0"),
             (b"3 0 2 1", b"3 0 2 9"), (b"3 0 2 1", b"3 0 2 -1"), (b"3 0 2 1", b"3 0 2 1.5"), (b"3 0 2 1", b"-3 0 2 1"),
             (b"3 0 2 1", b"2147483648 0 2 1"), (b"element face", b"element vertex"), (b"vertex_indices", b"corner_indices"),
             (b"element vertex 4", b"element vertex"), (b"ply\n", b"plyy\n"), (b"3 0 2 1", b"2 0 2"), (b"3 0 2 1", b"3 0 2 1 7"))
    replaced("binary", "ply", binary, (b"element vertex 4", b"element vertex 3"), (b"element vertex 4", b"element vertex 5"),
             (b"element face 4", b"element face 3"), (b"element face 4", b"element face 5"), (b"end_header\n", b"end_header\nend_header\n"),
             (b"little", b"big"), (b"element vertex 4", b"element vertex 4000000000"), (b"uchar int", b"uint int"),
             (b"uchar int", b"float int"))
    add("trailing.ply", binary + b"more" * 5)
    add("trailing-text.ply", text + b"3 0 1 2\n")


def stls():
    text, binary = stl_text(), stl_binary()
    cut("text", "stl", text)
    cut("binary", "stl", binary)
    for facets in range(1, 4):
        add(f"cut-at-facet-{facets}.stl", binary[:84 + 50 * facets])
        add(f"text-cut-at-facet-{facets}.stl", b"".join(text.split(b" facet normal")[0:1]) + b"".join(
            b" facet normal" + part for part in text.split(b" facet normal")[1:facets + 1]))
    replaced("text", "stl", text, (b"vertex 0 0 0", b"vertex nan 0 0"), (b"vertex 0 0 0", b"vertex 1e39 0 0"),
             (b"vertex 0 0 0", b"vertex 0 0"), (b"vertex 0 0 0\n", b"\n"), (b"endfacet", b""), (b"endloop", b""), (b"outer loop", b""),
             (b"endsolid mesh\n", b""), (b"vertex 0 0 0", b"vertex 0 0 zero"))
    nan = struct.pack("<f", math.nan)
    add("nan.stl", binary[:84 + 50 + 16] + nan + binary[84 + 50 + 20:])
    add("inf.stl", binary[:84 + 50 + 16] + struct.pack("<f", math.inf) + binary[84 + 50 + 20:])
    add("more.stl", binary + bytes(50))
    add("count-too-low.stl", binary[:80] + struct.pack("<I", 3) + binary[84:])
    add("count-too-high.stl", binary[:80] + struct.pack("<I", 5) + binary[84:])
    add("count-enormous.stl", binary[:80] + struct.pack("<I", 0xFFFFFFFF) + binary[84:])
    add("solid-binary-cut.stl", b"solid" + binary[5:-20])
    add("solid-without-facets.stl", b"solid " + b"x" * 200)
    add("no-facets.stl", b"solid a\nendsolid a\n")


def offs():
    text = off()
    cut("mesh", "off", text)
    replaced("mesh", "off", text, (b"4 4 0", b"3 4 0"), (b"4 4 0", b"5 4 0"), (b"4 4 0", b"4 3 0"), (b"4 4 0", b"4 5 0"),
             (b"4 4 0", b"-4 4 0"), (b"4 4 0", b"99999999999 4 0"), (b"1 0 0", b"nan 0 0"), (b"1 0 0", b"1e308 0 0"), (b"1 0 0", b"x 0 0"),
             (b"3 0 2 1", b"3 0 2 9"), (b"3 0 2 1", b"3 0 2"), (b"3 0 2 1", b"3000000000 0 2"), (b"OFF", b"4OFF"), (b"OFF", b"OFF BINARY"))


def gltfs():
    whole = tetrahedron().glb()
    cut("mesh", "glb", whole)
    cut("mesh", "gltf", tetrahedron().gltf())
    text = json.dumps(json.loads(tetrahedron().gltf()))
    add("length.glb", glb(json.dumps(dict(tetrahedron().json, buffers=[{"byteLength": 96}])).encode(), tetrahedron().bytes, length=9999))
    chunk = struct.unpack_from("<I", whole, 12)[0]
    head, first, second = whole[:12], whole[12:20 + chunk], whole[20 + chunk:]
    add("order.glb", head + second + first)
    add("version.glb", b"glTF\x01" + whole[5:])
    add("two-keys.gltf", text.replace('"scene": 0', '"scene": 5, "scene": 0').encode())
    for i, (old, new) in enumerate([('"version": "2.0"', '"version": "3.0"'), ('"version": "2.0"', '"version": "2.0", "minVersion": "2.5"'),
                                    ('"version": "2.0"', '"other": "2.0"'), ('"count": 4', '"count": -4'), ('"count": 4', '"count": 4.5'),
                                    ('"count": 4', '"count": 400000000000'), ('"count": 4', '"count": "four"'), ('"count": 4', '"count": 5'),
                                    ('base64,', 'base64,*'), ('"byteLength": 96', '"byteLength": 960'), ('"scene": 0', '"scene": 7'),
                                    ('"mesh": 0', '"mesh": 7'), ('"nodes": [0]', '"nodes": [7]'), ('"nodes": [0]', '"nodes": []'),
                                    ('"asset"', '"nothing"'), ('{"mesh": 0}', '{"mesh": 0, "children": [0]}'), ('VEC3', 'VEC2'),
                                    ('VEC3', 'VEC9'), ('5126', '5130'), ('"uri": ', '"uri": "gone.bin", "old": '),
                                    ('data:application/octet-stream;base64,', 'https://example.org/')]):
        assert old in text, old
        add(f"json-{i}.gltf", text.replace(old, new, 1).encode())
    add("points.gltf", b'{"nose": [0.1, 0.2, 0.3]}')
    add("list.gltf", b"[1, 2, 3]")
    view = lambda **more: lambda j: j["bufferViews"][0].update(more)
    accessor = lambda at=0, **more: lambda j: j["accessors"][at].update(more)
    node = lambda **more: lambda j: j["nodes"][0].update(more)
    changed("view", tetrahedron, view(byteStride=0), view(byteStride=2), view(byteOffset=90), view(byteLength=10), view(byteLength=10**9),
            view(buffer=4), view(byteOffset=-4), view(byteLength=0))
    changed("accessor", tetrahedron, accessor(count=5), accessor(byteOffset=4), accessor(componentType=5123), accessor(1, count=11),
            accessor(1, count=13), accessor(1, componentType=5126), accessor(bufferView=9),
            accessor(1, byteOffset=1 << 60), accessor(count=0), accessor(sparse={"count": 1 << 40, "indices": {}, "values": {}}))
    changed("node", tetrahedron, node(rotation=[0, 0, 0, 0]), node(rotation=[0, 0, 1]), node(scale=[1e300, 1, 1]), node(scale=[0, 0, 0]),
            node(translation=[1e59, 0, 0]), node(matrix=[0] * 16), node(matrix=[1] * 15), node(skin=3), node(children=[0]),
            node(children=[9]), node(scale="big"), node(weights=[1, 2, 3]))
    inf, nan = float("inf"), float("nan")
    for i, x in enumerate([inf, nan, 3.4e38]):
        # Far away, but no further than can be computed.
        add(f"position-{i}.glb", tetrahedron([(x, 0, 0), *TETRAHEDRON[1:]]).glb(), nonsense=not 0 < x < inf)
    add("index.glb", tetrahedron(faces=[(0, 1, 9)]).glb())
    add("indices-as-floats.glb", floats_as_indices([0, 1, 2, 0, 2, 3]).glb())
    add("indices-between.glb", floats_as_indices([0, 1.5, 2, 0, 2, 3]).glb())
    add("clip-decreases.glb", animated((1, 0)).glb())
    add("clip-nan.glb", animated((0, nan)).glb())
    add("clip-inf.glb", animated((0, 1), ((0, 0, 0), (inf, 0, 0))).glb())
    add("clip-without-length.glb", animated((1, 1)).glb())
    add("clip-short.glb", animated((0, 1, 2)).glb())
    add("clip-empty.glb", animated((), ()).glb())
    add("clip-rotation.glb", animated((0, 1), ((0, 0, 0, 0), (0, 0, 0, 0)), "rotation", "VEC4").glb(), nonsense=False)
    add("clip-path.glb", animated(path="colour").glb())
    skin = lambda **more: lambda j: j["skins"][0].update(more)
    changed("skin", skinned, skin(joints=[1]), skin(joints=[1, 9]), skin(joints=[]), skin(inverseBindMatrices=0),
            skin(inverseBindMatrices=99), lambda j: j["nodes"][0].update(skin=5), lambda j: j["skins"].clear())
    for i, weights in enumerate([(2, 2, 0, 0), (-0.5, 1.5, 0, 0), (0, 0, 0, 0), (nan, 1, 0, 0), (0.1, 0.1, 0, 0)]):
        gltf = skinned()
        attributes = gltf.json["meshes"][0]["primitives"][0]["attributes"]
        attributes["WEIGHTS_0"] = gltf.floats("VEC4", [weights] * 4)
        add(f"weights-{i}.glb", gltf.glb())
    gltf = skinned()
    gltf.json["skins"][0]["inverseBindMatrices"] = gltf.floats("MAT4", [[0.0] * 15 + [1.0]] * 2)
    add("bind-singular.glb", gltf.glb())
    gltf = skinned()
    gltf.json["skins"][0]["inverseBindMatrices"] = gltf.floats("MAT4", [[nan] * 16] * 2)
    add("bind-nan.glb", gltf.glb())


def floats_as_indices(corners):
    gltf = tetrahedron()
    gltf.json["meshes"][0]["primitives"][0]["indices"] = gltf.floats("SCALAR", corners)
    return gltf


def caches():
    positions = floats(flat(TETRAHEDRON)) * 2
    good = pc2(2, 4, positions)
    cut("cache", "pc2", good)
    add("magic.pc2", b"POINTCACHE3\0" + good[12:])
    add("version.pc2", pc2(2, 4, positions, version=2))
    add("points.pc2", pc2(2, 3, positions[:72]))
    add("negative.pc2", pc2(-2, 4, positions))
    add("overflow.pc2", pc2(0x7FFFFFFF, 0x7FFFFFFF, positions))
    add("rate.pc2", pc2(2, 4, positions, rate=0.0))
    add("rate-nan.pc2", pc2(2, 4, positions, rate=math.nan))
    add("none.pc2", pc2(0, 4, b""))
    add("nan.pc2", pc2(2, 4, floats([math.nan]) + positions[4:]))
    add("trailing.pc2", good + bytes(48))
    swapped = struct.pack(f">{len(positions) // 4}f", *struct.unpack(f"<{len(positions) // 4}f", positions))
    good = mdd(2, 4, (0, 1), swapped)
    cut("cache", "mdd", good)
    add("points.mdd", mdd(2, 3, (0, 1), swapped[:72]))
    add("negative.mdd", mdd(-2, 4, (0, 1), swapped))
    add("overflow.mdd", mdd(0x7FFFFFFF, 0x7FFFFFFF, (0, 1), swapped))
    add("times.mdd", mdd(2, 4, (1, 0), swapped))
    add("times-nan.mdd", mdd(2, 4, (0, math.nan), swapped))
    add("nan.mdd", mdd(2, 4, (0, 1), struct.pack(">f", math.nan) + swapped[4:]))
    add("trailing.mdd", good + bytes(48))


def markers():
    files = {"points.json": b'[{"name": "a", "position": [0, 0, 0.5]}]', "points.csv": b"name,x,y,z\na,0,0,0\n", "points.pts": b"1\na 0 0 0\n",
             "points.pp": b'<PickedPoints><point x="0" y="0" z="0" name="a"/></PickedPoints>', "points.fcsv": b"1,0,0,0,0,0,0,1,1,1,0,a,,\n",
             "pairs.cons": b"1\n0, 0\n", "pairs.yaml": b"markers:\n  - { source: 0, target: 0 }\n"}
    for name, text in files.items():
        stem, ending = name.split(".")
        add(f"good-{name}", text, nonsense=False)
        for part in range(1, 8):
            add(f"{stem}-cut-{part}.{ending}", text[:len(text) * part // 8], nonsense=False)
        add(f"latin-{name}", text + "Größe".encode("latin-1"))
        add(f"empty-{name}", b"")
        add(f"pipe-{name}", "pipe")
        add(f"device-{name}", "/dev/zero")
        if name.startswith("points"):
            add(f"nan-{name}", text.replace(b"0", b"nan", 3))
    add("range.cons", b"1\n0, 99\n")
    add("count.cons", b"2\n0, 0\n")
    add("negative.cons", b"1\n0, -1\n")


for group in (no_meshes, objs, plys, stls, offs, gltfs, caches, markers):
    group()
