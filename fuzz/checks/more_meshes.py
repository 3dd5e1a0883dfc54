"""More nonsense in PLY, OBJ, STL, OFF, FBX and point caches, and files that others name; adds to `cases.CASES`."""

import math
import os
import struct

from cases import add, cut, replaced
from files import *

XYZ = "property float x\nproperty float y\nproperty float z"


def plys():
    text, binary = ply_text(), ply_binary()
    fine = lambda name, contents: add(name, contents, nonsense=False)
    for ending, name in ((b"\r\n", "crlf"), (b"\r", "cr")):
        fine(f"{name}-text.ply", text.replace(b"\n", ending))
        head, body = binary.split(b"end_header\n")
        fine(f"{name}-binary.ply", (head + b"end_header\n").replace(b"\n", ending) + body)
    replaced("header", "ply", text, (b"ascii 1.0", b"ascii 2.0"), (b"ascii 1.0", b"ascii"), (b"ascii 1.0", b"ascii 1.0\nformat ascii 1.0"),
             (b"uchar int", b"float int"), (b"uchar int", b"uchar float"), (b"uchar int", b"double double"),
             (b"property list uchar int vertex_indices", b"property list uchar int vertex_indices\nproperty list uchar int vertex_index"),
             (b"property list uchar int vertex_indices", b"property int vertex_indices"), (b"property float x", b"property list uchar float x"),
             (b"property float x", b"property float"), (b"property float x", b"property float x y"), (b"property float x", b"prop float x"),
             (b"element face 4", b"element face 0x4"), (b"element face 4", b"element face 1e1"), (b"element face 4", b"element face 4 4"),
             (b"property float x", b"property float " + b"x" * 5000), (b"element vertex", b"element " + b"v" * 5000),
             (b"ply\n", b"ply\nproperty float a\n"), (b"end_header\n", b""), (b"end_header", b"END_HEADER"))
    replaced("entry", "ply", text, (b"1 0 0", b"1.0abc 0 0"), (b"1 0 0", b"1,5 0 0"), (b"1 0 0", b"inf 0 0"), (b"1 0 0", b"-1.#IND 0 0"),
             (b"1 0 0", b"1 0\x000"), (b"1 0 0", b"1 0 0 0"), (b"1 0 0", b"1 0"), (b"3 0 2 1", b"nan 0 2 1"), (b"3 0 2 1", b"3 0 2 4294967296"),
             (b"3 0 2 1", b"4 0 2 1"), (b"3 0 2 1", b"0"), (b"3 0 2 1", b"1 0"), (b"1 0 0", b"9" * 5000 + b"x 0 0"))
    add("tail.ply", text + b"hello\n")
    normals = "\nproperty float nx\nproperty float ny\nproperty float nz"
    rows = b"".join(b"%d %d %d nan 0 1\n" % v for v in TETRAHEDRON) + b"".join(b"3 %d %d %d\n" % f for f in FACES)
    add("normals-nan.ply", ply_header("ascii", 4, 4, XYZ + normals) + rows)
    wedge = "property list uchar int vertex_indices\nproperty list uchar float texcoord"
    positions = b"".join(b"%d %d %d\n" % v for v in TETRAHEDRON)
    add("wedges-short.ply", ply_header("ascii", 4, 1, face=wedge) + positions + b"3 0 1 2 4 0 0 1 1\n")
    add("wedges-nan.ply", ply_header("ascii", 4, 1, face=wedge) + positions + b"3 0 1 2 6 0 0 1 1 nan 0\n")
    strips = ply_header("ascii", 4, 1).replace(b"element face", b"element tristrips")
    for i, strip in enumerate((b"4 0 1 2 9", b"4 0 1 -2 3", b"4 0 1 2.5 3", b"2 0 1", b"5 0 1 2 3")):
        add(f"strip-{i}.ply", strips + positions + strip + b"\n")
    add("colours-text.ply", ply_header("ascii", 4, 4, XYZ + "\nproperty uchar red") + rows.replace(b"nan 0 1", b"red"))
    for size, letter in ((8, "d"), (2, "h"), (1, "b")):
        kind = {8: "double", 2: "short", 1: "char"}[size]
        body = b"".join(struct.pack("<3" + letter, *v) for v in TETRAHEDRON) + binary.split(b"end_header\n")[1][48:]
        fine(f"size-{size}.ply", ply_header("binary_little_endian", 4, 4, XYZ.replace("float", kind)) + body)
        add(f"size-{size}-cut.ply", (ply_header("binary_little_endian", 4, 4, XYZ.replace("float", kind)) + body)[:-3])


def objs():
    text = obj()
    fine = lambda name, contents: add(name, contents, nonsense=False)
    fine("crlf.obj", text.replace(b"\n", b"\r\n"))
    fine("cr.obj", text.replace(b"\n", b"\r"))
    fine("bom.obj", b"\xef\xbb\xbf" + text)
    fine("continued.obj", text.replace(b"f 1 3 2", b"f 1 \\\n3 2"))
    fine("continued-crlf.obj", text.replace(b"f 1 3 2", b"f 1 \\\r\n3 2"))
    fine("utf16.obj", text.decode().encode("utf-16"))
    face = b"f 1 3 2"
    rich = b"vt 0 0\nvn 0 0 1\n"
    replaced("more", "obj", text, (b"v 1 0 0", b"v 1.0abc 0 0"), (b"v 1 0 0", b"v 1,5 0 0"), (b"v 1 0 0", b"v 0x1 0 0"), (b"v 1 0 0", b"v"),
             (b"v 1 0 0", b"v 1 0 0 1 2"), (b"v 1 0 0", b"v 1 0 0 1 2 3 4 5"), (b"v 1 0 0", b"v 1 0 0 red green blue"),
             (b"v 1 0 0", b"v 1 0 0 nan 0 0"), (b"v 1 0 0", b"V 1 0 0"), (b"v 1 0 0", b"v 1 0\x00 0"), (b"v 1 0 0", b"v\x00 1 0 0"),
             (b"v 1 0 0", b"v 1 0 \\ \n0"), (face, b"f"), (face, b"f 1"), (face, b"F 1 3 2"), (face, b"face 1 3 2"), (face, b"f 1 3 2,"),
             (face, b"f 1, 3, 2"), (face, b"f 1 3 -5"), (face, b"f -1 -2 -9"), (face, rich + b"f 1/0 3/0 2/0"), (face, rich + b"f 1/0/0 3/0/0 2/0/0"),
             (face, rich + b"f 1//0 3//0 2//0"), (face, rich + b"f 1/1/1/1 3/1/1/1 2/1/1/1"), (face, rich + b"f 1/9 3/9 2/9"),
             (face, rich + b"f 1//9 3//9 2//9"), (face, rich + b"f 1/-2 3/-2 2/-2"), (face, b"f 1\\3\\2"), (face, b"vt 1,5 0\nf 1/1 3/1 2/1"),
             (face, b"vn inf 0 0\nf 1//1 3//1 2//1"), (face, b"vn 1e999 0 0\nf 1//1 3//1 2//1"),
             (face, b"mtllib gr\xf6\xdfe.mtl\nf 1 3 2"), (face, b"mtllib a\x00b.mtl\nf 1 3 2"), (face, b"mtllib /etc/passwd\nf 1 3 2"),
             (face, b"mtllib ../../../../etc/passwd\nf 1 3 2"), (face, b"mtllib " + b"m" * 5000 + b".mtl\nf 1 3 2"),
             (face, b"mtllib folder-of-meshes/\nf 1 3 2"), (face, b"f 1 3 2 " + b"x" * 5000), (face, b"what is this\nf 1 3 2"))
    fine("names-latin.obj", text.replace(face, b"o gr\xf6\xdfe\ng a\x00b\nusemtl \xff\n" + face))
    fine("padded.obj", text + bytes(100))
    add("nul-lines.obj", text + b"\x00f 1 2 3\n")
    add("points-only.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\np 1 2 3\n")
    add("lines-only.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nl 1 2 3\n")
    add("faces-only.obj", b"f 1 2 3\n")
    add("one-line.obj", text.replace(b"\n", b" "))
    library = b"newmtl a\nKd 1 0 0\n"
    with_library = lambda name, contents, nonsense=True: add(
        f"library-{name}.obj", {"": text.replace(face, b"mtllib a.mtl\nusemtl a\n" + face), "a.mtl": contents}, nonsense)
    with_library("good", library, nonsense=False)
    for name, contents in (("nan", b"newmtl a\nKd nan 0 0\n"), ("word", b"newmtl a\nKd red\n"), ("short", b"newmtl a\nKd 1\n"),
                           ("noise", bytes(range(256)) * 9), ("nameless", b"Kd 1 0 0\n")):
        with_library(name, contents)


def stls():
    text, binary = stl_text(), stl_binary()
    fine = lambda name, contents: add(name, contents, nonsense=False)
    fine("crlf.stl", text.replace(b"\n", b"\r\n"))
    fine("cr.stl", text.replace(b"\n", b"\r"))
    fine("capitals.stl", text.upper())
    fine("solid-binary.stl", b"solid" + binary[5:])
    facet = text[text.index(b" facet"):text.index(b"endfacet") + 9]
    loop = facet[facet.index(b"  outer"):facet.index(b"  endloop") + 10]
    add("two-solids.stl", text + text)
    add("two-solids-open.stl", text.replace(b"endsolid mesh\n", b"") + text)
    add("after-end.stl", text + facet)
    add("words-after-end.stl", text + b"hello\n")
    add("ends-in-solid.stl", text + b"solid\n")
    fine("names-differ.stl", text.replace(b"endsolid mesh", b"endsolid other"))
    replaced("more", "stl", text, (b"   vertex 0 0 0\n", b""), (b"   vertex 0 0 0\n", b"   vertex 0 0 0\n   vertex 0 0 5\n"),
             (b"vertex 0 0 0", b"vertex 0 0 0 0"), (b"vertex 0 0 0", b"vertex 0 0,5 0"), (b"vertex 0 0 0", b"vertex 1.0abc 0 0"),
             (b"vertex 0 0 0", b"vertx 0 0 0"), (b"vertex 0 0 0", b"vertex inf 0 0"), (b"vertex 0 0 0", b"vertex " + b"9" * 5000 + b"x 0 0"),
             (b" facet normal 0 0 1\n", b""), (loop, loop + loop), (loop, b""),
             (facet, loop), (b"solid mesh\n", b""))
    for more in (1, 20, 49, 51):
        add(f"longer-{more}.stl", binary + bytes(more))
        add(f"shorter-{more}.stl", binary[:-more])
    add("solid-more.stl", b"solid" + binary[5:] + b"x" * 7)
    add("count-zero.stl", binary[:80] + bytes(4) + binary[84:])
    add("huge.stl", binary[:84 + 12] + struct.pack("<f", 3e38) + binary[84 + 16:], nonsense=False)


def offs():
    text = off()
    fine = lambda name, contents: add(name, contents, nonsense=False)
    fine("crlf.off", text.replace(b"\n", b"\r\n"))
    fine("cr.off", text.replace(b"\n", b"\r"))
    fine("remarks.off", text.replace(b"4 4 0", b"# a\n4 4 0 # b"))
    replaced("more", "off", text, (b"1 0 0", b"1.0abc 0 0"), (b"1 0 0", b"1,5 0 0"), (b"1 0 0", b"inf 0 0"), (b"1 0 0", b"1 0"),
             (b"1 0 0", b"1 0 0 7"), (b"1 0 0", b"1 0 0 red green blue"), (b"1 0 0", b"1 0 0 nan 0 0"), (b"3 0 2 1", b"3 0 2 -1"),
             (b"3 0 2 1", b"3 0 2 1.5"), (b"3 0 2 1", b"2 0 2"), (b"3 0 2 1", b"4 0 2 1"), (b"3 0 2 1", b"3 0 2 1 red green blue"),
             (b"3 0 2 1", b"3 0 2 1 0.5 0.5"), (b"3 0 2 1", b"3 0 2 1 nan 0 0"), (b"3 0 2 1", b"3 0 2 1 1 2 3 4 5 6"),
             (b"3 0 2 1", b"3 0 2 99999999999"), (b"OFF", b"off"), (b"OFF", b"NOFF"), (b"OFF", b"STOFF"), (b"OFF", b"XOFF"),
             (b"OFF\n4 4 0", b"OFF\n4 4 0 9"), (b"OFF\n4 4 0", b"OFF\n4"), (b"1 0 0", b"9" * 5000 + b"x 0 0"), (b"1 0 0", b"1 0 \x000"))
    add("tail.off", text + b"hello\n")


def fbxs():
    text = open_seed("fbx/seed-text")
    cut("text", "fbx", text)
    replaced("text", "fbx", text, (b"0,0,0,", b"nan,0,0,"), (b"0,0,0,", b"1e999,0,0,"), (b"0,0,0,", b"0,0,"), (b"0,0,0,", b"x,0,0,"),
             (b"0,2,-2", b"0,9,-2"), (b"0,2,-2", b"0,2,2"), (b"0,2,-2", b"0,-2"), (b"PolygonVertexIndex", b"PolygonIndex"),
             (b"Vertices", b"Verts"), (b"FBXVersion: 7400", b"FBXVersion: 100"), (b'C: "OO",1,2', b'C: "OO",2,1'), (b'C: "OO",1,2', b'C: "OO",1,9'),
             (b"*12", b"*99999999999"), (b'"Geometry::mesh"', b'"' + b"g" * 5000 + b'"'), (b"; FBX", b"; FBY"))


def open_seed(name):
    with open(os.path.join(os.path.dirname(__file__), "../corpus", name), "rb") as file:
        return file.read()


def caches():
    positions = floats(flat(TETRAHEDRON))
    swapped = struct.pack(">12f", *flat(TETRAHEDRON))
    nan, inf = struct.pack("<f", math.nan), struct.pack("<f", math.inf)
    # Any sample of several may be wrong.
    for sample in range(4):
        parts = [positions] * 4
        parts[sample] = positions[:20] + nan + positions[24:]
        add(f"nan-in-{sample}.pc2", pc2(4, 4, b"".join(parts)))
        parts[sample] = inf + positions[4:]
        add(f"inf-in-{sample}.pc2", pc2(4, 4, b"".join(parts)))
        parts = [swapped] * 4
        parts[sample] = swapped[:20] + struct.pack(">f", math.nan) + swapped[24:]
        add(f"nan-in-{sample}.mdd", mdd(4, 4, range(4), b"".join(parts)))
    for name, start, rate in (("start-nan", math.nan, 1), ("start-inf", math.inf, 1), ("rate-negative", 0, -1.0), ("rate-inf", 0, math.inf)):
        add(f"{name}.pc2", pc2(1, 4, positions, start=start, rate=rate))
    add("good.pc2", pc2(1, 4, positions), nonsense=False)
    add("good.mdd", mdd(1, 4, [0], swapped), nonsense=False)
    add("huge.pc2", pc2(2, 4, positions + struct.pack("<f", 3e38) * 12), nonsense=False)
    for name, times in (("equal", (1, 1)), ("second-nan", (0, math.nan)), ("inf", (0, math.inf)), ("back", (0, 1, 0.5))):
        add(f"times-{name}.mdd", mdd(len(times), 4, times, swapped * len(times)))
    add("time-nan.mdd", mdd(1, 4, [math.nan], swapped))
    for more in (1, 11, 13):
        add(f"longer-{more}.pc2", pc2(1, 4, positions) + bytes(more))
        add(f"shorter-{more}.pc2", pc2(1, 4, positions)[:-more])
        add(f"longer-{more}.mdd", mdd(1, 4, [0], swapped) + bytes(more))
        add(f"shorter-{more}.mdd", mdd(1, 4, [0], swapped)[:-more])
    add("zero-points.pc2", pc2(3, 0, b""))
    add("zero-points.mdd", mdd(3, 0, (0, 1, 2), b""))
    add("zero-frames.mdd", mdd(0, 4, (), b""))


def markers():
    add("duplicate-names.csv", b"name,x,y,z\na,0,0,0\na,1,0,0\n")
    add("comma.csv", b"name,x,y,z\na,0,5,0,0\n")
    add("german.csv", b"name;x;y;z\na;0,5;0;0\n", nonsense=False)
    for i, row in enumerate((b"a,inf,0,0", b"a,1e999,0,0", b"a,1.0abc,0,0", b"a,0,0", b"a,0,0,0,0", b"a,x,y,z", b"a,,,", b"a,0\x00,0,0",
                             b'"a,0,0,0', b"a," + b"9" * 5000 + b"x,0,0")):
        add(f"row-{i}.csv", b"name,x,y,z\n" + row + b"\n")
    for i, text in enumerate((b'[{"name": "a", "position": [0, 0]}]', b'[{"name": "a", "position": [0, 0, 0, 0]}]', b'[{"name": "a", "position": [0, 0, NaN]}]',
                              b'[{"name": "a", "position": [0, 0, 1e999]}]', b'[{"name": "a", "position": "0 0 0"}]', b'[{"name": "a"}]',
                              b'[{"name": "a", "vertex": -1}]', b'[{"name": "a", "vertex": 99}]', b'[{"name": "a", "vertex": 1.5}]',
                              b'[{"name": "a", "triangle": 9, "barycentric": [1, 0, 0]}]', b'[{"name": "a", "triangle": 0, "barycentric": [1, 1, 1]}]',
                              b'[{"name": "a", "triangle": 0, "barycentric": [-1, 1, 1]}]', b'[{"name": "a", "name": "b", "position": [0, 0, 0]}]',
                              b'{"a": [0, 0, 0], "a": [1, 0, 0]}', b'{"a": {"b": {"c": 1}}}', b"[" * 9999, b'{"' + b"n" * 5000 + b'": "x"}', b'"a"', b"null", b"7")):
        add(f"value-{i}.json", text)
    for i, text in enumerate((b"0\n", b"-1\n", b"1\n0, 0, 0\n", b"1\n0.5, 0\n", b"1\n0\n", b"1\na, b\n", b"2\n0, 0\n0, 1\n", b"2\n0, 0\n1, 0\n",
                              b"1\n99999999999999999999, 0\n", b"1\n0, 0\nhello\n", b"1\n0, 0\x00\n")):
        add(f"line-{i}.cons", text, nonsense=i != 0)
    point = b'<point x="0" y="0" z="0" name="a"/>'
    for i, text in enumerate((b"<PickedPoints></PickedPoints>", b"<PickedPoints>" + point * 2 + b"</PickedPoints>", b"<Other>" + point + b"</Other>",
                              b"<PickedPoints>" + point.replace(b'x="0"', b'x="inf"') + b"</PickedPoints>",
                              b"<PickedPoints>" + point.replace(b'x="0" ', b"") + b"</PickedPoints>",
                              b"<PickedPoints>" + point.replace(b'x="0"', b'x="0" x="1"') + b"</PickedPoints>",
                              b"<PickedPoints>" + point + b"</PickedPoints>" + point, b"<PickedPoints><" + b"p" * 5000 + b"></PickedPoints>")):
        add(f"xml-{i}.pp", text)
    head = b"# Markups fiducial file version = 4.11\n# CoordinateSystem = LPS\n# columns = id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label,desc,associatedNodeID\n"
    row = b"1,0,0,0,0,0,0,1,1,1,0,a,,\n"
    for i, text in enumerate((head.replace(b"LPS", b"XYZ") + row, head.replace(b"id,x,y,z", b"id,a,b,c") + row, head + row.replace(b"1,0,0,0", b"1,0,0"),
                              head + row.replace(b"1,0,0", b"1,inf,0"), head + row + row, head)):
        add(f"table-{i}.fcsv", text)
    for i, text in enumerate((b"2\na 0 0 0\n", b"1\na 0 0\n", b"1\na 0 0 0 0\n", b"1\na inf 0 0\n", b"version: 1\nn_points: 2\n{\n0 0 0\n}\n",
                              b"version: 1\nn_points: 1\n{\n0 0 0\n")):
        # All points are there without the last brace.
        add(f"points-{i}.pts", text, nonsense=i != 5)


for group in (plys, objs, stls, offs, fbxs, caches, markers):
    group()
