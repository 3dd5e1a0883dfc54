"""The smallest matcher: the vertices that lie farthest along each axis, for meshes that share their axes.

mimesh runs it with two OBJ files and reads the pairs that it prints. A learned matcher stands in the same place.
"""
import json
import sys


def vertices(path):
    with open(path) as lines:
        return [[float(x) for x in line.split()[1:4]] for line in lines if line.startswith("v ")]


source, target = vertices(sys.argv[1]), vertices(sys.argv[2])
pairs = []
for axis in range(3):
    for name, farthest in (("low", min), ("high", max)):
        on_source, on_target = (
            farthest(range(len(mesh)), key=lambda vertex: mesh[vertex][axis]) for mesh in (source, target)
        )
        pairs.append(
            {"name": f"{'xyz'[axis]}-{name}", "source": on_source, "target": on_target, "confidence": 0.3}
        )
print(json.dumps({"pairs": pairs}))
