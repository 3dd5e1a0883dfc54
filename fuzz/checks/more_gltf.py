"""More nonsense in glTF; adds to `cases.CASES`."""

import base64
import json
import struct

from cases import add, changed
from files import *

INF, NAN = float("inf"), float("nan")
LONG = "n" * 5000
IDENTITY = [float(i % 5 == 0) for i in range(16)]


def lists():
    """Wrong values of the entries of a file."""
    first = lambda key, **more: lambda j: j[key][0].update(more)
    primitive = lambda **more: lambda j: j["meshes"][0]["primitives"][0].update(more)
    attribute = lambda **more: lambda j: j["meshes"][0]["primitives"][0]["attributes"].update(more)
    changed("views", tetrahedron, first("bufferViews", byteStride=13), first("bufferViews", byteStride=14), first("bufferViews", byteStride=10**9),
            first("bufferViews", byteLength=-1), first("bufferViews", byteLength=1.5), first("bufferViews", buffer="x"), first("bufferViews", buffer=-1),
            lambda j: j["bufferViews"].append({"buffer": 0, "byteOffset": 9999, "byteLength": 9}), lambda j: j.pop("bufferViews"),
            lambda j: j.update(bufferViews={}), lambda j: j["bufferViews"].clear())
    changed("accessors", tetrahedron, first("accessors", bufferView=-1), first("accessors", bufferView=None), first("accessors", type="SCALAR"),
            first("accessors", type=5), first("accessors", componentType=5121), first("accessors", componentType=5125), first("accessors", byteOffset=2),
            first("accessors", byteOffset=-2), first("accessors", normalized=True, componentType=5122),
            first("accessors", count=1 << 62), first("accessors", count=1e300), lambda j: j.pop("accessors"),
            lambda j: j["accessors"][1].update(type="VEC3", count=4), lambda j: j["accessors"][1].update(count=0), lambda j: j["accessors"][1].update(count=2),
            lambda j: j["accessors"][1].update(bufferView=-1), lambda j: j["accessors"].append({"bufferView": 0, "componentType": 5126, "count": 99, "type": "VEC3"}))
    changed("primitives", tetrahedron, primitive(mode=9), primitive(mode=1), primitive(mode="x"), primitive(mode=-1), primitive(indices=-1),
            primitive(indices=9), primitive(indices="x"), primitive(material=9), primitive(material=-1), primitive(attributes={}), primitive(attributes=[]),
            primitive(targets=[{"POSITION": 9}]), primitive(targets=[{}]), primitive(targets=[{"POSITION": 1}]), primitive(targets=5), primitive(targets=[None]),
            attribute(POSITION=1), attribute(POSITION=9), attribute(POSITION=-1), attribute(POSITION="x"), attribute(NORMAL=1), attribute(NORMAL=9),
            attribute(TEXCOORD_0=0), attribute(COLOR_0=1), attribute(JOINTS_0=0), attribute(WEIGHTS_0=0), attribute(JOINTS_0=0, WEIGHTS_0=0), attribute(TANGENT=9),
            lambda j: j["meshes"][0].update(primitives=[]), lambda j: j["meshes"][0].update(weights=[1, 2]),
            lambda j: j["meshes"][0].update(weights="x"), lambda j: j.update(meshes=[]), lambda j: j.update(meshes=[None]), lambda j: j.update(meshes={"0": {}}),
            lambda j: (j.update(extensionsRequired=["EXT_what"]), j["meshes"][0]["primitives"][0].update(extensions={"EXT_what": {}})),
            lambda j: j["meshes"][0].update(name=LONG, primitives=[{"attributes": {}}]))
    node = lambda **more: lambda j: j["nodes"][0].update(more)
    changed("nodes", tetrahedron, node(matrix=[1.0] * 16), node(matrix=[NAN] * 16), node(matrix=[float(i % 5 == 0) for i in range(12)] + [0, 0, 0, 0]),
            node(matrix=[*IDENTITY[:3], 0.5, *IDENTITY[4:]]), node(matrix=IDENTITY, translation=[1, 0, 0]), node(matrix="x"), node(rotation=[0, 0, 0, 5]),
            node(rotation=[NAN, 0, 0, 1]), node(scale=[1, 0, 1]), node(scale=[INF, 1, 1]), node(translation=[NAN, 0, 0]), node(translation=[0, 0]),
            node(mesh=-1), node(mesh="x"), node(mesh=0.5), node(children=[1.5]), node(children="x"), node(children=[-1]), node(name=LONG, scale="x"),
            lambda j: j.update(nodes=[{"mesh": 0, "children": [1]}, {"children": [0]}]), lambda j: j.update(nodes=[{"children": [2]}, {"children": [2]}, {"mesh": 0}], scenes=[{"nodes": [0, 1]}]),
            lambda j: j.update(nodes=[{"children": [1, 1]}, {"mesh": 0}]), lambda j: j.update(nodes=[{"mesh": 0}, {"children": [1]}]),
            lambda j: j.update(nodes=[{"children": [1]}, {"mesh": 0}], scenes=[{"nodes": [0, 1]}]), lambda j: j.update(scenes=[{"nodes": [0, 0]}]),
            lambda j: j.update(scenes=[{"nodes": ["x"]}]), lambda j: j.update(scenes=[]), lambda j: j.update(scene="x"), lambda j: j.update(scenes=5),
            lambda j: j["nodes"][0].update(name="a\0b"), lambda j: j["nodes"][0].update(name="a\x1b[2Jb\nc"), lambda j: j["meshes"][0].update(name="a\0b"),
            lambda j: j["asset"].update(version=None), lambda j: j["asset"].update(minVersion=3), lambda j: j.update(asset=[]),
            lambda j: j.update(extensionsRequired="x"), lambda j: j.update(materials=[{"pbrMetallicRoughness": {"baseColorFactor": "red"}}]))


def sparse():
    def of(indices, count=None, kind=5123, moved=None, size="H", **more):
        gltf = tetrahedron()
        at = gltf.view(struct.pack(f"<{len(indices)}{size}", *indices))
        at_values = gltf.floats("VEC3", moved or [(5, 5, 5)] * len(indices))
        gltf.json["accessors"][0]["sparse"] = {"count": len(indices) if count is None else count, "indices": {"bufferView": at, "componentType": kind},
                                               "values": {"bufferView": gltf.json["accessors"][at_values]["bufferView"]}, **more}
        return gltf.glb()
    add("sparse-good.glb", of([1, 2]), nonsense=False)
    add("sparse-decreasing.glb", of([2, 1]))
    add("sparse-twice.glb", of([1, 1]))
    add("sparse-range.glb", of([1, 4]))
    add("sparse-long.glb", of([1, 2], count=9))
    add("sparse-floats.glb", of([1.0, 1.5], kind=5126, size="f"))
    add("sparse-signed.glb", of([-1, 1], kind=5122, size="h"))
    add("sparse-nan.glb", of([1, 2], moved=[(NAN, 0, 0)] * 2))
    add("sparse-none.glb", of([], count=0), nonsense=False)
    add("sparse-view.glb", of([1], values={"bufferView": 77}))


def containers():
    gltf = tetrahedron()
    whole = gltf.glb()
    text, binary = json.dumps(gltf.json).encode(), gltf.bytes
    text += b" " * (-len(text) % 4)
    chunk = lambda kind, data: struct.pack("<I4s", len(data), kind) + data
    file = lambda *chunks, length=None, version=2: b"glTF" + struct.pack("<II", version, 12 + sum(map(len, chunks)) if length is None else length) + b"".join(chunks)
    json_chunk, bin_chunk = chunk(b"JSON", text), chunk(b"BIN\0", binary)
    for name, contents in (("two-json", file(json_chunk, json_chunk, bin_chunk)), ("two-bin", file(json_chunk, bin_chunk, bin_chunk)), ("no-bin", file(json_chunk)),
                           ("no-json", file(bin_chunk)), ("other-between", file(json_chunk, chunk(b"WHAT", b"1234"), bin_chunk)), ("length-0", file(json_chunk, bin_chunk, length=0)),
                           ("length-short", file(json_chunk, bin_chunk, length=40)), ("version-3", file(json_chunk, bin_chunk, version=3)), ("trailing", whole + b"more" * 9),
                           ("chunk-long", file(struct.pack("<I4s", 0xFFFFFFFF, b"JSON") + text)), ("chunk-short", file(struct.pack("<I4s", len(text) - 8, b"JSON") + text, bin_chunk)),
                           ("bin-short", file(json_chunk, chunk(b"BIN\0", binary[:-8]))), ("bin-long", file(json_chunk, chunk(b"BIN\0", binary + bytes(64)))),
                           ("json-empty", file(chunk(b"JSON", b""), bin_chunk)), ("json-lower", file(chunk(b"json", text), bin_chunk)), ("odd", file(chunk(b"JSON", text + b" "), bin_chunk))):
        # Of one byte too many nothing depends.
        add(f"glb-{name}.glb", contents, nonsense=name != "odd")
    text = json.dumps(json.loads(tetrahedron().gltf()))
    for i, (old, new) in enumerate((('"mesh": 0', '"mesh": 0, "mesh": 0'), ('"count": 4', '"count": 4, "count": 4'), ('{"asset"', '{"asset": {"version": "2.0"}, "asset"'),
                                    ('"scene": 0', '"scene": 0,'), ('"scene": 0', "'scene': 0"), ('"scene": 0', '"scene": 0x0'), ('"scene": 0', '"scene": 00'),
                                    ('"scene": 0', '"scene": 1e999'), ('"scene": 0', '"sc\\u0000ene": 0, "scene": 0'), ('"scene": 0', '"scene": 0, /* a */ "x": 1'),
                                    ('"scene": 0', '"x": ' + "[" * 500 + "]" * 500 + ', "scene": 0'), ('"scene": 0', '"x": "\\ud800", "scene": 0'), ("}", "} }"))):
        assert old in text, old
        if new == "} }":
            text_at = text + " }"
        else:
            text_at = text.replace(old, new, 1)
        add(f"text-{i}.gltf", text_at.encode(), nonsense=i not in (8, 10))
    uri = lambda new: json.dumps(dict(json.loads(text), buffers=[dict(json.loads(text)["buffers"][0], uri=new)])).encode()
    length = len(tetrahedron().bytes)
    data = base64.b64encode(tetrahedron().bytes).decode()
    for i, new in enumerate(("", ".", "..", "/etc/passwd", "../../../../../../etc/passwd", "file:///etc/passwd", "C:\\a.bin", "a%00b.bin", "%2e%2e/gone.bin", "gone.bin?x=1",
                             "data:", "data:;base64", "data:;base64,", "data:;base64,AAAA", "data:text/plain," + data, f"data:;base64,{data[:-1]}", f"data:;base64,{data}====",
                             "data:;base64," + "A" * 5000, LONG + ".bin", f"https://example.org/{LONG}", 7, None, [])):
        add(f"uri-{i}.gltf", uri(new))
    beside = lambda name, contents, nonsense=True, also={}: add(f"beside-{name}.gltf", {"": uri("a.bin"), "a.bin": contents, **also}, nonsense)
    beside("good", tetrahedron().bytes, nonsense=False)
    beside("short", tetrahedron().bytes[:-8])
    beside("long", tetrahedron().bytes + bytes(64))
    beside("empty", b"")
    beside("folder", "folder")
    beside("pipe", "pipe")
    beside("device", "/dev/zero")
    beside("elsewhere", "/etc/passwd")


def skins():
    skin = lambda **more: lambda j: j["skins"][0].update(more)
    changed("skins", skinned, skin(joints=[-1, 1]), skin(joints=[1, 1]), skin(joints=["x"]), skin(joints=5), skin(inverseBindMatrices=-1), skin(inverseBindMatrices="x"),
            lambda j: j.pop("skins"), lambda j: j["nodes"][0].pop("skin"), lambda j: j["nodes"][1].update(scale=[0, 0, 0]), lambda j: j["nodes"][1].update(matrix=[0.0] * 16),
            lambda j: j["meshes"][0]["primitives"][0]["attributes"].pop("JOINTS_0"), lambda j: j["meshes"][0]["primitives"][0]["attributes"].pop("WEIGHTS_0"),
            lambda j: [j["meshes"][0]["primitives"][0]["attributes"].pop(key) for key in ("JOINTS_0", "WEIGHTS_0")],
            lambda j: j["meshes"][0]["primitives"][0]["attributes"].update(JOINTS_1=j["meshes"][0]["primitives"][0]["attributes"]["JOINTS_0"]),
            lambda j: j["meshes"][0]["primitives"][0]["attributes"].update(WEIGHTS_0=0))
    for name, joints in (("beyond", [0, 2, 0, 0]), ("far", [0, 255, 0, 0])):
        gltf = skinned()
        gltf.json["meshes"][0]["primitives"][0]["attributes"]["JOINTS_0"] = gltf.accessor(gltf.view(bytes(joints * 4)), "VEC4", 4, 5121)
        add(f"joints-{name}.glb", gltf.glb())
    for name, joints in (("float", (0, 1, 0, 0)), ("half", (0, 0.5, 0, 0)), ("negative", (0, -1, 0, 0)), ("nan", (0, NAN, 0, 0))):
        gltf = skinned()
        gltf.json["meshes"][0]["primitives"][0]["attributes"]["JOINTS_0"] = gltf.floats("VEC4", [joints] * 4)
        add(f"joints-{name}.glb", gltf.glb())
    gltf = skinned()
    gltf.json["skins"][0]["inverseBindMatrices"] = gltf.floats("MAT4", [[*IDENTITY[:3], 0.5, *IDENTITY[4:]]] * 2)
    add("bind-projective.glb", gltf.glb())


def clips():
    moves = ((0, 0, 0), (1, 0, 0))
    for name, times in (("equal", (0, 1, 1, 2)), ("negative", (-1, 0, 1, 2)), ("inf", (0, 1, 2, INF)), ("huge", (0, 1, 2, 1e38)), ("back", (0, 2, 1, 3)), ("first-nan", (NAN, 1, 2, 3))):
        add(f"times-{name}.glb", animated(times, [(i, 0, 0) for i in range(4)]).glb(), nonsense=name not in ("negative", "huge"))
    add("clip-long-output.glb", animated((0, 1), [(i, 0, 0) for i in range(4)]).glb(), nonsense=False)
    add("clip-nan-output.glb", animated((0, 1), ((0, 0, 0), (NAN, 0, 0))).glb())
    add("clip-zero-scale.glb", animated((0, 1), ((1, 1, 1), (0, 0, 0)), "scale").glb(), nonsense=False)
    add("clip-type.glb", animated((0, 1), ((0, 0, 0, 1), (0, 0, 0, 1)), "translation", "VEC4").glb())
    # Tools write weights of meshes without morph targets.
    add("clip-weights.glb", animated((0, 1), (0, 1), "weights", "SCALAR").glb(), nonsense=False)
    add("clip-one-key.glb", animated((0,), ((0, 0, 0),)).glb(), nonsense=False)
    channel = lambda **more: lambda j: j["animations"][0]["channels"][0].update(more)
    target = lambda **more: lambda j: j["animations"][0]["channels"][0]["target"].update(more)
    sampler = lambda **more: lambda j: j["animations"][0]["samplers"][0].update(more)
    changed("clips", animated, channel(sampler=9), channel(sampler=-1), channel(sampler="x"), channel(target={}), channel(target=None), target(node=9), target(node=-1), target(node=None),
            target(path="colour"), target(path=5), sampler(input=9), sampler(output=9), sampler(input=-1), sampler(input="x"), sampler(interpolation="WILD"), sampler(interpolation="CUBICSPLINE"),
            sampler(input=0), lambda j: j["animations"][0].update(channels=[]), lambda j: j["animations"][0].update(samplers=[]), lambda j: j.update(animations={}),
            lambda j: j["animations"][0]["channels"].append(j["animations"][0]["channels"][0]), lambda j: j["animations"][0].update(name="a\0b"),
            lambda j: (j["animations"][0].update(name=LONG), j["animations"][0]["channels"][0].update(sampler=9)))


for group in (lists, sparse, containers, skins, clips):
    group()
