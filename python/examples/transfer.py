"""The gallop of a horse on a camel, without a file and without a click."""

import numpy as np

import mimesh

horse = mimesh.generators.Quadruped(proportions="horse", gait="gallop", frames=4, resolution=30).generate()
camel = mimesh.generators.Quadruped(proportions="camel", gait="gallop", frames=4, resolution=34, seed=1).generate()

result = mimesh.transfer(horse, camel, progress=lambda progress: None)
print(result, result.verdict)
for choice in result.report["choices"]:
    print(f"  {choice['stage']}: {choice['chosen']}, since {choice['why']}")

# The poses are arrays, and the target with them a mesh.
moved: np.ndarray[tuple[int, ...], np.dtype[np.float64]] = np.linalg.norm(result.positions - camel.vertices, axis=2)
print(f"the camel moves by {moved.mean():.3f} on average, and by {moved.max():.3f} at most")
result.save("camel.glb")
