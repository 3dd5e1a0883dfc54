#!/usr/bin/env python3
"""Writes the seeds of the corpus: small sound files of every reader, as `seed-*` in `fuzz/corpus/TARGET`."""

import json
import os
import struct

from files import *

CORPUS = os.path.join(os.path.dirname(__file__), "../corpus")


def put(target, name, contents):
    folder = os.path.join(CORPUS, target)
    os.makedirs(folder, exist_ok=True)
    with open(os.path.join(folder, f"seed-{name}"), "wb") as file:
        file.write(contents)


def texts():
    put("obj", "plain", obj())
    rich = "vt 0 0\nvt 1 0\nvt 0 1\nvn 0 0 1\no a\ng b c\nusemtl d\nf 1/1/1 2/2/1 3/3/1\nf -4 -3 \\\n -2 -1\ns off\nl 1 2\n"
    put("obj", "rich", obj(more=rich))
    put("obj", "coloured", b"v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0 0 0 1\nf 1 2 3\n")
    put("off", "plain", off())
    put("off", "all", b"STCNOFF\n3 1 3\n0 0 0 0 0 1 255 0 0 0 0\n1 0 0 0 0 1 0 255 0 1 0\n0 1 0 0 0 1 0 0 255 0 1\n3 0 1 2 0.5 0.5 0.5\n")
    put("ply", "text", ply_text())
    put("ply", "binary", ply_binary())
    vertex = "property double x\nproperty double y\nproperty double z\nproperty float nx\nproperty float ny\nproperty float nz\nproperty uchar red\nproperty uchar green\nproperty uchar blue"
    face = "property list uchar int vertex_indices\nproperty list uchar float texcoord\nproperty uchar red\nproperty uchar green\nproperty uchar blue"
    rows = [(*v, 0, 0, 1, 255, 128, 0) for v in TETRAHEDRON]
    lines = [" ".join(map(str, row)) for row in rows] + [f"3 {a} {b} {c} 6 0 0 1 0 0 1 9 8 7" for a, b, c in FACES]
    put("ply", "rich", ply_header("ascii", 4, 4, vertex, face) + "\n".join(lines).encode() + b"\n")
    strips = ply_header("ascii", 4, 1).replace(b"element face", b"element tristrips")
    put("ply", "strips", strips + b"0 0 0\n1 0 0\n0 1 0\n1 1 0\n6 0 1 2 3 -1 0\n")
    put("stl", "text", stl_text())
    put("stl", "binary", stl_binary())


def gltfs():
    for target, written in (("glb", Gltf.glb), ("gltf", Gltf.gltf)):
        put(target, "plain", written(tetrahedron()))
        put(target, "skinned", written(skinned()))
        put(target, "moving", written(animated()))
        put(target, "turning", written(animated((0, 1), ((0, 0, 0, 1), (0, 0, 1, 0)), "rotation", "VEC4")))
        gltf = tetrahedron()
        primitive = gltf.json["meshes"][0]["primitives"][0]
        primitive["targets"] = [{"POSITION": gltf.floats("VEC3", [(0, 0, i)] * 4)} for i in range(2)]
        at, moved = gltf.view(struct.pack("<2H", 1, 2)), gltf.view(floats([0, 1, 0, 0, 1, 0]))
        sparse = {"count": 2, "indices": {"bufferView": at, "componentType": 5123}, "values": {"bufferView": moved}}
        primitive["targets"].append({"POSITION": gltf.accessor(None, "VEC3", 4, sparse=sparse)})
        primitive["attributes"]["NORMAL"] = gltf.floats("VEC3", [(0, 0, 1)] * 4)
        primitive["attributes"]["TEXCOORD_0"] = gltf.floats("VEC2", [(0, 1)] * 4)
        primitive["attributes"]["COLOR_0"] = gltf.accessor(gltf.view(bytes(range(16))), "VEC4", 4, 5121, normalized=True)
        gltf.json["meshes"][0]["weights"] = [0.5, 0, 0]
        gltf.json["nodes"] = [{"mesh": 0, "children": [1], "scale": [2, 1, 1]}, {"name": "nose", "translation": [0, 1, 0]}]
        sampler = {"input": gltf.floats("SCALAR", [0, 1]), "output": gltf.floats("SCALAR", [0, 0, 0, 1, 1, 1])}
        channel = {"sampler": 0, "target": {"node": 0, "path": "weights"}}
        gltf.json["animations"] = [{"samplers": [sampler], "channels": [channel]}]
        put(target, "rich", written(gltf))


def fbx():
    vertices = ",".join(map(str, flat(TETRAHEDRON)))
    corners = ",".join(str(v) for a, b, c in FACES for v in (a, b, -c - 1))
    text = f"""; FBX 7.4.0 project file
FBXHeaderExtension: {{
    FBXVersion: 7400
}}
Objects: {{
    Geometry: 1, "Geometry::mesh", "Mesh" {{
        Vertices: *12 {{
            a: {vertices}
        }}
        PolygonVertexIndex: *12 {{
            a: {corners}
        }}
    }}
    Model: 2, "Model::mesh", "Mesh" {{
    }}
}}
Connections: {{
    C: "OO",1,2
    C: "OO",2,0
}}
"""
    put("fbx", "text", text.encode())


def caches():
    positions = floats(flat(TETRAHEDRON)) * 2
    put("pc2", "two", pc2(2, 4, positions))
    put("mdd", "two", mdd(2, 4, (0, 1), struct.pack(f">{len(positions) // 4}f", *struct.unpack(f"<{len(positions) // 4}f", positions))))


def points():
    put("json", "named", b'[{"name": "a", "position": [0, 0.5, 1]}, {"name": "b", "triangle": 1, "barycentric": [0.2, 0.3, 0.5]}]')
    put("json", "wrap", b"[[4, 0.3, 0.5], [2, 0.1, 0.2]]")
    put("json", "mapping", b'{"nose": [0.1, 0.2, 0.3], "ear": 7}')
    slicer = {"markups": [{"type": "Fiducial", "coordinateSystem": "LPS", "controlPoints": [{"label": "a", "position": [1, 2, 3]}]}]}
    put("json", "slicer", json.dumps(slicer).encode())
    put("csv", "named", b'name,x,y,z\n"a, b",0.5,1,2\nc,1e-3,-2,0\n')
    put("csv", "blanks", b"# note\na 1 2 3\nb 4 5 6\n")
    put("pts", "editor", b"Version 1.0\n2\nS000 1 2 3\nS001 9999 9999 9999\n")
    put("pts", "ibug", b"version: 1\nn_points: 1\n{\n1.5 2 3\n}\n")
    put("pp", "two", b'<!DOCTYPE PickedPoints>\n<PickedPoints>\n <point x="1" y="2" z="3" name="a" active="1"/>\n <point x="4" y="5" z="6" name="b &amp; c" active="0"/>\n</PickedPoints>\n')
    put("fcsv", "one", b"# Markups fiducial file version = 4.11\n# CoordinateSystem = LPS\n# columns = id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label,desc,associatedNodeID\n1,-22.4,45.3,-10.1,0,0,0,1,1,1,0,nose,,\n")
    put("landmarkAscii", "one", b'# AmiraMesh 3D ASCII 2.0\ndefine Markers 2\nParameters { NumSets 1, ContentType "LandmarkSet" }\nMarkers { float[3] Coordinates } @1\n@1\n1 2 3\n4 5 6\n')
    put("cons", "two", b"2\n0, 5\n1, 7\n")
    put("yaml", "three", b'source: { mesh: a.obj, vertices: 4 }\nmarkers:\n  - { name: left ear, source: 7, target: 3, note: tip }\n  - { source: 1, target: 2, status: proposed, confidence: 0.8 }\n  - { source: { triangle: 1, barycentric: [0.2, 0.3, 0.5] }, target: { vertex: 4, at: [0.1, 2, 3] } }\n')


def pipelines():
    put("pipeline", "plain", b"source: { rest: a.obj, poses: a-*.obj }\ntarget: { rest: b.obj }\noutput: out/{pose}.obj\n")
    put("pipeline", "include", b"include: part.yaml\nvariables: { a: 2, b: x }\nsource: { rest: '${b}.obj', poses: a.glb }\ntransfer: { type: gradient }\noutput: [out.glb, '{pose}.obj']\n# part.yaml\ntarget: { rest: b.obj }\nmetrics: []\n")
    put("pipeline", "matrix", b"source: { rest: a.obj, poses: a.glb }\ntargets: { one: { rest: b.obj }, two: { rest: c.obj } }\nmatrix: { transfer.type: [gradient, biharmonic] }\noutput: out/{target}/{pose}.obj\n")


def results():
    put("cache", "posed", struct.pack("<Q", 2) + struct.pack("<6d", *range(6)) + b'{"values":{},"warnings":[]}')
    put("cache", "seams", b"[[0,4],[1,7]]")
    put("cache", "summary", b'{"figures":{},"motion":true}')


for group in (texts, gltfs, fbx, caches, points, pipelines, results):
    group()
