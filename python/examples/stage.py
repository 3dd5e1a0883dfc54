"""A stage of your own: weights in Python, in a pipeline beside stages of mimesh."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

import mimesh
from mimesh.testing import check_contract


@dataclass
class Shepard(mimesh.Weights, name="shepard"):
    """Weights by inverse distance within a component, straight through space."""

    power: float = mimesh.setting(2.0, "How fast weights fall off.", minimum=0.5, maximum=16)

    def solve(self, surface: mimesh.Surface, handles: NDArray[np.int64], links: Any = ()) -> NDArray[np.float64]:
        # Components that are linked are one.
        group = surface.components.copy()
        for a, b in links:
            group[group == group[b]] = group[a]
        distance = np.linalg.norm(surface.vertices[:, None] - surface.vertices[handles], axis=2)
        distance = np.where(group[:, None] == group[handles], distance, np.inf)
        nearest = distance.min(axis=1, keepdims=True)
        with np.errstate(divide="ignore", invalid="ignore"):
            shares = np.where(distance == nearest, 1.0, (nearest / distance) ** self.power)
        weights: NDArray[np.float64] = shares / shares.sum(axis=1, keepdims=True)
        # A row of zeros says that no handle reaches the vertex.
        weights[~np.isfinite(nearest[:, 0])] = 0
        weights[handles] = np.eye(len(handles))
        return weights


check_contract(Shepard)
horse = mimesh.generators.Quadruped(proportions="horse", gait="gallop", frames=4, resolution=24).generate()
camel = mimesh.generators.Quadruped(proportions="camel", gait="gallop", frames=4, resolution=24, seed=1).generate()
result = mimesh.transfer(horse, camel, transfer=mimesh.transfers.Biharmonic(weights=Shepard(power=3)))
print(result)
