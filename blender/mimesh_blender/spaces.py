"""Spaces of objects: what a scale that differs by axis does to a mesh."""

from __future__ import annotations

from typing import Any

import numpy as np

from .messages import Refusal

# Below this the scale counts as equal on all axes, which transfers do not depend on.
_UNEVEN = 1e-4
_SINGULAR = 1e-9


class Space:
    """The space in which the shape of an object is as it looks, up to its size and rotation."""

    def __init__(self, obj: Any) -> None:
        matrix = np.array(obj.matrix_world)[:3, :3]
        _, sizes, axes = np.linalg.svd(matrix)
        if not np.isfinite(matrix).all() or sizes[-1] <= _SINGULAR * max(sizes[0], _SINGULAR):
            raise Refusal(f"{obj.name} is scaled to nothing on an axis", "Give it a scale that is not 0")
        self.is_uneven = bool(sizes[0] > (1 + _UNEVEN) * sizes[-1])
        # Polar decomposition: this is the stretch without the rotation, with 1 as the middle of its sizes.
        relative = sizes / np.cbrt(np.prod(sizes))
        self._stretch = axes.T @ np.diag(relative) @ axes if self.is_uneven else np.eye(3)
        self._inverse = np.linalg.inv(self._stretch)

    def stretched(self, positions: np.ndarray) -> np.ndarray:
        """Positions in this space, from those of the mesh."""
        return positions @ self._stretch.T if self.is_uneven else positions

    def local(self, positions: np.ndarray) -> np.ndarray:
        """Positions of the mesh, from those in this space."""
        return positions @ self._inverse.T if self.is_uneven else positions
