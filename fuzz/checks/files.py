"""Bytes of small mesh files, to be damaged or repeated."""

import base64
import json
import struct

TETRAHEDRON = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
FACES = [(0, 2, 1), (0, 3, 2), (0, 1, 3), (1, 2, 3)]


def floats(values):
    """Numbers as 32-bit floats, the lowest byte first."""
    values = list(values)
    return struct.pack(f"<{len(values)}f", *values)


def flat(rows):
    """The numbers of rows one after another."""
    return [x for row in rows for x in row]


def obj(vertices=TETRAHEDRON, faces=FACES, more=""):
    """An OBJ; corners count from 0 here."""
    lines = [f"v {x} {y} {z}" for x, y, z in vertices]
    lines += ["f " + " ".join(str(v + 1) for v in face) for face in faces]
    return ("\n".join(lines) + "\n" + more).encode()


def off(vertices=TETRAHEDRON, faces=FACES):
    """An OFF as text."""
    lines = [f"OFF\n{len(vertices)} {len(faces)} 0"]
    lines += [" ".join(map(str, v)) for v in vertices]
    lines += [" ".join(map(str, (len(f), *f))) for f in faces]
    return ("\n".join(lines) + "\n").encode()


def ply_header(kind, vertices, faces, vertex="property float x\nproperty float y\nproperty float z",
               face="property list uchar int vertex_indices"):
    """The header of a PLY."""
    return (f"ply\nformat {kind} 1.0\nelement vertex {vertices}\n{vertex}\n"
            f"element face {faces}\n{face}\nend_header\n").encode()


def ply_text(vertices=TETRAHEDRON, faces=FACES, **header):
    """A PLY as text."""
    lines = [" ".join(map(str, v)) for v in vertices]
    lines += [" ".join(map(str, (len(f), *f))) for f in faces]
    return ply_header("ascii", len(vertices), len(faces), **header) + ("\n".join(lines) + "\n").encode()


def ply_binary(vertices=TETRAHEDRON, faces=FACES):
    """A little-endian PLY."""
    body = floats(flat(vertices))
    body += b"".join(struct.pack(f"<B{len(f)}i", len(f), *f) for f in faces)
    return ply_header("binary_little_endian", len(vertices), len(faces)) + body


def stl_text(vertices=TETRAHEDRON, faces=FACES):
    """An STL as text."""
    lines = ["solid mesh"]
    for face in faces:
        lines += [" facet normal 0 0 1", "  outer loop"]
        lines += ["   vertex " + " ".join(map(str, vertices[v])) for v in face]
        lines += ["  endloop", " endfacet"]
    return ("\n".join([*lines, "endsolid mesh"]) + "\n").encode()


def stl_binary(vertices=TETRAHEDRON, faces=FACES):
    """A binary STL."""
    body = b"".join(floats([0, 0, 1, *flat(vertices[v] for v in face)]) + b"\0\0" for face in faces)
    return b" " * 80 + struct.pack("<I", len(faces)) + body


def pc2(samples, points, positions, start=0.0, rate=1.0, version=1):
    """A PC2; `positions` are the bytes after the header."""
    return b"POINTCACHE2\0" + struct.pack("<iiffi", version, points, start, rate, samples) + positions


def mdd(frames, points, times, positions):
    """An MDD."""
    return struct.pack(f">ii{len(times)}f", frames, points, *times) + positions


class Gltf:
    """A glTF with one buffer, made bit by bit; `json` may be changed before it is written."""

    def __init__(self):
        self.bytes = b""
        self.json = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
                     "meshes": [], "accessors": [], "bufferViews": [], "buffers": [{}]}

    def view(self, data, **more):
        """Adds a buffer view."""
        self.bytes += b"\0" * (-len(self.bytes) % 4)
        self.json["bufferViews"].append({"buffer": 0, "byteOffset": len(self.bytes), "byteLength": len(data), **more})
        self.bytes += data
        return len(self.json["bufferViews"]) - 1

    def accessor(self, view, kind, count, component=5126, **more):
        """Adds an accessor."""
        accessor = {"bufferView": view, "componentType": component, "count": count, "type": kind, **more}
        self.json["accessors"].append({key: value for key, value in accessor.items() if value is not None})
        return len(self.json["accessors"]) - 1

    def floats(self, kind, rows, **more):
        """Adds rows of floats."""
        rows = [row if isinstance(row, (tuple, list)) else (row,) for row in rows]
        return self.accessor(self.view(floats(flat(rows))), kind, len(rows), **more)

    def indices(self, faces):
        """Adds corners as 32-bit numbers."""
        corners = flat(faces)
        return self.accessor(self.view(struct.pack(f"<{len(corners)}I", *corners)), "SCALAR", len(corners), 5125)

    def glb(self):
        """The file as GLB."""
        self.json["buffers"] = [{"byteLength": len(self.bytes)}]
        return glb(json.dumps(self.json).encode(), self.bytes)

    def gltf(self):
        """The file as text, with its buffer inside."""
        data = base64.b64encode(self.bytes).decode()
        uri = f"data:application/octet-stream;base64,{data}"
        self.json["buffers"] = [{"byteLength": len(self.bytes), "uri": uri}]
        return json.dumps(self.json).encode()


def glb(text, binary, length=None):
    """A GLB of a JSON and a buffer."""
    text += b" " * (-len(text) % 4)
    binary += b"\0" * (-len(binary) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text
    if binary:
        chunks += struct.pack("<I4s", len(binary), b"BIN\0") + binary
    return b"glTF" + struct.pack("<II", 2, 12 + len(chunks) if length is None else length) + chunks


def tetrahedron(vertices=TETRAHEDRON, faces=FACES, **primitive):
    """A glTF with one mesh."""
    gltf = Gltf()
    position = gltf.floats("VEC3", vertices)
    gltf.json["meshes"] = [
        {"primitives": [{"attributes": {"POSITION": position}, "indices": gltf.indices(faces), **primitive}]}]
    return gltf


def skinned():
    """A glTF with a mesh that two joints move."""
    gltf = tetrahedron()
    attributes = gltf.json["meshes"][0]["primitives"][0]["attributes"]
    attributes["JOINTS_0"] = gltf.accessor(gltf.view(bytes([0, 1, 0, 0] * 4)), "VEC4", 4, 5121)
    attributes["WEIGHTS_0"] = gltf.floats("VEC4", [(0.5, 0.5, 0, 0)] * 4)
    identity = [float(i % 5 == 0) for i in range(16)]
    bind = gltf.floats("MAT4", [identity, identity])
    gltf.json["nodes"] = [{"mesh": 0, "skin": 0}, {}, {}]
    gltf.json["scenes"] = [{"nodes": [0, 1, 2]}]
    gltf.json["skins"] = [{"joints": [1, 2], "inverseBindMatrices": bind}]
    return gltf


def animated(times=(0, 1), values=((0, 0, 0), (1, 0, 0)), path="translation", kind="VEC3"):
    """A glTF whose node moves."""
    gltf = tetrahedron()
    sampler = {"input": gltf.floats("SCALAR", times), "output": gltf.floats(kind, values)}
    channel = {"sampler": 0, "target": {"node": 0, "path": path}}
    gltf.json["animations"] = [{"name": "clip", "samplers": [sampler], "channels": [channel]}]
    return gltf
